//! `EXT_meshopt_compression`: buffer views in the bit streams of Arseny Kapoulkine's meshoptimizer, as the extension's
//! specification defines them (appendices A and B).
//!
//! This decoder is our own, since those on crates.io bind a C++ library or read only an older stream. Output grows as
//! its input is read, so a short file cannot claim much memory.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use ::gltf::json::{Buffer, Root};
use serde::Deserialize;

use crate::scene::{Place, SceneError};

/// The extension's data of a buffer view.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Compression {
    buffer: usize,
    #[serde(default)]
    byte_offset: u64,
    byte_length: u64,
    byte_stride: usize,
    count: usize,
    mode: Mode,
    #[serde(default)]
    filter: Filter,
}

/// The kinds of streams.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

/// What is done to attributes afterwards.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
}

const NAME: &str = "EXT_meshopt_compression";

/// The bytes of all buffer views that are compressed, by their indices.
pub(super) fn decompress(
    path: &Path,
    root: &Root,
    buffers: &[Cow<[u8]>],
) -> Result<BTreeMap<usize, Vec<u8>>, SceneError> {
    let mut decompressed = BTreeMap::new();
    for (number, view) in root.buffer_views.iter().enumerate() {
        let objects = view.extensions.as_ref().map(|extensions| &extensions.others);
        let Some(value) = objects.and_then(|objects| objects.get(NAME)) else { continue };
        let error = |problem: String| {
            let place = Place::Part(format!("bufferView {number}"));
            SceneError::new(path, place, problem, "export the model again, without meshopt compression")
        };
        let it = Compression::deserialize(value).map_err(|cause| error(format!("its {NAME} is wrong: {cause}")))?;
        let buffer = buffers
            .get(it.buffer)
            .ok_or_else(|| error(format!("it refers to buffer {}, which does not exist", it.buffer)))?;
        let start = usize::try_from(it.byte_offset).unwrap_or(usize::MAX);
        let end = start.saturating_add(usize::try_from(it.byte_length).unwrap_or(usize::MAX));
        let data =
            buffer.get(start..end).ok_or_else(|| error(format!("its stream goes beyond buffer {}", it.buffer)))?;
        decompressed.insert(number, decode(&it, data).map_err(error)?);
    }
    Ok(decompressed)
}

/// Whether a buffer is only a place for what compressed views hold.
pub(super) fn is_fallback(buffer: &Buffer) -> bool {
    let objects = buffer.extensions.as_ref().map(|extensions| &extensions.others);
    objects.and_then(|objects| objects.get(NAME)).is_some_and(|it| it["fallback"] == true)
}

/// The bytes of a buffer view; or what is wrong with it.
fn decode(compression: &Compression, data: &[u8]) -> Result<Vec<u8>, String> {
    let &Compression { byte_stride: stride, count, mode, filter, .. } = compression;
    match mode {
        Mode::Attributes => {
            if stride == 0 || stride > 256 || stride % 4 != 0 {
                return Err(format!("its stride is {stride}, which is no multiple of 4 from 4 to 256"));
            }
            let mut bytes = attributes(data, count, stride)?;
            apply(filter, &mut bytes, stride)?;
            Ok(bytes)
        }
        Mode::Triangles => {
            if count % 3 != 0 {
                return Err(format!("its triangles have {count} corners together"));
            }
            Ok(narrow(triangles(data, count / 3)?, index_size(stride)?))
        }
        Mode::Indices => Ok(narrow(indices(data, count)?, index_size(stride)?)),
    }
}

/// The reader of a stream.
struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// The stream after its first byte, which must be `header`.
    fn new(data: &'a [u8], header: u8) -> Result<Self, String> {
        match data.split_first() {
            Some((&first, rest)) if first == header => Ok(Self { rest }),
            Some((first, _)) => Err(format!("its stream begins with {first:#x} instead of {header:#x}")),
            None => Err(CUT.to_owned()),
        }
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or(CUT)?;
        self.rest = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, String> {
        self.take(1).map(|bytes| bytes[0])
    }

    /// A number of seven bits a byte, the lowest first.
    fn varint(&mut self) -> Result<u32, String> {
        let mut number = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7f).wrapping_shl(shift);
            if byte < 0x80 {
                break;
            }
        }
        Ok(number)
    }
}

const CUT: &str = "its stream is cut short";

/// A difference whose lowest bit is its sign.
fn unzigzag(code: u32) -> u32 {
    (code >> 1) ^ (code & 1).wrapping_neg()
}

