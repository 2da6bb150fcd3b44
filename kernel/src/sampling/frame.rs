//! An orthonormal basis about a normal, without a branch.
//!
//! Duff, Burgess, Christensen, Hery, Kensler, Liani and Villemin, "Building an orthonormal basis, revisited" (2017):
//! with s = ±1 the sign of n_z and a = -1/(s + n_z),
//!
//! t = (1 + s a n_x², s a n_x n_y, -s n_x),  b = (a n_x n_y, s + a n_y², -n_y).

use glam::Vec3;

use super::batch::{Function, apply_many};
use crate::simd::Isa;

/// A right-handed orthonormal basis: tangent × bitangent = normal. Locally they are x, y and z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The local x axis.
    pub tangent: Vec3,
    /// The local y axis.
    pub bitangent: Vec3,
    /// The local z axis.
    pub normal: Vec3,
}

impl Frame {
    /// The frame about a unit normal. It turns continuously with the normal save across n_z = 0, and every unit normal
    /// has one, (0, 0, -1) too.
    #[inline(always)]
    pub fn from_normal(normal: Vec3) -> Self {
        let sign = 1f32.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            tangent: Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            bitangent: Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    /// [`from_normal`](Self::from_normal) of each normal, with the instructions of `isa`: equal bit for bit. Elements
    /// beyond the end of the shorter slice are left unchanged.
    pub fn from_normals(isa: Isa, normals: &[Vec3], frames: &mut [Self]) {
        apply_many(isa, FromNormal, normals, frames);
    }

    /// A world vector in local coordinates.
    #[inline]
    pub fn to_local(&self, world: Vec3) -> Vec3 {
        Vec3::new(world.dot(self.tangent), world.dot(self.bitangent), world.dot(self.normal))
    }

    /// A local vector in world coordinates: the inverse of [`to_local`](Self::to_local).
    #[inline(always)]
    pub fn to_world(&self, local: Vec3) -> Vec3 {
        self.tangent * local.x + self.bitangent * local.y + self.normal * local.z
    }
}

struct FromNormal;

impl Function for FromNormal {
    type Input = Vec3;
    type Output = Frame;
    #[inline(always)]
    fn apply(&self, normal: Vec3) -> Frame {
        Frame::from_normal(normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checksums::Checksum;
    use crate::sampling::warp::{UniformSphere, Warp};
    use crate::sampling::{Pattern, Sampler};
    use crate::simd::isas;

    fn normals() -> impl Iterator<Item = Vec3> {
        let special = [0.0, -0.0, 1.0, -1.0, 1e-20, -1e-20];
        let axes = special.into_iter().flat_map(move |x| {
            special.into_iter().flat_map(move |y| special.into_iter().map(move |z| Vec3::new(x, y, z)))
        });
        let axes = axes.filter(|n| n.length_squared() > 0.5).map(Vec3::normalize);
        let beside_the_pole = (0..1000).map(|i| Vec3::new(i as f32 * 1e-6, i as f32 * -3e-7, -1.0).normalize());
        let sphere = (0..10_000).map(|i| UniformSphere.map(Sampler::new(Pattern::Sobol, 1, 0, i).uniform2(0)));
        axes.chain(beside_the_pole).chain(sphere)
    }

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for n in normals() {
            let Frame { tangent: t, bitangent: b, normal } = Frame::from_normal(n);
            assert_eq!(normal, n);
            for (name, error) in [
                ("t·t", t.length_squared() - 1.0),
                ("b·b", b.length_squared() - 1.0),
                ("t·b", t.dot(b)),
                ("t·n", t.dot(n)),
                ("b·n", b.dot(n)),
                ("t×b", (t.cross(b) - n).length()),
            ] {
                assert!(error.abs() < 1e-6, "{name} of {n:?}: {error}");
            }
        }
    }

    #[test]
    fn poles_are_exact() {
        assert_eq!(Frame::from_normal(Vec3::Z), Frame { tangent: Vec3::X, bitangent: Vec3::Y, normal: Vec3::Z });
        let south = Frame { tangent: Vec3::X, bitangent: -Vec3::Y, normal: -Vec3::Z };
        assert_eq!(Frame::from_normal(-Vec3::Z), south);
    }

    #[test]
    fn local_and_world_are_inverse() {
        let v = Vec3::new(0.3, -2.0, 1.25);
        for n in normals() {
            let frame = Frame::from_normal(n);
            assert!((frame.to_world(frame.to_local(v)) - v).length() < 3e-6);
            assert!((frame.to_local(frame.to_world(v)) - v).length() < 3e-6);
            assert!((frame.to_world(Vec3::Z) - n).length() < 1e-7);
        }
    }

    #[test]
    fn batches_equal_single_frames_bit_for_bit() {
        let normals: Vec<_> = normals().collect();
        let none = Frame { tangent: Vec3::ZERO, bitangent: Vec3::ZERO, normal: Vec3::ZERO };
        let mut frames = vec![none; normals.len()];
        let bits = |f: &Frame| [f.tangent, f.bitangent, f.normal].map(|v| v.to_array().map(f32::to_bits));
        for isa in isas() {
            frames.fill(none);
            Frame::from_normals(isa, &normals, &mut frames);
            for (frame, &n) in frames.iter().zip(&normals) {
                assert_eq!(bits(frame), bits(&Frame::from_normal(n)), "{n} on {isa:?}");
            }
        }
    }

    #[test]
    fn golden() {
        let mut sum = Checksum::new();
        for n in normals() {
            let frame = Frame::from_normal(n);
            sum.add([frame.tangent, frame.bitangent].iter().flat_map(|v| v.to_array()));
        }
        assert_eq!(sum.value(), 0xA339_7D28_7BB6_A34A, "{:#018X}", sum.value());
    }
}
