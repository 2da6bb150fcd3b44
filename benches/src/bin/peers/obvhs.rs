//! obvhs: its compressed wide tree (Ylitie et al. 2017) in the best quality it has presets for.

use glam::Vec3A;
use halfdome_benches::tracer::Tracer;
use halfdome_kernel::{Hit, Ray, Triangle};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::RayHit;
use obvhs::rt_triangle::RtTriangle;

use crate::trees::Peer;

/// A tree of obvhs and the triangles in its order.
pub(crate) struct Obvhs {
    tree: CwBvh,
    triangles: Vec<RtTriangle>,
}

impl Obvhs {
    /// Builds a tree over `triangles` with spatial splits and reinsertion, on one thread.
    pub(crate) fn build(triangles: &[Triangle]) -> Self {
        let triangles: Vec<_> = triangles
            .iter()
            .map(|corners| {
                let [v0, v1, v2] = corners.map(Vec3A::from);
                obvhs::triangle::Triangle { v0, v1, v2 }
            })
            .collect();
        let tree = build_cwbvh_from_tris(&triangles, BvhBuildParams::very_slow_build(), &mut Default::default());
        let triangles = tree.primitive_indices.iter().map(|&index| (&triangles[index as usize]).into()).collect();
        Self { tree, triangles }
    }
}

impl Peer for Obvhs {
    fn bytes(&self) -> Option<usize> {
        let Self { tree, triangles } = self;
        Some(size_of_val(&*tree.nodes) + size_of_val(&*tree.primitive_indices) + size_of_val(&**triangles))
    }

    fn tracers(&self, _coherent: bool) -> Vec<(&'static str, Box<dyn Tracer + '_>)> {
        vec![("obvhs", Box::new(self))]
    }
}

fn convert(ray: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new(ray.origin.into(), ray.direction.into(), ray.t_min, ray.t_max)
}

impl Tracer for Obvhs {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, out) in rays.iter().zip(hits) {
            let mut hit = RayHit::none();
            let found = self.tree.ray_traverse(convert(ray), &mut hit, |ray, i| self.triangles[i].intersect(ray));
            *out = if found {
                let prim_id = self.tree.primitive_indices[hit.primitive_id as usize];
                Hit { t: hit.t, prim_id, ..Hit::MISS }
            } else {
                Hit::MISS
            };
        }
    }

    fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, occluded) in rays.iter().zip(occluded) {
            *occluded = !self.tree.ray_traverse_miss(convert(ray), |ray, i| self.triangles[i].intersect(ray));
        }
    }
}