/// Bytes in blocks of vertices; in a block, byte by byte of the stride, as differences to the vertex before.
fn attributes(data: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    const GROUP: usize = 16;
    let mut reader = Reader::new(data, 0xa0)?;
    // The stream ends with the vertex before the first, padded at its start to 32 bytes.
    let tail = reader.rest.len().checked_sub(stride.max(32)).ok_or(CUT)?;
    let mut last = reader.rest[reader.rest.len() - stride..].to_vec();
    reader.rest = &reader.rest[..tail];
    let block_size = (8192 / stride / GROUP * GROUP).min(256);
    let mut bytes = Vec::new();
    while bytes.len() < count * stride {
        let start = bytes.len();
        let vertices = (count - start / stride).min(block_size);
        let groups = vertices.div_ceil(GROUP);
        bytes.resize(start + vertices * stride, 0);
        for (slot, previous) in last.iter_mut().enumerate() {
            let header = reader.take(groups.div_ceil(4))?;
            for group in 0..groups {
                let differences = group_of(&mut reader, (header[group / 4] >> (2 * (group % 4))) & 3)?;
                for (place, difference) in differences.into_iter().enumerate() {
                    let vertex = group * GROUP + place;
                    if vertex < vertices {
                        *previous = previous.wrapping_add(unzigzag(difference.into()) as u8);
                        bytes[start + vertex * stride + slot] = *previous;
                    }
                }
            }
        }
    }
    Ok(bytes)
}

/// Sixteen differences of 0, 2, 4 or 8 bits; the greatest of 2 or 4 bits stands for a byte that follows.
fn group_of(reader: &mut Reader, kind: u8) -> Result<[u8; 16], String> {
    let bits = match kind {
        0 => return Ok([0; 16]),
        3 => return Ok(reader.take(16)?.try_into().expect("sixteen bytes")),
        kind => 2 * usize::from(kind),
    };
    let packed = reader.take(2 * bits)?;
    let (per_byte, escape) = (8 / bits, (1 << bits) - 1);
    let mut group = [0; 16];
    for (place, number) in group.iter_mut().enumerate() {
        let shift = 8 - bits * (place % per_byte + 1);
        *number = (packed[place / per_byte] >> shift) & escape;
        if *number == escape {
            *number = reader.byte()?;
        }
    }
    Ok(group)
}

/// Edges and vertices that were used lately.
struct Lately<T> {
    ring: [T; 16],
    next: usize,
}

impl<T: Copy + Default> Lately<T> {
    fn new() -> Self {
        Self { ring: [T::default(); 16], next: 0 }
    }

    fn push(&mut self, item: T) {
        self.ring[self.next % 16] = item;
        self.next += 1;
    }

    /// The item that was pushed `back` ago, 1 for the latest.
    fn back(&self, back: usize) -> T {
        self.ring[(self.next + 16 - back) % 16]
    }
}

/// Corners of triangles that share edges with those before.
fn triangles(data: &[u8], count: usize) -> Result<Vec<u32>, String> {
    let mut reader = Reader::new(data, 0xe1)?;
    let codes = reader.take(count)?;
    let (rest, table) = reader.rest.split_last_chunk::<16>().ok_or(CUT)?;
    reader.rest = rest;
    let (mut edges, mut vertices) = (Lately::<[u32; 2]>::new(), Lately::<u32>::new());
    // The number of vertices so far, and the last that was written out.
    let (mut new, mut last) = (0_u32, 0_u32);
    let next_new = |new: &mut u32| {
        *new = new.wrapping_add(1);
        new.wrapping_sub(1)
    };
    let mut corners = Vec::with_capacity(3 * count);
    for &code in codes {
        let (high, low) = (usize::from(code >> 4), usize::from(code & 15));
        if high < 15 {
            let [a, b] = edges.back(1 + high);
            let c = match low {
                0 => next_new(&mut new),
                1..=12 => vertices.back(1 + low),
                13 => last.wrapping_sub(1),
                14 => last.wrapping_add(1),
                _ => last.wrapping_add(unzigzag(reader.varint()?)),
            };
            if low == 0 || low > 12 {
                vertices.push(c);
            }
            if low > 12 {
                last = c;
            }
            corners.extend([a, b, c]);
            edges.push([c, b]);
            edges.push([a, c]);
            continue;
        }
        let (first, others) = match low {
            14 | 15 => (if low == 14 { 0 } else { 15 }, reader.byte()?),
            low => (0, table[low]),
        };
        if low >= 14 && others == 0 {
            new = 0;
        }
        let kinds = [first, usize::from(others >> 4), usize::from(others & 15)];
        // All that is new is counted before what is written out is read, and the ring stays as it is meanwhile.
        let mut triangle = kinds.map(|kind| match kind {
            0 => next_new(&mut new),
            15 => 0,
            back => vertices.back(back),
        });
        for (corner, kind) in triangle.iter_mut().zip(kinds) {
            if kind == 15 {
                last = last.wrapping_add(unzigzag(reader.varint()?));
                *corner = last;
            }
        }
        for (corner, kind) in triangle.into_iter().zip(kinds) {
            if matches!(kind, 0 | 15) {
                vertices.push(corner);
            }
        }
        let [a, b, c] = triangle;
        corners.extend(triangle);
        edges.push([b, a]);
        edges.push([c, b]);
        edges.push([a, c]);
    }
    Ok(corners)
}

