//! The reference for scenes: loops over all items and all triangles, without any tree. Slow; all other ways to trace a
//! scene give the same hits bit for bit.

use core::ops::ControlFlow;

use super::object::Target;
use super::space::{Proximity, Space, between, next};
use super::{SceneHit, SceneRay, SceneView, round, shape};
use crate::bvh::TriangleBlock;
use crate::geometry::moment::Moment;
use crate::geometry::{Hit, MAX_COORDINATE, MAX_DIRECTION, MIN_DIRECTION, Ray, intersect_triangle};
use crate::traverse::Verdict;

/// The result of [`SceneView::intersect`].
pub fn intersect(scene: &SceneView, ray: &SceneRay) -> Option<SceneHit> {
    intersect_filtered(scene, ray, |_| Verdict::Accept)
}

/// The result of [`SceneView::intersect_filtered`], except for filters that stop, as the order of hits differs.
pub fn intersect_filtered(
    scene: &SceneView,
    ray: &SceneRay,
    mut filter: impl FnMut(&SceneHit) -> Verdict,
) -> Option<SceneHit> {
    let mut best: Option<SceneHit> = None;
    let mut stopped = false;
    all_hits(scene, ray, 0, 0, &mut |hit| {
        let order = |hit: &SceneHit| (hit.item, hit.hit.prim_id, hit.path);
        let is_better = match &best {
            Some(best) if hit.hit.t == best.hit.t => order(&hit) < order(best),
            Some(best) => hit.hit.t < best.hit.t,
            None => true,
        };
        if is_better && !stopped {
            let verdict = filter(&hit);
            if verdict != Verdict::Reject {
                best = Some(hit);
            }
            stopped = verdict == Verdict::Stop;
        }
    });
    best
}

/// The hits of [`SceneView::for_each_hit`] if it does not break off, in another order.
pub fn for_each_hit(scene: &SceneView, ray: &SceneRay, see: &mut dyn FnMut(SceneHit)) {
    all_hits(scene, ray, 0, 0, see);
}

/// Shows all hits of a ray within its interval, in a scene the first of whose paths is `first_path`.
fn all_hits(scene: &SceneView, ray: &SceneRay, first_path: u64, depth: u32, see: &mut dyn FnMut(SceneHit)) {
    let SceneRay { ray, time, mask } = *ray;
    if !can_hit(&ray) || time.is_nan() {
        return;
    }
    for &index in scene.tree().items() {
        let part = scene.parts()[index as usize];
        let item = &scene.items()[part.item as usize];
        if item.mask & mask == 0 {
            continue;
        }
        let Some(local) = item.placement.to_local(&ray, time) else {
            continue;
        };
        let path = first_path + (scene.paths() - 1);
        let mut see_here = |hit| see(SceneHit { hit, item: part.item, depth, path });
        match item.object.target() {
            Target::Nothing => {}
            Target::Mesh(tree) => loop_over(tree.blocks(), tree.blocks(), 0.0, &local, &mut see_here),
            Target::Moving(tree) => {
                if let Some(Moment { key, fraction }) = Moment::new(time, tree.keys()) {
                    let to = if fraction == 0.0 { key } else { key + 1 };
                    loop_over(tree.blocks(key), tree.blocks(to), fraction, &local, &mut see_here);
                }
            }
            Target::Round(tree) => round::for_each_hit(&tree, &local, &mut see_here),
            Target::Shape(shape) => shape::intersect(shape, part.prim_id, &local, time).into_iter().for_each(see_here),
            Target::Scene(inner) => {
                all_hits(&inner, &SceneRay { ray: local, time, mask }, first_path + item.first_path, depth + 1, see);
            }
        }
    }
}

/// Shows the hits with triangles a `fraction` of the way from those in one slice to those in the other.
fn loop_over(from: &[TriangleBlock], to: &[TriangleBlock], fraction: f32, ray: &Ray, see: &mut dyn FnMut(Hit)) {
    for (from, to) in from.iter().zip(to) {
        for (lane, prim_id) in from.used_lanes() {
            let (a, b) = (from.triangle(lane), to.triangle(lane));
            let corner = |i: usize| if fraction == 0.0 { a[i] } else { a[i] * (1.0 - fraction) + b[i] * fraction };
            if let Some(hit) = intersect_triangle(ray, &[corner(0), corner(1), corner(2)]) {
                see(Hit { prim_id, ..hit });
            }
        }
    }
}

/// Shows a search all triangles of a scene in a space at a time that a mask sees, where they are, and the boxes of
/// shapes' primitives, until it breaks off.
pub(super) fn search(
    scene: &SceneView,
    space: &Space,
    (time, mask): (f32, u32),
    (first_path, depth): (u64, u32),
    search: &mut dyn Proximity,
) -> ControlFlow<()> {
    for &index in scene.tree().items() {
        let part = scene.parts()[index as usize];
        let item = &scene.items()[part.item as usize];
        if item.mask & mask == 0 {
            continue;
        }
        let Some(space) = space.of(&item.placement, time) else { continue };
        let path = first_path + (scene.paths() - 1);
        let place = |prim_id| SceneHit { hit: Hit { prim_id, ..Hit::MISS }, item: part.item, depth, path };
        let mut loop_over = |from: &[TriangleBlock], to: &[TriangleBlock], fraction: f32| {
            for (from, to) in from.iter().zip(to) {
                for (lane, prim_id) in from.used_lanes() {
                    let corners = between(&from.triangle(lane), &to.triangle(lane), fraction);
                    search.meet(&space.triangle(&corners), place(prim_id))?;
                }
            }
            ControlFlow::Continue(())
        };
        match item.object.target() {
            Target::Nothing => {}
            Target::Mesh(tree) => loop_over(tree.blocks(), tree.blocks(), 0.0)?,
            Target::Moving(tree) => {
                if let Some(moment) = Moment::new(time, tree.keys()) {
                    loop_over(tree.blocks(moment.key), tree.blocks(next(moment)), moment.fraction)?;
                }
            }
            Target::Round(tree) => round::meet(&tree, 0..tree.blocks().len(), &space, search, place(Hit::NO_PRIM))?,
            Target::Shape(shape) => search.meet_box(&space.aabb(&shape.bounds(part.prim_id)), place(part.prim_id))?,
            Target::Scene(inner) => {
                self::search(&inner, &space, (time, mask), (first_path + item.first_path, depth + 1), search)?;
            }
        }
    }
    ControlFlow::Continue(())
}

/// Whether a ray is within the limits.
fn can_hit(ray: &Ray) -> bool {
    let near = ray.origin.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE);
    let longest = ray.direction.to_array().iter().fold(0.0, |longest: f32, x| longest.max(x.abs()));
    near && ray.direction.is_finite() && (MIN_DIRECTION..=MAX_DIRECTION).contains(&longest)
}
