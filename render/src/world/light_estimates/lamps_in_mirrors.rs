//! Finds [images of lamps](crate::light::LampImages) in flat faces that reflect as a mirror does, or nearly so.
//!
//! An image is as far behind the face as its lamp is in front. Its radiance is what rays from points of the face towards the
//! lamp find, times Schlick's reflectance, weighted by what the face receives. On a rough face it is wider, by about the width
//! of the lobe that reflects it.
//!
//! Deviations: neither faces with normal maps nor those that move or are instanced show images, and none shows those of others.

use std::collections::HashMap;

use glam::Vec2;
use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};
use halfdome_kernel::{Aabb, Ray, triangle_normal};
use rayon::prelude::*;

use super::lamp_images::connected;
use crate::light::{LampImage, MirrorPlane, area, box_faces, luminance_weight};
use crate::material::ggx::Ggx;
use crate::scene::Material;
use crate::world::{Hit, MIDDLE, World, interpolate};

/// The roughness from which on faces show no images.
const ROUGH: f32 = 0.3;
/// The least area of a triangle that counts, by the square of the scene's extent.
const LEAST_AREA: f32 = 1e-6;
/// Steps of normals and offsets, the latter by the scene's extent, within which triangles are coplanar.
const NORMAL_STEPS: f32 = 1024.0;
const OFFSET_STEPS: f32 = 4096.0;
/// The least cosine between a flat triangle's normal and those of its vertices.
const FLAT: f32 = 0.9999;
/// The least part of a lamp's light that comes to a face, about: images that show through less are found by luck.
const LEAST_PART: f32 = 0.03;
/// The most faces, lamps and images, and the least light of an image relative to the brightest one.
const MAX_FACES: usize = 512;
const MAX_LAMPS: usize = 256;
const MAX_IMAGES: usize = 512;
const LEAST_LIGHT: f32 = 1e-3;
/// By how much the box around an image is wider than the lamp, by the distance from the face: around any, and more by the
/// width of the face's microfacets.
const LEAST_MARGIN: f32 = 0.01;
const MARGIN_BY_ALPHA: f32 = 1.0;
/// Rays that measure the radiance of images: of all together, and the least and the most of each.
const RAYS: usize = 1 << 14;
const LEAST_RAYS: usize = 32;
const MOST_RAYS: usize = 256;
/// How far before a face rays begin that ask whether it is there, by the scene's extent.
const BEFORE: f32 = 1e-4;

/// One side of coplanar triangles of one material.
struct FlatFace {
    plane: MirrorPlane,
    triangles: Vec<u32>,
    bounds: Aabb,
    area: f32,
    gloss: Gloss,
}

/// How a material mirrors.
#[derive(Clone, Copy)]
struct Gloss {
    /// Reflectance at normal incidence, as luminance.
    reflectance: f32,
    /// The greatest `α` of its microfacets.
    alpha: f32,
}

/// A lamp's box, and its power over π, as luminance.
struct Lamp {
    bounds: Aabb,
    power: f32,
}

impl World {
    /// All of them. These triangles are emissive.
    pub(super) fn lamps_in_mirrors(&self, emissive: &[u32]) -> Vec<LampImage> {
        if emissive.is_empty() {
            return Vec::new();
        }
        let (faces, lamps) = (self.flat_faces(), self.lamps(emissive));
        let pairs = faces.iter().flat_map(|face| lamps.iter().map(move |lamp| (face.light_of(lamp), face, lamp)));
        let mut pairs: Vec<_> = pairs.filter(|(light, ..)| *light > 0.0).collect();
        pairs.sort_by(|(a, ..), (b, ..)| b.total_cmp(a));
        pairs.truncate(MAX_IMAGES);
        let brightest = pairs.first().map_or(0.0, |(light, ..)| *light);
        pairs.retain(|(light, ..)| *light >= LEAST_LIGHT * brightest);
        let rays = (RAYS / pairs.len().max(1)).clamp(LEAST_RAYS, MOST_RAYS) as u32;
        pairs.into_par_iter().filter_map(|(_, face, lamp)| self.image(face, lamp, rays)).collect()
    }