/// Indices as differences to one of two that went before.
fn indices(data: &[u8], count: usize) -> Result<Vec<u32>, String> {
    let mut reader = Reader::new(data, 0xd1)?;
    let mut last = [0_u32; 2];
    let mut indices = Vec::new();
    for _ in 0..count {
        let code = reader.varint()?;
        let last = &mut last[(code & 1) as usize];
        *last = last.wrapping_add(unzigzag(code >> 1));
        indices.push(*last);
    }
    Ok(indices)
}

fn index_size(stride: usize) -> Result<usize, String> {
    if matches!(stride, 2 | 4) { Ok(stride) } else { Err(format!("its indices have {stride} bytes")) }
}

/// Indices of two or four bytes.
fn narrow(indices: Vec<u32>, size: usize) -> Vec<u8> {
    indices.into_iter().flat_map(|index| index.to_le_bytes().into_iter().take(size)).collect()
}

fn apply(filter: Filter, bytes: &mut [u8], stride: usize) -> Result<(), String> {
    let wrong = || Err(format!("its filter {filter:?} does not go with a stride of {stride}"));
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => {
            for vector in bytes.chunks_exact_mut(4) {
                let [x, y, one] = [0, 1, 2].map(|slot| f32::from(vector[slot] as i8));
                let unit = octahedral(x, y, one, 127.0);
                [0, 1, 2].into_iter().zip(unit).for_each(|(slot, number)| vector[slot] = number as i8 as u8);
            }
        }
        (Filter::Octahedral, 8) => {
            for vector in bytes.chunks_exact_mut(8) {
                let [x, y, one, _] = shorts(vector).map(f32::from);
                let [x, y, z] = octahedral(x, y, one, 32767.0).map(|number| number as i16);
                write(vector, [x, y, z, shorts(vector)[3]]);
            }
        }
        (Filter::Octahedral, _) => return wrong(),
        (Filter::Quaternion, 8) => {
            for quaternion in bytes.chunks_exact_mut(8) {
                write(quaternion, full_quaternion(shorts(quaternion)));
            }
        }
        (Filter::Quaternion, _) => return wrong(),
        (Filter::Exponential, _) => {
            for number in bytes.as_chunks_mut::<4>().0 {
                let code = i32::from_le_bytes(*number);
                let (mantissa, exponent) = ((code << 8) >> 8, code >> 24);
                *number = ((f64::from(mantissa) * f64::from(exponent).exp2()) as f32).to_le_bytes();
            }
        }
    }
    Ok(())
}

/// A unit vector from its place on an octahedron, of which `one` is the extent, times `scale` and rounded.
fn octahedral(x: f32, y: f32, one: f32, scale: f32) -> [f32; 3] {
    let z = one - x.abs() - y.abs();
    let fold = z.min(0.0);
    let unfold = |number: f32| number + if number >= 0.0 { fold } else { -fold };
    let (x, y) = (unfold(x), unfold(y));
    let length = (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|number| (number * (scale / length)).round())
}

/// A quaternion from its three smaller components; which one is left out stands in the lowest bits of the last number.
fn full_quaternion([x, y, z, last]: [i16; 4]) -> [i16; 4] {
    let scale = core::f32::consts::FRAC_1_SQRT_2 / f32::from(last | 3);
    let small = [x, y, z].map(|number| f32::from(number) * scale);
    let rest = 1.0 - small.iter().map(|number| number * number).sum::<f32>();
    let first = (last & 3) as usize;
    let mut full = [0; 4];
    for (place, number) in [rest.max(0.0).sqrt(), small[0], small[1], small[2]].into_iter().enumerate() {
        full[(first + place) % 4] = (number * 32767.0).round() as i16;
    }
    full
}

fn shorts(bytes: &[u8]) -> [i16; 4] {
    core::array::from_fn(|place| i16::from_le_bytes([bytes[2 * place], bytes[2 * place + 1]]))
}

fn write(bytes: &mut [u8], numbers: [i16; 4]) {
    for (place, number) in numbers.into_iter().enumerate() {
        bytes[2 * place..2 * place + 2].copy_from_slice(&number.to_le_bytes());
    }
}

#[cfg(test)]
mod tests;
