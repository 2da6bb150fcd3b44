//! Tracing of rays, with cut-outs: rays pass through where opacity is low.
//!
//! The tree ignores cut-outs. Where they are, [micromaps](super::opacity_micromaps) or textures tell: a filter of the hits of
//! ray streams. Coherent packets and instances are traced without it first, and rays that hit a hole once more.

use glam::Vec2;
use halfdome_kernel::sampling::Stream;
use halfdome_kernel::{self as kernel, HitPacket, Ray, RayPacket};

use super::hit::{MIDDLE, time_of};
use super::{Hit, World};

/// Rays whose hits are in memory at once: as many as make a call cost little more for each than thousands do.
const CHUNK: usize = 1024;

impl World {
    /// The nearest hit of each ray in the middle of the shutter's time, [`Hit::MISS`] for none. Rays pass through
    /// holes.
    pub(crate) fn intersect_many(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.intersect_many_at(rays, &[], hits);
    }

    /// The same, at a time for each ray; without times in the middle.
    pub(crate) fn intersect_many_at(&self, rays: &[Ray], times: &[f32], hits: &mut [Hit]) {
        for (rays, hits) in rays.chunks(CHUNK).zip(hits.chunks_mut(CHUNK)) {
            let mut found = [kernel::Hit::MISS; CHUNK];
            let found = &mut found[..rays.len()];
            if self.has_holes {
                self.intersect_tree_beyond_holes(rays, found);
            } else {
                self.tree().intersect_many(rays, found);
            }
            for (hit, found) in hits.iter_mut().zip(found) {
                *hit = Hit::of(found);
            }
        }
        self.pass_on(rays, times, hits, self.instances.is_some());
    }

    /// The nearest hit of one ray at a time. It passes through holes.
    pub(super) fn intersect_at(&self, ray: &Ray, time: f32) -> Hit {
        let mut hits = [self.tree().intersect(ray).as_ref().map_or(Hit::MISS, Hit::of)];
        let times = [time];
        self.pass_on(&[*ray], if self.motion.is_some() { &times } else { &[] }, &mut hits, true);
        hits[0]
    }

    /// The nearest hits of many rays; faster for coherent rays, such as the camera's.
    pub(crate) fn intersect_side_by_side(&self, rays: &[Ray], times: &[f32], hits: &mut [Hit]) {
        const WIDTH: usize = 16;
        self.ray_counters.add_side_by_side(rays.len());
        let tree = self.tree();
        for (rays, hits) in rays.chunks(WIDTH).zip(hits.chunks_mut(WIDTH)) {
            let mut found = HitPacket::MISS;
            tree.intersect_packet::<WIDTH>(&RayPacket::from_rays(rays), &mut found);
            for (lane, hit) in hits.iter_mut().enumerate() {
                *hit = Hit::of(&found.hit(lane));
            }
        }
        self.pass_on(rays, times, hits, true);
    }

    /// Finds nearer hits with instances, and takes rays that hit a hole further, if any may have.
    fn pass_on(&self, rays: &[Ray], times: &[f32], hits: &mut [Hit], may_hit_holes: bool) {
        if let Some(instances) = &self.instances {
            instances.intersect_nearer(rays, times, hits);
        }
        if self.has_holes && may_hit_holes {
            let in_holes: Vec<usize> = (0..rays.len()).filter(|&i| self.is_hole(&rays[i], &hits[i])).collect();
            self.pass_through_holes(rays, times, hits, &in_holes);
        }
        if self.motion.is_some() {
            for (i, hit) in hits.iter_mut().enumerate() {
                hit.time = time_of(times, i);
            }
        }
    }

    /// Finds the nearest hits, in no hole, of the rays of these numbers.
    fn pass_through_holes(&self, rays: &[Ray], times: &[f32], hits: &mut [Hit], numbers: &[usize]) {
        for numbers in numbers.chunks(CHUNK) {
            let these: Vec<Ray> = numbers.iter().map(|&number| rays[number]).collect();
            let mut found = [kernel::Hit::MISS; CHUNK];
            self.intersect_tree_beyond_holes(&these, &mut found[..these.len()]);
            for (&number, found) in numbers.iter().zip(&found) {
                let (ray, hit) = (&rays[number], Hit::of(found));
                let nearer = self.instances.as_ref().and_then(|instances| {
                    let shortened = Ray { t_max: if hit.is_hit() { hit.t } else { ray.t_max }, ..*ray };
                    let time = time_of(times, number);
                    instances.intersect_filtered(&shortened, time, |hit| !self.is_hole(ray, hit))
                });
                hits[number] = nearer.filter(|nearer| nearer.t < hit.t || !hit.is_hit()).unwrap_or(hit);
            }
        }
    }