    /// The faces that reflect most.
    fn flat_faces(&self) -> Vec<FlatFace> {
        let gloss: Vec<Option<Gloss>> = self.materials.iter().map(|material| self.gloss(material)).collect();
        let extent = self.extent();
        let mut numbers: HashMap<[i32; 5], usize> = HashMap::new();
        let mut faces: Vec<FlatFace> = Vec::new();
        for (record, triangle) in self.still_records().iter().zip(0..) {
            let Some(gloss) = gloss[record.material as usize] else { continue };
            let area = area(&record.corners);
            if !(area > LEAST_AREA * extent * extent && self.has_flat_normals(triangle)) {
                continue;
            }
            // Files have mirrors of either winding.
            for normal in [record.normal, -record.normal] {
                let plane = MirrorPlane { normal, offset: normal.dot(record.corners[0]), material: record.material };
                let [x, y, z] = (normal * NORMAL_STEPS).to_array().map(|it| it.round() as i32);
                let key = [x, y, z, (plane.offset / extent * OFFSET_STEPS).round() as i32, plane.material as i32];
                let number = *numbers.entry(key).or_insert(faces.len());
                if number == faces.len() {
                    faces.push(FlatFace { plane, triangles: Vec::new(), bounds: Aabb::EMPTY, area: 0.0, gloss });
                }
                let face = &mut faces[number];
                face.triangles.push(triangle);
                face.bounds = face.bounds.union(&Aabb::around(&record.corners));
                face.area += area;
            }
        }
        faces.sort_by(|a, b| (b.area * b.gloss.reflectance).total_cmp(&(a.area * a.gloss.reflectance)));
        faces.truncate(MAX_FACES);
        faces
    }

    /// How a material mirrors: by its strongest lobe that is narrow.
    fn gloss(&self, material: &Material) -> Option<Gloss> {
        if material.unlit || material.is_glass() || material.tilts_normals() {
            return None;
        }
        let inputs = material.mean_inputs(&self.textures);
        let at_normal = |ior: f32| ((ior - 1.0) / (ior + 1.0)).powi(2);
        let dielectric = inputs.specular_weight * at_normal(inputs.specular_ior);
        let metal = luminance_weight(inputs.base_color);
        let base = dielectric + inputs.base_metalness * (metal - dielectric);
        let coat_weight = if material.coat_normal.map().is_some() { 0.0 } else { inputs.coat_weight };
        let coat = coat_weight * at_normal(inputs.coat_ior);
        let lobes = [(base, inputs.specular_roughness, inputs.specular_anisotropy), (coat, inputs.coat_roughness, 0.0)];
        let narrow = lobes.into_iter().filter(|(reflectance, roughness, _)| *roughness < ROUGH && *reflectance > 0.0);
        let (reflectance, roughness, anisotropy) = narrow.max_by(|(a, ..), (b, ..)| a.total_cmp(b))?;
        Some(Gloss { reflectance, alpha: Ggx::new(roughness, anisotropy).alpha.max_element() })
    }

