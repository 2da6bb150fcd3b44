//! Positions in a vertex buffer.

use glam::{I16Vec3, U16Vec3, Vec3};

use crate::error::InvalidMesh;

/// The positions of vertices: three numbers each, at a fixed stride in borrowed bytes, in the machine's byte order,
/// aligned or not.
#[derive(Clone, Copy, Debug)]
pub struct Positions<'a> {
    bytes: &'a [u8],
    stride: usize,
    len: usize,
    format: Format,
}

/// The type of the numbers.
#[derive(Clone, Copy, Debug)]
enum Format {
    F32,
    U16 { scale: Vec3, offset: Vec3 },
    I16 { scale: Vec3, offset: Vec3 },
}

impl Format {
    /// The length of three numbers in bytes.
    fn size(&self) -> usize {
        match self {
            Self::F32 => 12,
            Self::U16 { .. } | Self::I16 { .. } => 6,
        }
    }
}

impl<'a> Positions<'a> {
    /// Three `f32` each, the first at the byte `first`, the next `stride` bytes farther. The last needs no bytes behind
    /// its three numbers.
    ///
    /// # Errors
    /// [`InvalidMesh::BadStride`] if the stride is less than the 12 bytes of a position.
    pub fn f32(bytes: &'a [u8], first: usize, stride: usize) -> Result<Self, InvalidMesh> {
        Self::new(bytes, first, stride, Format::F32)
    }

    /// Three `u16` each, likewise, at least 6 bytes apart. A position is `q * scale + offset`, each operation rounded
    /// to `f32`.
    ///
    /// # Errors
    /// The errors of [`f32`](Self::f32).
    pub fn u16(bytes: &'a [u8], first: usize, stride: usize, scale: Vec3, offset: Vec3) -> Result<Self, InvalidMesh> {
        Self::new(bytes, first, stride, Format::U16 { scale, offset })
    }

    /// Three `i16` each, likewise, at least 6 bytes apart. A position is `q * scale + offset`, each operation rounded
    /// to `f32`.
    ///
    /// # Errors
    /// The errors of [`f32`](Self::f32).
    pub fn i16(bytes: &'a [u8], first: usize, stride: usize, scale: Vec3, offset: Vec3) -> Result<Self, InvalidMesh> {
        Self::new(bytes, first, stride, Format::I16 { scale, offset })
    }

    fn new(bytes: &'a [u8], first: usize, stride: usize, format: Format) -> Result<Self, InvalidMesh> {
        let size = format.size();
        if stride < size {
            return Err(InvalidMesh::BadStride { stride, least: size });
        }
        let bytes = bytes.get(first..).unwrap_or(&[]);
        let len = if bytes.len() < size { 0 } else { (bytes.len() - size) / stride + 1 };
        Ok(Self { bytes, stride, len, format })
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The position of a vertex; NaN if it does not exist.
    #[inline]
    pub fn get(&self, vertex: usize) -> Vec3 {
        let Some(bytes) = self.bytes.get(vertex.saturating_mul(self.stride)..) else {
            return Vec3::NAN;
        };
        match self.format {
            Format::F32 => match bytes.first_chunk::<12>() {
                Some(bytes) => bytemuck::pod_read_unaligned(bytes),
                None => Vec3::NAN,
            },
            Format::U16 { scale, offset } => match bytes.first_chunk::<6>() {
                Some(bytes) => bytemuck::pod_read_unaligned::<U16Vec3>(bytes).as_vec3() * scale + offset,
                None => Vec3::NAN,
            },
            Format::I16 { scale, offset } => match bytes.first_chunk::<6>() {
                Some(bytes) => bytemuck::pod_read_unaligned::<I16Vec3>(bytes).as_vec3() * scale + offset,
                None => Vec3::NAN,
            },
        }
    }
}

impl<'a> From<&'a [Vec3]> for Positions<'a> {
    fn from(positions: &'a [Vec3]) -> Self {
        let bytes = bytemuck::cast_slice(positions);
        Self { bytes, stride: size_of::<Vec3>(), len: positions.len(), format: Format::F32 }
    }
}

impl<'a> From<&'a [[f32; 3]]> for Positions<'a> {
    fn from(positions: &'a [[f32; 3]]) -> Self {
        Self { bytes: bytemuck::cast_slice(positions), stride: 12, len: positions.len(), format: Format::F32 }
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use glam::vec3;

    use super::*;

    #[test]
    fn positions_are_where_stride_and_format_say() {
        let numbers: Vec<f32> = (0..20).map(|i| i as f32 * 0.5).collect();
        let positions = Positions::f32(bytemuck::cast_slice(&numbers), 8, 20).unwrap();
        // 18 numbers from the third on, five apart: the fourth position has its three.
        assert_eq!(positions.len(), 4);
        for i in 0..4 {
            let x = (2 + 5 * i) as f32 * 0.5;
            assert_eq!(positions.get(i), vec3(x, x + 0.5, x + 1.0));
        }
        assert!(positions.get(4).is_nan() && positions.get(usize::MAX).is_nan());
        // Not aligned.
        let mut bytes = Vec::from([7u8]);
        bytes.extend_from_slice(bytemuck::cast_slice(&numbers));
        assert_eq!(Positions::f32(&bytes, 1, 12).unwrap().get(1), vec3(1.5, 2.0, 2.5));
    }

    #[test]
    fn quantised_positions_are_scaled_and_moved() {
        let unsigned: [u16; 7] = [0, 1, 65535, 9, 10, 20, 30];
        let scale = vec3(2.0, 0.5, 1.0 / 65535.0);
        let positions = Positions::u16(bytemuck::cast_slice(&unsigned), 0, 8, scale, Vec3::ONE).unwrap();
        assert_eq!((positions.len(), positions.get(0)), (2, vec3(1.0, 1.5, 2.0)));
        let signed: [i16; 3] = [-32768, -1, 32767];
        let positions = Positions::i16(bytemuck::cast_slice(&signed), 0, 6, Vec3::ONE, Vec3::ZERO).unwrap();
        assert_eq!((positions.len(), positions.get(0)), (1, vec3(-32768.0, -1.0, 32767.0)));
    }

    #[test]
    fn too_few_bytes_are_no_positions() {
        for (bytes, first, count) in [(11, 0, 0), (12, 0, 1), (12, 1, 0), (24, 0, 2), (0, 5, 0), (23, 11, 1)] {
            let bytes: Vec<u8> = core::iter::repeat_n(0, bytes).collect();
            let positions = Positions::f32(&bytes, first, 12).unwrap();
            assert_eq!((positions.len(), positions.is_empty()), (count, count == 0));
        }
        assert_eq!(Positions::f32(&[], 0, 11).err(), Some(InvalidMesh::BadStride { stride: 11, least: 12 }));
        let quantised = Positions::u16(&[], 0, 5, Vec3::ONE, Vec3::ZERO);
        assert_eq!(quantised.err(), Some(InvalidMesh::BadStride { stride: 5, least: 6 }));
    }
}
