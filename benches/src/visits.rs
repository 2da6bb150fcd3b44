//! The nodes and blocks that a ray visits: a measure of the tree that is independent of the machine's load.

use glam::Vec3;
use halfdome_kernel::bvh::{Child, WIDTH};
use halfdome_kernel::{BvhView, Hit, Ray, Triangle};

use crate::rays::RaySet;

/// Every so manyth ray is followed.
const STEP: usize = 7;

/// What a ray visits on average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visits {
    /// Nodes.
    pub nodes: f64,
    /// Blocks of triangles.
    pub blocks: f64,
}

impl Visits {
    /// Follows rays of `set` through `tree`, one after the other, near children first.
    pub fn of(tree: &BvhView, set: &RaySet) -> Self {
        let (mut nodes, mut blocks, mut rays) = (0, 0, 0);
        for ray in set.rays.iter().step_by(STEP) {
            let (n, b) = follow(tree, ray, set.kind.any_hit());
            nodes += n;
            blocks += b;
            rays += 1;
        }
        Self { nodes: nodes as f64 / f64::from(rays), blocks: blocks as f64 / f64::from(rays) }
    }
}

/// Nodes and blocks that a ray visits.
fn follow(tree: &BvhView, ray: &Ray, any_hit: bool) -> (u64, u64) {
    let (mut nodes, mut blocks) = (0, 0);
    let mut t_max = ray.t_max;
    let octant = (0..3).fold(0, |octant, axis| octant | usize::from(ray.direction[axis].is_sign_negative()) << axis);
    let mut stack = vec![(Child::Node(0), ray.t_min)];
    while let Some((child, near)) = stack.pop() {
        match child {
            _ if near > t_max => {}
            Child::Empty => {}
            Child::Node(index) => {
                nodes += 1;
                let node = &tree.nodes()[index as usize];
                for place in 0..WIDTH {
                    let slot = (node.order[octant] >> (3 * place) & 7) as usize;
                    let aabb = node.aabb(slot);
                    if let Some(near) = enter(aabb.min, aabb.max, ray, t_max) {
                        stack.push((Child::unpack(node.children[slot]), near));
                    }
                }
            }
            Child::Leaf { first, count } => {
                for block in &tree.blocks()[first as usize..(first + count) as usize] {
                    blocks += 1;
                    for lane in (0..WIDTH).filter(|&lane| block.prim_id[lane] != Hit::NO_PRIM) {
                        t_max = hit(&block.triangle(lane), ray, t_max).unwrap_or(t_max);
                    }
                    if any_hit && t_max < ray.t_max {
                        return (nodes, blocks);
                    }
                }
            }
        }
    }
    (nodes, blocks)
}

/// Where a ray enters a box, if it does; a box that is inside out it does not.
fn enter(min: Vec3, max: Vec3, ray: &Ray, t_max: f32) -> Option<f32> {
    if !min.cmple(max).all() {
        return None;
    }
    let inverse = ray.direction.recip();
    let (a, b) = ((min - ray.origin) * inverse, (max - ray.origin) * inverse);
    let near = a.min(b).max_element().max(ray.t_min);
    let far = a.max(b).min_element().min(t_max);
    (near <= far).then_some(near)
}

/// Where a ray hits a triangle before `t_max` (Möller and Trumbore 1997).
fn hit([a, b, c]: &Triangle, ray: &Ray, t_max: f32) -> Option<f32> {
    let (ab, ac) = (b - a, c - a);
    let p = ray.direction.cross(ac);
    let inverse = 1.0 / ab.dot(p);
    let from_a = ray.origin - a;
    let q = from_a.cross(ab);
    let (u, v, t) = (from_a.dot(p) * inverse, ray.direction.dot(q) * inverse, ac.dot(q) * inverse);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= ray.t_min && t < t_max).then_some(t)
}

#[cfg(test)]
mod tests {
    use halfdome_kernel::{BuildOptions, Bvh};

    use super::*;
    use crate::rays::RayKind;

    #[test]
    fn visits_are_counted() {
        // In a row along x: one node.
        let triangle = |i: usize| [Vec3::ZERO, Vec3::Y, Vec3::Z].map(|p| p + Vec3::X * ((i / 8 * 10 + i % 8) as f32));
        let triangles: Vec<_> = (0..24).map(triangle).collect();
        let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
        let visits = |kind, origin, direction| {
            let set = RaySet { kind, rays: vec![Ray::new(origin, direction)] };
            let Visits { nodes, blocks } = Visits::of(&bvh.view(), &set);
            (nodes, blocks)
        };
        let inside = Vec3::new(-1.0, 0.2, 0.2);
        assert_eq!(visits(RayKind::Diffuse, inside, Vec3::X), (1.0, 1.0));
        assert_eq!(visits(RayKind::Shadow, inside, Vec3::X), (1.0, 1.0));
        // Through the boxes of all, past their triangles.
        let corner = Vec3::new(-1.0, 0.8, 0.8);
        let all = bvh.view().blocks().len() as f64;
        assert!(all > 1.0);
        assert_eq!(visits(RayKind::Diffuse, corner, Vec3::X), (1.0, all));
        assert_eq!(visits(RayKind::Diffuse, corner, Vec3::NEG_X), (1.0, 0.0));
    }
}