    /// Whether vertex normals do not bend a triangle.
    fn has_flat_normals(&self, triangle: u32) -> bool {
        let is_straight = |[u, v]: [f32; 2]| {
            let surface = self.surface(triangle, u, v);
            surface.normal.dot(surface.smooth_normal) > FLAT
        };
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].into_iter().all(is_straight)
    }

    /// The strongest lamps.
    fn lamps(&self, emissive: &[u32]) -> Vec<Lamp> {
        let record = |number: usize| &self.triangle_records[emissive[number] as usize];
        let none = || Lamp { bounds: Aabb::EMPTY, power: 0.0 };
        let with = |lamp: Lamp, number: usize| {
            let record = record(number);
            let emission = self.materials[record.material as usize].without_maps(&self.textures).emission;
            Lamp {
                bounds: lamp.bounds.union(&Aabb::around(&record.corners)),
                power: lamp.power + area(&record.corners) * luminance_weight(emission),
            }
        };
        let groups = connected((0..emissive.len()).map(|number| &record(number).corners)).into_iter();
        let mut lamps: Vec<Lamp> = groups.map(|numbers| numbers.into_iter().fold(none(), with)).collect();
        lamps.sort_by(|a, b| b.power.total_cmp(&a.power));
        lamps.truncate(MAX_LAMPS);
        lamps
    }

    /// The image of a lamp in a face, if it shows any light, by so many rays.
    fn image(&self, face: &FlatFace, lamp: &Lamp, count: u32) -> Option<LampImage> {
        let (plane, gloss) = (face.plane, face.gloss);
        let margin = plane.height(lamp.bounds.center()) * (LEAST_MARGIN + MARGIN_BY_ALPHA * gloss.alpha);
        let corners = box_faces(&lamp.bounds).map(|corners| corners.map(|corner| plane.image(corner)));
        let around = Aabb::around(corners.as_flattened());
        let bounds = Aabb { min: around.min - margin, max: around.max + margin };
        let targets = box_faces(&bounds);
        let (mut found, mut weights) = (0.0, 0.0);
        for number in 0..count {
            let sampler = Sampler::new(Pattern::Sobol, 0, face.triangles[0], number);
            let ([choice, side, x, y], [u, v]) = (sampler.uniform4(0), sampler.uniform2(1).to_array());
            let place = TriangleWarp.map(Vec2::new(x, y));
            let from = self.surface(self.triangle_at(face, choice), place.x, place.y);
            let (place, target) =
                (TriangleWarp.map(Vec2::new(u, v)), targets[(side * targets.len() as f32) as usize % targets.len()]);
            let to = interpolate(target, [1.0 - place.x - place.y, place.x, place.y]);
            let way = to - from.position;
            let direction = plane.reflected(way.normalize());
            let cosines = [plane.normal.dot(direction), -triangle_normal(&target).dot(way.normalize())];
            if !cosines.iter().all(|cosine| *cosine > 0.0) {
                continue;
            }
            let weight = cosines[0] * cosines[1] / way.length_squared();
            let ray = Ray::new(from.origin_towards(direction), direction);
            let hit = self.straight_behind_glass(&ray, &self.intersect_at(&ray, MIDDLE), MIDDLE);
            weights += weight;
            if hit.is_hit() {
                let reflectance = gloss.reflectance + (1.0 - gloss.reflectance) * (1.0 - cosines[0]).powi(5);
                found += weight * reflectance * luminance_weight(self.surface_at(&hit).emitted(direction));
            }
        }
        (found > 0.0).then(|| LampImage { bounds, radiance: found / weights, mirror: Some(plane) })
    }

    /// The triangle of a face at a part of its area.
    fn triangle_at(&self, face: &FlatFace, part: f32) -> u32 {
        let mut left = part * face.area;
        let is_here = |triangle: &&u32| {
            left -= area(&self.triangle_records[**triangle as usize].corners);
            left <= 0.0
        };
        *face.triangles.iter().find(is_here).unwrap_or(&face.triangles[0])
    }

    /// How far a ray from an image comes, by way of its mirror: 0 if that is not in this direction.
    pub(super) fn reach_from_mirror(&self, mirror: &MirrorPlane, ray: &Ray) -> f32 {
        let cosine = mirror.normal.dot(ray.direction);
        let behind = -mirror.height(ray.origin);
        if !(cosine > 0.0 && behind > 0.0) {
            return 0.0;
        }
        let (distance, before) = (behind / cosine, BEFORE * self.extent() / cosine);
        let back = Ray { t_max: 2.0 * before, ..Ray::new(ray.at(distance + before), -ray.direction) };
        let hit: Hit = self.intersect_at(&back, MIDDLE);
        if !hit.is_hit() || self.triangle_records[hit.prim_id as usize].material != mirror.material {
            return 0.0;
        }
        let from = self.surface_at(&hit).origin_towards(ray.direction);
        distance + self.intersect_at(&Ray::new(from, ray.direction), MIDDLE).t
    }

    /// The longest side of the box around all surfaces.
    fn extent(&self) -> f32 {
        (self.bounds().max - self.bounds().min).max_element()
    }
}

