//! Rays and hits in packets, as structures of arrays.

use bytemuck::Zeroable;

use super::{Hit, Ray};
use crate::simd::{Lanes, Portable, Simd};

/// `N` rays as a structure of arrays; fields as in [`Ray`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct RayPacket<const N: usize> {
    /// Origins: all x, all y, all z.
    pub origin: [[f32; N]; 3],
    /// Directions: all x, all y, all z.
    pub direction: [[f32; N]; 3],
    /// Least `t`.
    pub t_min: [f32; N],
    /// Greatest `t`.
    pub t_max: [f32; N],
    /// Bit `i` says whether ray `i` is to be traced.
    pub active: u32,
}

/// `N` hits as a structure of arrays; fields as in [`Hit`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct HitPacket<const N: usize> {
    /// Distances.
    pub t: [f32; N],
    /// Barycentric weights of the second corners.
    pub u: [f32; N],
    /// Barycentric weights of the third corners.
    pub v: [f32; N],
    /// Triangles.
    pub prim_id: [u32; N],
}

impl<const N: usize> RayPacket<N> {
    /// Packs up to `N` rays, `N` at most 32; lanes beyond them are inactive, and further rays are ignored.
    pub fn from_rays(rays: &[Ray]) -> Self {
        const { assert!(N <= 32, "a mask has 32 bits") };
        match rays.first_chunk() {
            Some(rays) => Self::from_array(rays),
            None => {
                let mut all = [Ray::zeroed(); N];
                all[..rays.len()].copy_from_slice(rays);
                Self { active: (1 << rays.len()) - 1, ..Self::from_array(&all) }
            }
        }
    }

    /// Packs `N` rays, all of them active.
    #[inline(always)]
    fn from_array(rays: &[Ray; N]) -> Self {
        let mut rows = [[0.0; N]; 8];
        let (eights, rest) = rays.as_chunks::<8>();
        for (eight, rays) in eights.iter().enumerate() {
            let lanes = Portable::transpose(rays.map(|ray| <Portable as Simd>::F8::load(bytemuck::cast_ref(&ray))));
            for (row, lanes) in rows.iter_mut().zip(lanes) {
                row[8 * eight..8 * eight + 8].copy_from_slice(&lanes.store());
            }
        }
        for (lane, ray) in (8 * eights.len()..).zip(rest) {
            for (row, &number) in rows.iter_mut().zip(bytemuck::cast_ref::<Ray, [f32; 8]>(ray)) {
                row[lane] = number;
            }
        }
        let [ox, oy, oz, t_min, dx, dy, dz, t_max] = rows;
        let active = ((1u64 << N) - 1) as u32;
        Self { origin: [ox, oy, oz], direction: [dx, dy, dz], t_min, t_max, active }
    }

    /// The lanes of the active rays.
    pub(crate) fn active_lanes(&self) -> impl Iterator<Item = usize> + use<N> {
        crate::simd::lanes_of(self.active & ((1u64 << N) - 1) as u32)
    }

    /// The ray in a lane.
    ///
    /// # Panics
    /// If `lane` is `N` or more.
    pub fn ray(&self, lane: usize) -> Ray {
        let vector = |v: &[[f32; N]; 3]| glam::Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
        Ray {
            origin: vector(&self.origin),
            t_min: self.t_min[lane],
            direction: vector(&self.direction),
            t_max: self.t_max[lane],
        }
    }
}

impl<const N: usize> HitPacket<N> {
    /// Misses in all lanes.
    pub const MISS: Self =
        Self { t: [Hit::MISS.t; N], u: [Hit::MISS.u; N], v: [Hit::MISS.v; N], prim_id: [Hit::MISS.prim_id; N] };

    /// The hit in a lane.
    ///
    /// # Panics
    /// If `lane` is `N` or more.
    pub fn hit(&self, lane: usize) -> Hit {
        Hit { t: self.t[lane], u: self.u[lane], v: self.v[lane], prim_id: self.prim_id[lane] }
    }

    /// Sets the hit in a lane.
    ///
    /// # Panics
    /// If `lane` is `N` or more.
    pub fn set(&mut self, lane: usize, hit: Hit) {
        (self.t[lane], self.u[lane], self.v[lane], self.prim_id[lane]) = (hit.t, hit.u, hit.v, hit.prim_id);
    }
}
