//! Rays and hits in scenes in packets, as structures of arrays.

use core::array;

use bytemuck::Zeroable;

use super::{SceneHit, SceneRay};
use crate::geometry::{HitPacket, Ray, RayPacket};

/// `N` rays in a scene as a structure of arrays; fields as in [`SceneRay`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct SceneRayPacket<const N: usize> {
    /// The rays, and which of them are to be traced.
    pub rays: RayPacket<N>,
    /// Times in 0..=1; other times are clamped. With NaN a ray hits nothing.
    pub time: [f32; N],
    /// Masks: a ray sees items whose mask has a bit in common with its own.
    pub mask: [u32; N],
}

/// `N` hits in a scene as a structure of arrays; fields as in [`SceneHit`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct SceneHitPacket<const N: usize> {
    /// The hits in the items' geometry.
    pub hits: HitPacket<N>,
    /// The items' indices, each in the scene that has the item.
    pub item: [u32; N],
    /// The numbers of nested scenes around the items.
    pub depth: [u32; N],
    /// The indices of the paths to the items.
    pub path: [u64; N],
}

impl<const N: usize> SceneRayPacket<N> {
    /// Packs up to `N` rays, `N` at most 32; lanes beyond them are inactive, and further rays are ignored.
    pub fn from_rays(rays: &[SceneRay]) -> Self {
        let len = rays.len().min(N);
        let (mut all, mut time, mut mask) = ([Ray::zeroed(); N], [0.0; N], [u32::MAX; N]);
        for (lane, ray) in rays.iter().enumerate().take(N) {
            (all[lane], time[lane], mask[lane]) = (ray.ray, ray.time, ray.mask);
        }
        Self { rays: RayPacket::from_rays(&all[..len]), time, mask }
    }

    /// The ray in a lane.
    ///
    /// # Panics
    /// If `lane` is `N` or more.
    pub fn ray(&self, lane: usize) -> SceneRay {
        SceneRay { ray: self.rays.ray(lane), time: self.time[lane], mask: self.mask[lane] }
    }
}

impl<const N: usize> SceneRayPacket<N> {
    /// The rays from a lane on, inactive where there are none.
    pub(super) fn part<const M: usize>(&self, first: usize) -> SceneRayPacket<M> {
        let RayPacket { origin, direction, t_min, t_max, active } = &self.rays;
        let rays = RayPacket {
            origin: origin.each_ref().map(|axis| part(axis, first)),
            direction: direction.each_ref().map(|axis| part(axis, first)),
            t_min: part(t_min, first),
            t_max: part(t_max, first),
            active: active >> first & ((1u64 << M) - 1) as u32,
        };
        SceneRayPacket { rays, time: part(&self.time, first), mask: part(&self.mask, first) }
    }
}

impl<const N: usize> SceneHitPacket<N> {
    /// The hits from a lane on.
    pub(super) fn part<const M: usize>(&self, first: usize) -> SceneHitPacket<M> {
        let HitPacket { t, u, v, prim_id } = &self.hits;
        let [t, u, v] = [t, u, v].map(|lanes| part(lanes, first));
        SceneHitPacket {
            hits: HitPacket { t, u, v, prim_id: part(prim_id, first) },
            item: part(&self.item, first),
            depth: part(&self.depth, first),
            path: part(&self.path, first),
        }
    }
}

/// The elements from `first` on, or zeros.
fn part<T: Copy + Default, const N: usize, const M: usize>(all: &[T; N], first: usize) -> [T; M] {
    array::from_fn(|lane| all.get(first + lane).copied().unwrap_or_default())
}

/// Rays at time 0 that see all items.
impl<const N: usize> From<RayPacket<N>> for SceneRayPacket<N> {
    fn from(rays: RayPacket<N>) -> Self {
        Self { rays, time: [0.0; N], mask: [u32::MAX; N] }
    }
}

impl<const N: usize> SceneHitPacket<N> {
    /// Misses in all lanes.
    pub const MISS: Self = Self {
        hits: HitPacket::MISS,
        item: [SceneHit::MISS.item; N],
        depth: [SceneHit::MISS.depth; N],
        path: [SceneHit::MISS.path; N],
    };

    /// The hit in a lane.
    ///
    /// # Panics
    /// If `lane` is `N` or more.
    pub fn hit(&self, lane: usize) -> SceneHit {
        let hit = self.hits.hit(lane);
        SceneHit { hit, item: self.item[lane], depth: self.depth[lane], path: self.path[lane] }
    }

    /// Sets the hit in a lane.
    ///
    /// # Panics
    /// If `lane` is `N` or more.
    pub fn set(&mut self, lane: usize, hit: SceneHit) {
        self.hits.set(lane, hit.hit);
        (self.item[lane], self.depth[lane], self.path[lane]) = (hit.item, hit.depth, hit.path);
    }
}
