//! Instances of a mesh: a field of turned and scaled blobs, and how they move.

use glam::{Affine3A, Quat, Vec3};
use halfdome_kernel::sampling::Stream;
use halfdome_kernel::scene::{Item, SceneHit, SceneHitPacket, SceneRay, SceneRayPacket};
use halfdome_kernel::traverse::{PacketWidth, Width};
use halfdome_kernel::{BuildOptions, Bvh, Error, Hit, Quality, Ray, Scene, SceneView, Triangle};

use crate::rays::{self, RayCounts, RaySet};
use crate::scenes::Camera;
use crate::tracer::{Entry, Tracer};

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

/// Traces a scene's rays by one of the entry points. Hits lose their geometry.
pub struct SceneTracer<'a>(pub SceneView<'a>, pub Entry);

/// Rays that are brought into the scene's form together.
const CHUNK: usize = 4096;

impl SceneTracer<'_> {
    fn intersect_packets<const N: usize>(&self, rays: &[SceneRay], hits: &mut [SceneHit])
    where
        Width<N>: PacketWidth<N>,
    {
        for (rays, hits) in rays.chunks(N).zip(hits.chunks_mut(N)) {
            let mut packet = SceneHitPacket::<N>::MISS;
            self.0.intersect_packet(&SceneRayPacket::from_rays(rays), &mut packet);
            for (lane, hit) in hits.iter_mut().enumerate() {
                *hit = packet.hit(lane);
            }
        }
    }

    fn occluded_packets<const N: usize>(&self, rays: &[SceneRay], occluded: &mut [bool])
    where
        Width<N>: PacketWidth<N>,
    {
        for (rays, occluded) in rays.chunks(N).zip(occluded.chunks_mut(N)) {
            let bits = self.0.occluded_packet(&SceneRayPacket::<N>::from_rays(rays));
            for (lane, occluded) in occluded.iter_mut().enumerate() {
                *occluded = bits >> lane & 1 == 1;
            }
        }
    }
}

impl Tracer for SceneTracer<'_> {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) {
        let mut found = vec![SceneHit::MISS; CHUNK.min(rays.len())];
        for (rays, hits) in rays.chunks(CHUNK).zip(hits.chunks_mut(CHUNK)) {
            let rays: Vec<SceneRay> = rays.iter().map(|&ray| ray.into()).collect();
            let found = &mut found[..rays.len()];
            match self.1 {
                Entry::Single => {
                    for (ray, hit) in rays.iter().zip(&mut *found) {
                        *hit = self.0.intersect(ray).unwrap_or(SceneHit::MISS);
                    }
                }
                Entry::Packet4 => self.intersect_packets::<4>(&rays, found),
                Entry::Packet8 => self.intersect_packets::<8>(&rays, found),
                Entry::Packet16 => self.intersect_packets::<16>(&rays, found),
                Entry::Packet32 => self.intersect_packets::<32>(&rays, found),
                Entry::Batch => self.0.intersect_many(&rays, found),
                Entry::Gather => self.0.intersect_gather(&rays, found),
            }
            hits.iter_mut().zip(found).for_each(|(hit, found)| *hit = found.hit);
        }
    }

    fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        for (rays, occluded) in rays.chunks(CHUNK).zip(occluded.chunks_mut(CHUNK)) {
            let rays: Vec<SceneRay> = rays.iter().map(|&ray| ray.into()).collect();
            match self.1 {
                Entry::Single => {
                    for (ray, occluded) in rays.iter().zip(occluded) {
                        *occluded = self.0.occluded(ray);
                    }
                }
                Entry::Packet4 => self.occluded_packets::<4>(&rays, occluded),
                Entry::Packet8 => self.occluded_packets::<8>(&rays, occluded),
                Entry::Packet16 => self.occluded_packets::<16>(&rays, occluded),
                Entry::Packet32 => self.occluded_packets::<32>(&rays, occluded),
                Entry::Batch => self.0.occluded_many(&rays, occluded),
                Entry::Gather => self.0.occluded_gather(&rays, occluded),
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
    fn all_entry_points_find_the_same() {
        let blob = scenes::blob(20);
        let (mesh, _) = Bvh::build(&blob, &Quality::Fast.into()).unwrap();
        let scene = scene(&mesh, &places(50, 3), Quality::Fast).unwrap();
        assert_ne!(places(50, 3), places(50, 4));
        for set in rays(&scene.view(), &blob, RayCounts::TINY) {
            let one = Answers::of(&SceneTracer(scene.view(), Entry::Single), &set);
            for entry in Entry::ALL {
                let found = Answers::of(&SceneTracer(scene.view(), entry), &set);
                assert_eq!(found, one, "{}, {}", set.kind.name(), entry.name());
            }
            assert!(one.hits() > 10, "{}: {}", set.kind.name(), one.hits());
        }
    }
}
