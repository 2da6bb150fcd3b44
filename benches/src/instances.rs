//! Instances of a mesh: a field of turned and scaled blobs, and how they move.

use glam::{Affine3A, Quat, Vec3};
use halfdome_kernel::sampling::Stream;
use halfdome_kernel::scene::{Item, SceneHit, SceneRay};
use halfdome_kernel::{BuildOptions, Bvh, Error, Hit, Quality, Ray, Scene, SceneView, Triangle};

use crate::rays::{self, RayCounts, RaySet};
use crate::scenes::Camera;
use crate::tracer::Tracer;

/// Distance between neighbours, of blobs with a radius of about 1.
const SPACING: f32 = 2.6;

/// Where `count` instances are in a frame: on a square grid, each turned and scaled by itself, and drifting from frame
/// to frame.
pub fn places(count: u32, frame: u32) -> Vec<Affine3A> {
    let side = f64::from(count).sqrt().ceil() as u32;
    let place = |i: u32| {
        let [x, y, z, turns] = Stream::new(7, i, 0).uniform4(0);
        let [scale, height, phase, _] = Stream::new(7, i, 0).uniform4(1);
        let axis = Vec3::new(x - 0.5, y - 0.5, z - 0.45).normalize_or(Vec3::Y);
        let turn = Quat::from_axis_angle(axis, 6.0 * turns + 0.02 * frame as f32);
        let drift = 0.3 * (0.1 * frame as f32 + 6.3 * phase).sin();
        let corner = Vec3::new((i % side) as f32, 0.5 * height + drift, (i / side) as f32) * SPACING;
        Affine3A::from_scale_rotation_translation(Vec3::splat(0.6 + 0.5 * scale), turn, corner)
    };
    (0..count).map(place).collect()
}

/// A scene of instances of `mesh`.
///
/// # Errors
/// The errors of [`Scene::build`].
pub fn scene<'a>(mesh: &'a Bvh, places: &[Affine3A], quality: Quality) -> Result<Scene<'a>, Error> {
    let items = places.iter().map(|place| Item::new(mesh.view()).placed(place)).collect::<Result<_, _>>()?;
    Ok(Scene::build(items, &BuildOptions::from(quality))?.0)
}

/// The rays of all kinds for a scene of instances of `triangles`.
pub fn rays(scene: &SceneView, triangles: &[Triangle], counts: RayCounts) -> [RaySet; 4] {
    let bounds = scene.bounds();
    let (centre, extent) = (bounds.center(), bounds.max - bounds.min);
    let eye = centre + extent * Vec3::new(0.1, 0.0, 0.45) + Vec3::Y * (2.0 * SPACING);
    let camera = Camera { eye, target: centre - extent * Vec3::new(0.05, 0.0, 0.1), half_side: 0.6 };
    let trace = |rays: &[Ray]| {
        let surface = |ray: &Ray| {
            let hit = scene.intersect(&SceneRay::new(*ray))?;
            let [a, b, c] = triangles[hit.hit.prim_id as usize];
            let to_scene = scene.to_scene(&hit, 0.0)?;
            Some((hit.hit.t, rays::normal(&[a, b, c].map(|corner| to_scene.transform_point3(corner)))))
        };
        rays.iter().map(surface).collect()
    };
    let light = centre + Vec3::Y * (0.2 * extent.max_element());
    // What is near counts for offsets, not how far the field reaches.
    rays::generate_from(&camera, light, 10.0 * SPACING, counts, trace)
}

/// Traces a scene's batches, or with `ONE` one ray a call. Hits lose their geometry.
pub struct SceneTracer<'a, const ONE: bool>(pub SceneView<'a>);

/// Rays that are brought into the scene's form together.
const CHUNK: usize = 4096;

impl<const ONE: bool> Tracer for SceneTracer<'_, ONE> {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) {
        let mut found = vec![SceneHit::MISS; CHUNK.min(rays.len())];
        for (rays, hits) in rays.chunks(CHUNK).zip(hits.chunks_mut(CHUNK)) {
            let rays: Vec<SceneRay> = rays.iter().map(|&ray| ray.into()).collect();
            if ONE {
                for (ray, hit) in rays.iter().zip(&mut found) {
                    *hit = self.0.intersect(ray).unwrap_or(SceneHit::MISS);
                }
            } else {
                self.0.intersect_many(&rays, &mut found);
            }
            hits.iter_mut().zip(&found).for_each(|(hit, found)| *hit = found.hit);
        }
    }

    fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        for (rays, occluded) in rays.chunks(CHUNK).zip(occluded.chunks_mut(CHUNK)) {
            let rays: Vec<SceneRay> = rays.iter().map(|&ray| ray.into()).collect();
            if ONE {
                for (ray, occluded) in rays.iter().zip(occluded) {
                    *occluded = self.0.occluded(ray);
                }
            } else {
                self.0.occluded_many(&rays, occluded);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::Answers;
    use crate::scenes;

    #[test]
    fn one_ray_a_call_finds_what_batches_do() {
        let blob = scenes::blob(20);
        let (mesh, _) = Bvh::build(&blob, &Quality::Fast.into()).unwrap();
        let scene = scene(&mesh, &places(50, 3), Quality::Fast).unwrap();
        assert_ne!(places(50, 3), places(50, 4));
        for set in rays(&scene.view(), &blob, RayCounts::TINY) {
            let one = Answers::of(&SceneTracer::<true>(scene.view()), &set);
            assert_eq!(one, Answers::of(&SceneTracer::<false>(scene.view()), &set), "{}", set.kind.name());
            assert!(one.hits() > 10, "{}: {}", set.kind.name(), one.hits());
        }
    }
}