    /// The nearest hits with what is no instance, in no hole.
    fn intersect_tree_beyond_holes(&self, rays: &[Ray], hits: &mut [kernel::Hit]) {
        self.tree().intersect_many_filtered(rays, hits, |ray, hit| !self.is_hole(&rays[ray], &Hit::of(hit)));
    }

    /// Whether each ray hits anything in the middle of the shutter's time. Rays pass through holes.
    pub(crate) fn occluded_many(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.occluded_many_at(rays, &[], occluded);
    }

    /// The same, at a time for each ray; without times in the middle.
    pub(crate) fn occluded_many_at(&self, rays: &[Ray], times: &[f32], occluded: &mut [bool]) {
        self.ray_counters.add_occlusion(rays.len());
        if self.has_holes {
            return self.occlude_beyond_holes(rays, times, occluded);
        }
        self.tree().occluded_many(rays, occluded);
        if let Some(instances) = &self.instances {
            instances.occlude(rays, times, occluded);
        }
    }

    fn occlude_beyond_holes(&self, rays: &[Ray], times: &[f32], occluded: &mut [bool]) {
        let tree = self.tree();
        tree.occluded_many_filtered(rays, occluded, |ray, hit| !self.is_hole(&rays[ray], &Hit::of(hit)));
        let Some(instances) = &self.instances else { return };
        let by_tree = occluded.to_vec();
        instances.occlude(rays, times, occluded);
        for (i, ray) in rays.iter().enumerate().filter(|(i, _)| !by_tree[*i]) {
            occluded[i] =
                occluded[i] && instances.occluded_filtered(ray, time_of(times, i), |hit| !self.is_hole(ray, hit));
        }
    }

    /// Whether `ray` hits anything. Rays pass through holes.
    pub(crate) fn occluded(&self, ray: &Ray) -> bool {
        self.occluded_at(ray, MIDDLE)
    }

    /// The same at a time.
    pub(crate) fn occluded_at(&self, ray: &Ray, time: f32) -> bool {
        let mut occluded = [false];
        self.occluded_many_at(&[*ray], &[time], &mut occluded);
        occluded[0]
    }

    /// The index of a triangle among those of its mesh.
    pub(super) fn index_in_mesh(&self, prim_id: u32) -> usize {
        (prim_id - self.first_faces[self.triangle_records[prim_id as usize].mesh as usize]) as usize
    }

    /// Whether there is a hole in the triangle where this ray hits it. A partly opaque surface lets a part of the rays
    /// pass, chosen by a hash of ray and triangle, so that all queries agree.
    #[inline(always)]
    pub(crate) fn is_hole(&self, ray: &Ray, hit: &Hit) -> bool {
        if !self.has_holes || !hit.is_hit() {
            return false;
        }
        let opacity = self.opacity(hit.prim_id, [hit.u, hit.v]);
        opacity < 1.0 && (opacity <= 0.0 || opacity <= chance(ray, hit))
    }

    /// The opacity of a triangle at a point, 0 to 1.
    pub(crate) fn opacity(&self, prim_id: u32, [u, v]: [f32; 2]) -> f32 {
        if !self.has_holes {
            return 1.0;
        }
        self.opacity_micromaps.at(prim_id, Vec2::new(u, v)).unwrap_or_else(|| self.looked_up_opacity(prim_id, [u, v]))
    }

    #[inline(never)]
    pub(super) fn looked_up_opacity(&self, prim_id: u32, [u, v]: [f32; 2]) -> f32 {
        let material = &self.materials[self.triangle_records[prim_id as usize].material as usize];
        material.opacity_at(&self.mesh_point(prim_id, [1.0 - u - v, u, v]))
    }
}