impl FlatFace {
    /// About how much of a lamp's light it reflects, if nothing is in between: 0 for lamps behind it, or little.
    fn light_of(&self, lamp: &Lamp) -> f32 {
        let middle = lamp.bounds.center();
        let height = self.plane.height(middle);
        if height <= 0.0 {
            return 0.0;
        }
        let distance = middle.distance(middle.clamp(self.bounds.min, self.bounds.max)).max(height);
        let part = self.area / (self.area + distance * distance) * (height / distance);
        if part > LEAST_PART { lamp.power * part * self.gloss.reflectance } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::material::Inputs;
    use crate::scene::{CameraPose, Mesh, NormalMap, Scene, Texture, TextureMap};

    /// A mirror at z = 0, from -1 to 1, whose front is up.
    fn mirror() -> Mesh {
        let positions = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        Mesh { positions: positions.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() }
    }

    /// A cube of this material.
    fn cube(middle: Vec3, half: f32, material: usize) -> Mesh {
        let positions = box_faces(&Aabb { min: middle - half, max: middle + half }).into_iter().flatten().collect();
        let triangles = (0..12).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
        Mesh { positions, triangles, material, ..Mesh::default() }
    }

    fn metal(roughness: f32) -> Material {
        let inputs = Inputs {
            base_color: Vec3::splat(0.8),
            base_metalness: 1.0,
            specular_roughness: roughness,
            ..Inputs::default()
        };
        Material { inputs, ..Material::default() }
    }

    /// A lamp half a unit wide before a mirror of this material.
    fn scene(material: Material) -> Scene {
        let lamp = Material { emission: Vec3::splat(2.0), ..Material::matte(Vec3::ZERO) };
        let camera = CameraPose { eye: Vec3::new(0.0, -9.0, 3.0), target: Vec3::ZERO, up: Vec3::Z, vfov: 60.0 };
        Scene {
            meshes: vec![mirror(), cube(Vec3::new(0.0, 0.2, 2.0), 0.25, 1)],
            materials: vec![material, lamp, Material::matte(Vec3::splat(0.5))],
            camera: Some(camera),
            ..Scene::default()
        }
    }

    fn images(scene: Scene) -> Vec<LampImage> {
        let world = World::new(scene).unwrap();
        world.lamps_in_mirrors(&world.emissive_triangles())
    }

    #[test]
    fn a_mirror_shows_lamps_in_front_as_far_behind() {
        let images = images(scene(metal(0.0)));
        let [LampImage { bounds, radiance, mirror }] = images[..] else { panic!("{images:?}") };
        assert!((bounds.center() - Vec3::new(0.0, 0.2, -2.0)).length() < 1e-5, "{bounds:?}");
        let half = 0.5 * (bounds.max - bounds.min);
        assert!((half - (0.25 + 0.01 * 2.0)).abs().max_element() < 1e-4, "{half}");
        // What it reflects of the lamp's radiance, which fills most of the box.
        assert!(radiance > 0.75 * 0.8 * 2.0 && radiance < 0.85 * 2.0, "{radiance}");
        assert_eq!(mirror.map(|plane| (plane.normal, plane.offset)), Some((Vec3::Z, 0.0)));
    }

    #[test]
    fn mirrors_may_have_either_winding() {
        let mut turned = scene(metal(0.0));
        turned.meshes[0].triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        let images = images(turned);
        assert_eq!(images.len(), 1);
        assert!((images[0].bounds.center() - Vec3::new(0.0, 0.2, -2.0)).length() < 1e-5, "{images:?}");
        assert!(images[0].radiance > 0.75 * 0.8 * 2.0, "{images:?}");
    }

    #[test]
    fn what_does_not_mirror_shows_no_images() {
        let map = NormalMap { texture: TextureMap::default(), scale: Vec2::ONE };
        let bumpy = Material { normal_map: Some(map), ..metal(0.0) };
        let flat = Texture::new(1, 1, vec![[128, 128, 255, 255]]);
        let with = |material| Scene { textures: vec![flat.clone()], ..scene(material) };
        assert_eq!(images(with(metal(0.0))).len(), 1);
        for (what, material) in [("rough", metal(0.4)), ("matte", Material::matte(Vec3::ONE)), ("bumpy", bumpy)] {
            assert!(images(with(material)).is_empty(), "{what}");
        }
        let mut curved = scene(metal(0.0));
        curved.meshes[0].normals =
            curved.meshes[0].positions.iter().map(|p| (*p + 3.0 * Vec3::Z).normalize()).collect();
        assert!(images(curved).is_empty());
        let mut covered = scene(metal(0.0));
        covered.meshes.push(cube(Vec3::new(0.0, 0.0, 0.5), 0.4, 2));
        covered.meshes[2].positions.iter_mut().for_each(|p| *p *= Vec3::new(9.0, 9.0, 1.0));
        assert!(images(covered).is_empty());
    }

    #[test]
    fn rougher_mirrors_show_larger_and_dimmer_lamps() {
        let [smooth, rough] = [0.0, 0.29].map(|roughness| images(scene(metal(roughness)))[0]);
        assert!(rough.bounds.max.x > smooth.bounds.max.x + 0.15, "{rough:?}, {smooth:?}");
        assert!(rough.radiance < 0.7 * smooth.radiance, "{rough:?}, {smooth:?}");
    }

    #[test]
    fn images_show_in_their_mirror_alone() {
        let mut world = World::new(scene(metal(0.0))).unwrap();
        world.lights.lamp_images = world.find_lamp_images();
        let image = Vec3::new(0.0, 0.2, -2.0);
        let [seen, beside, below] = [Vec3::new(0.0, -1.5, 2.0), Vec3::new(0.0, -9.0, 2.0), Vec3::new(0.0, -1.5, -1.0)]
            .map(|eye| world.image_along(&Ray::new(eye, (image - eye).normalize())).map(|(_, distance)| distance));
        assert!(seen.is_some_and(|distance| (distance - 4.03).abs() < 0.05), "{seen:?}");
        assert_eq!([beside, below], [None, None]);
        let mirror = world.lights.lamp_images.image(world.triangle_records.len() as u32).unwrap().mirror.unwrap();
        let reach = |towards: Vec3| world.reach_from_mirror(&mirror, &Ray::new(image, (towards - image).normalize()));
        // Through the mirror to nothing, to the lamp, past the mirror, and away from it.
        assert_eq!(reach(Vec3::new(0.9, 0.2, 0.0)), f32::INFINITY);
        assert!((reach(Vec3::new(0.0, 0.2, 0.0)) - 3.75).abs() < 1e-3);
        assert_eq!([reach(Vec3::new(1.5, 0.2, 0.0)), reach(Vec3::new(0.0, 0.2, -9.0))], [0.0, 0.0]);
    }
}
