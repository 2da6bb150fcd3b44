//! tinybvh: its tree of 8 children for AVX2, built in high quality.
//!
//! The Rust binding has no any-hit query, so the nearest hit stands in for it, and none to ask how much memory the tree
//! takes.

use halfdome_benches::tracer::Tracer;
use halfdome_kernel::{Hit, Ray, Triangle};
use tinybvh_rs::{INFINITE, Intersector, bvh, bvh8_cpu, mbvh};

use crate::trees::Peer;

/// The most triangles that this layout takes in a leaf.
const LEAF: u32 = 4;

/// A tree of tinybvh's.
pub(crate) struct Tinybvh(bvh8_cpu::BVH);

impl Tinybvh {
    /// Builds a tree over `triangles` with spatial splits, on one thread.
    pub(crate) fn build(triangles: &[Triangle]) -> Result<Self, tinybvh_rs::Error> {
        let corners: Vec<[f32; 4]> = triangles.as_flattened().iter().map(|p| p.extend(0.0).to_array()).collect();
        let mut binary = bvh::BVH::new_hq(corners.as_slice().into())?;
        binary.split_leaves(LEAF);
        Ok(Self(bvh8_cpu::BVH::new(&mbvh::BVH::new(&binary))?))
    }

    /// The nearest hit before `t_max`.
    #[inline]
    fn trace(&self, ray: &Ray) -> Hit {
        let mut query = tinybvh_rs::Ray::new(ray.origin.to_array(), ray.direction.to_array());
        let t_max = ray.t_max.min(INFINITE);
        query.hit.t = t_max;
        self.0.intersect(&mut query);
        let hit = query.hit;
        if hit.t < t_max { Hit { t: hit.t, u: hit.u, v: hit.v, prim_id: hit.prim } } else { Hit::MISS }
    }
}

impl Peer for Tinybvh {
    fn bytes(&self) -> Option<usize> {
        None
    }

    fn tracers(&self, _coherent: bool) -> Vec<(&'static str, Box<dyn Tracer + '_>)> {
        vec![("tinybvh", Box::new(self))]
    }
}

impl Tracer for Tinybvh {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.trace(ray);
        }
    }

    fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, occluded) in rays.iter().zip(occluded) {
            *occluded = self.trace(ray).is_hit();
        }
    }
}