/// A number in [0, 1) for a ray and a triangle.
pub(crate) fn chance(ray: &Ray, hit: &Hit) -> f32 {
    let [a, b, c] = ray.origin.to_array().map(f32::to_bits);
    let [d, e, f] = ray.direction.to_array().map(f32::to_bits);
    let seed = u64::from(a) << 32 | u64::from(b);
    let stream = Stream::new(seed, c ^ d.rotate_left(11), e ^ f.rotate_left(17));
    stream.uniform2(hit.prim_id ^ hit.instance.rotate_left(16)).x
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec3};

    use super::*;
    use crate::scene::{
        CameraPose, Channel, Input, InputMap, Instance, Material, Mesh, Object, Opacity, Scene, Target, Texture,
        TextureFilter, TextureMap,
    };

    /// A square from 0 to 1 at each of these heights, of a material each.
    fn squares(materials: Vec<Material>, textures: Vec<Texture>) -> World {
        World::new(scene_of_squares(materials, textures)).unwrap()
    }

    fn scene_of_squares(materials: Vec<Material>, textures: Vec<Texture>) -> Scene {
        let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        let mesh = |material: usize| Mesh {
            positions: corners.map(|corner| corner.extend(material as f32)).into(),
            texcoords: corners.into(),
            lightmap_texcoords: corners.map(|corner| Vec2::new(corner.y, corner.x) * 0.5).into(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material,
            ..Mesh::default()
        };
        let camera = CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 };
        let meshes = (0..materials.len()).map(mesh).collect();
        Scene { meshes, materials, textures, camera: Some(camera), ..Scene::default() }
    }

    fn map(set: u32) -> TextureMap {
        TextureMap { set, filter: TextureFilter::Nearest, ..TextureMap::default() }
    }

    /// Varies the base colour.
    fn colors() -> InputMap {
        let target = Target { input: Input::BaseColor, channel: Channel::Rgb, zero: 0.0 };
        InputMap { texture: map(0), targets: vec![target] }
    }

    /// Four texels: a hole, red, green and blue.
    fn texture() -> Texture {
        Texture::new(2, 2, vec![[255, 255, 255, 100], [255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]])
    }

    /// Rays upwards from below.
    fn upwards(places: &[Vec2]) -> Vec<Ray> {
        places.iter().map(|place| Ray::new(place.extend(-1.0), Vec3::Z)).collect()
    }

    const PLACES: [Vec2; 4] = [Vec2::new(0.2, 0.3), Vec2::new(0.7, 0.2), Vec2::new(0.3, 0.8), Vec2::new(0.6, 0.9)];

    #[test]
    fn surfaces_have_the_colours_of_their_textures() {
        let half = Material { maps: vec![colors()], ..Material::matte(Vec3::splat(0.5)) };
        let second = Material { emission: Vec3::ONE, emission_map: Some(map(1)), ..Material::default() };
        let world = squares(vec![half, second], vec![texture()]);
        let seen = |from: f32| {
            let mut hits = [Hit::MISS; 4];
            let rays: Vec<Ray> =
                upwards(&PLACES).iter().map(|ray| Ray::new(ray.origin.with_z(from), Vec3::Z)).collect();
            world.intersect_many(&rays, &mut hits);
            hits.map(|hit| world.surface_at(&hit))
        };
        let found = seen(-1.0).map(|surface| surface.diffuse);
        assert_eq!(found, [Vec3::splat(0.5), Vec3::X * 0.5, Vec3::Y * 0.5, Vec3::Z * 0.5]);
        // The second set swaps u and v, and shows the first quarter alone, which is white.
        let found = seen(0.5).map(|surface| surface.emitted(Vec3::NEG_Z));
        assert_eq!(found, [Vec3::ONE; 4]);
    }

    #[test]
    fn rays_pass_through_holes_and_nothing_else() {
        let opacity = |value, cutoff| Opacity { value, map: Some((map(0), Channel::A)), cutoff: Some(cutoff) };
        let fence = Material { opacity: opacity(1.0, 0.5), ..Material::default() };
        let rays = upwards(&PLACES);
        let trace = |materials: Vec<Material>| {
            let world = squares(materials, vec![texture()]);
            let (mut hits, mut occluded) = ([Hit::MISS; 4], [false; 4]);
            world.intersect_many(&rays, &mut hits);
            let mut side_by_side = [Hit::MISS; 4];
            world.intersect_side_by_side(&rays, &[], &mut side_by_side);
            assert_eq!(side_by_side, hits);
            world.occluded_many(&rays, &mut occluded);
            assert_eq!(rays.iter().map(|ray| world.occluded(ray)).collect::<Vec<_>>(), occluded);
            (hits.map(|hit| hit.is_hit().then_some(hit.t)), occluded)
        };
        // A fence before a wall, behind another fence, and alone.
        let seen = [Some(2.0), Some(1.0), Some(1.0), Some(1.0)];
        assert_eq!(trace(vec![fence.clone(), Material::default()]), (seen, [true; 4]));
        let alone = ([None, Some(1.0), Some(1.0), Some(1.0)], [false, true, true, true]);
        assert_eq!(trace(vec![fence.clone()]), alone);
        assert_eq!(trace(vec![fence.clone(), fence.clone()]), alone);
        // The factor counts, and 100/255 is less than one half of 0.9, but not than 0.3.
        let solid = Material { opacity: opacity(1.0, 0.3), ..fence.clone() };
        assert_eq!(trace(vec![solid]), ([Some(1.0); 4], [true; 4]));
        let gone = Material { opacity: Opacity { map: None, ..opacity(0.4, 0.5) }, ..Material::default() };
        assert_eq!(trace(vec![gone, fence]), ([None, Some(2.0), Some(2.0), Some(2.0)], [false, true, true, true]));
    }

    /// Two fences, of which any may be an instance.
    #[test]
    fn rays_pass_through_holes_of_instances_and_of_what_is_behind() {
        let opacity = |cutoff| Opacity { value: 1.0, map: Some((map(0), Channel::A)), cutoff: Some(cutoff) };
        let fences = [0.5, 0.3].map(|cutoff| Material { opacity: opacity(cutoff), ..Material::default() });
        let places: Vec<Vec2> = (0..500).map(|i| 1.4 * Stream::new(1, i, 0).uniform2(0) - 0.2).collect();
        let rays = upwards(&places);
        let trace = |fences: [&Material; 2], instanced: &[usize]| {
            let mut scene = scene_of_squares(fences.map(Material::clone).to_vec(), vec![texture()]);
            for (object, &number) in instanced.iter().enumerate() {
                scene.meshes[number].object = Some(object);
                scene.objects.push(Object::default());
                scene.instances.push(Instance { object, to_world: Affine3A::IDENTITY });
            }
            let world = World::new(scene).unwrap();
            assert_eq!(world.instances.is_some(), !instanced.is_empty());
            let (mut hits, mut side_by_side) = (vec![Hit::MISS; rays.len()], vec![Hit::MISS; rays.len()]);
            let mut occluded = vec![false; rays.len()];
            world.intersect_many(&rays, &mut hits);
            world.intersect_side_by_side(&rays, &[], &mut side_by_side);
            world.occluded_many(&rays, &mut occluded);
            assert_eq!(side_by_side, hits);
            let found: Vec<Option<f32>> = hits.iter().map(|hit| hit.is_hit().then_some(hit.t)).collect();
            assert_eq!(occluded, found.iter().map(Option::is_some).collect::<Vec<_>>());
            found
        };
        let [holed, whole] = &fences;
        for fences in [[holed, holed], [holed, whole], [whole, holed]] {
            let expected = trace(fences, &[]);
            assert!([None, Some(1.0)].iter().all(|kind| expected.contains(kind)));
            for instanced in [&[0][..], &[1], &[0, 1]] {
                assert_eq!(trace(fences, instanced), expected, "{instanced:?}");
            }
        }
    }

    #[test]
    fn rays_pass_a_part_of_what_is_there_in_part_and_the_same_ones_for_all() {
        let veil = Material { opacity: Opacity { value: 0.3, ..Opacity::default() }, ..Material::default() };
        let world = squares(vec![veil.clone(), veil], vec![]);
        let places: Vec<Vec2> = (0..10_000).map(|i| Stream::new(1, i, 0).uniform2(0)).collect();
        let rays = upwards(&places);
        let (mut hits, mut occluded) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
        world.intersect_many(&rays, &mut hits);
        world.occluded_many(&rays, &mut occluded);
        let part = |t: f32| hits.iter().filter(|hit| hit.is_hit() && hit.t == t).count() as f64 / 10_000.0;
        // 0.3, and 0.3 of the rest; a standard error is 0.005.
        assert!((part(1.0) - 0.3).abs() < 0.02 && (part(2.0) - 0.21).abs() < 0.02, "{}, {}", part(1.0), part(2.0));
        assert!(hits.iter().zip(&occluded).all(|(hit, occluded)| hit.is_hit() == *occluded));
    }
}
