//! tinybvh: its tree of 8 children for AVX2, built in high quality.
//!
//! The Rust binding has no any-hit query, so the nearest hit replaces it, and no query of the tree's memory. Its
//! `Ray::new` is not used: in 0.1.0-beta.3 the C++ side writes a ray of 128 bytes, aligned to 64, where the Rust type
//! has but the first 64, so that it writes over the caller's stack.

use glam::Vec3;
use halfdome_benches::tracer::Tracer;
use halfdome_kernel::{Hit, Ray, Triangle};
use tinybvh_rs::{INFINITE, Intersection, Intersector, bvh, bvh8_cpu, mbvh};

use crate::trees::Peer;

/// The most triangles that this layout takes in a leaf.
const LEAF: u32 = 4;

/// The ray's mask, where the binding sees padding.
const EVERY_INSTANCE: u32 = 0xFFFF;

/// A ray as the C++ side has it.
#[repr(C, align(64))]
struct Query {
    ray: tinybvh_rs::Ray,
    /// The user's data.
    _rest: [u8; 64],
}

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
        let t_max = ray.t_max.min(INFINITE);
        let mut query = Query {
            ray: tinybvh_rs::Ray {
                origin: ray.origin.to_array(),
                padding_0: EVERY_INSTANCE,
                dir: ray.direction.to_array(),
                // Finite where a component is 0, as the C++ side's own reciprocal is.
                r_d: ray.direction.recip().clamp(Vec3::splat(-INFINITE), Vec3::splat(INFINITE)).to_array(),
                hit: Intersection { t: t_max, ..Default::default() },
                ..Default::default()
            },
            _rest: [0; 64],
        };
        self.0.intersect(&mut query.ray);
        let hit = query.ray.hit;
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
