//! Rays and hits in packets, as structures of arrays.

use super::{Hit, Ray};
use crate::simd::{Lanes, Portable, Simd};

/// `N` rays; component-wise what [`Ray`] is.
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

/// `N` hits; component-wise what [`Hit`] is.
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
        let mut packet = Self {
            origin: [[0.0; N]; 3],
            direction: [[0.0; N]; 3],
            t_min: [0.0; N],
            t_max: [0.0; N],
            active: (1u64 << N.min(rays.len())).wrapping_sub(1) as u32,
        };
        let eights = rays.as_chunks::<8>().0.iter().take(N / 8);
        let together = 8 * eights.len();
        for (eight, rays) in eights.enumerate() {
            packet.set_eight(8 * eight, rays);
        }
        for (lane, ray) in rays.iter().enumerate().take(N).skip(together) {
            for axis in 0..3 {
                packet.origin[axis][lane] = ray.origin[axis];
                packet.direction[axis][lane] = ray.direction[axis];
            }
            (packet.t_min[lane], packet.t_max[lane]) = (ray.t_min, ray.t_max);
        }
        packet
    }

    /// Packs eight rays into the lanes from `first` on.
    fn set_eight(&mut self, first: usize, rays: &[Ray; 8]) {
        type F8 = <Portable as Simd>::F8;
        let rows = rays.map(|ray| F8::load(bytemuck::cast_ref(&ray)));
        let [ox, oy, oz, t_min, dx, dy, dz, t_max] = Portable::transpose(rows);
        let set = |numbers: &mut [f32; N], lanes: F8| numbers[first..first + 8].copy_from_slice(&lanes.store());
        let ([px, py, pz], [qx, qy, qz]) = (&mut self.origin, &mut self.direction);
        set(px, ox);
        set(py, oy);
        set(pz, oz);
        set(&mut self.t_min, t_min);
        set(qx, dx);
        set(qy, dy);
        set(qz, dz);
        set(&mut self.t_max, t_max);
    }

    /// The lanes of the active rays.
    pub(crate) fn active_lanes(&self) -> impl Iterator<Item = usize> + use<N> {
        crate::simd::lanes_of(self.active & ((1u64 << N) - 1) as u32)
    }

    /// Ray `lane`; `lane < N`.
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

    /// Hit `lane`; `lane < N`.
    pub fn hit(&self, lane: usize) -> Hit {
        Hit { t: self.t[lane], u: self.u[lane], v: self.v[lane], prim_id: self.prim_id[lane] }
    }

    /// Sets hit `lane`; `lane < N`.
    pub fn set(&mut self, lane: usize, hit: Hit) {
        (self.t[lane], self.u[lane], self.v[lane], self.prim_id[lane]) = (hit.t, hit.u, hit.v, hit.prim_id);
    }
}
