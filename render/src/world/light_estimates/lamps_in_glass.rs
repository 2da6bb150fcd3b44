//! Finds [lamps in glass](crate::light::LampImages): emissive triangles, points and spots most of whose light meets glass
//! before it comes to other surfaces. Triangles that share corners are one lamp.
//!
//! Smooth glass around points and spots is left to [`specular`](crate::world::specular).

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, Triangle as TriangleWarp, UniformSphere, Warp};
use halfdome_kernel::sampling::{Frame, Pattern, Sampler};
use halfdome_kernel::{Aabb, Ray, Triangle};
use rayon::prelude::*;

use super::lamp_images::connected;
use super::through_glass::arriving_rays;
use crate::light::{HiddenLights, LampImage, Light, area, luminance_weight};
use crate::material::ggx::Ggx;
use crate::scene::PunctualLight;
use crate::world::{Hit, MIDDLE, World};

/// Rays from a light: of all together, and the most of each.
const RAYS: usize = 1 << 20;
const MOST_RAYS: usize = 16;
/// By how much the box around a lamp is wider than it, by the distance to the glass: around any, and more by the width of
/// the glass's microfacets; and the most.
const LEAST_MARGIN: f32 = 0.05;
const MARGIN_BY_ALPHA: f32 = 0.75;
const MOST_MARGIN: f32 = 0.7;
/// The least part of its light that arrives where it is aimed at.
const LEAST_ARRIVING: f32 = 0.02;

/// A light in glass.
#[derive(Clone, Copy)]
struct LightInGlass {
    /// The `prim_id` of an emissive triangle, or the number of another light.
    number: u32,
    /// Of a point or spot, its position.
    corners: Triangle,
    /// Power over π, as luminance.
    power: f32,
    /// The distance of the nearest glass.
    distance: f32,
    /// The greatest `α` of the glass's microfacets.
    alpha: f32,
}

impl World {
    /// The lights that glass hides, and where they show. These triangles are emissive.
    pub(super) fn lamps_in_glass(&self, emissive: &[u32]) -> (HiddenLights, Vec<LampImage>) {
        if !self.has_clear_glass() {
            return Default::default();
        }
        let (triangles, points) = (self.emitters_in_glass(emissive), self.points_in_glass());
        let numbers = |lights: &[LightInGlass]| lights.iter().map(|light| light.number).collect();
        let hidden = HiddenLights { triangles: numbers(&triangles), points: numbers(&points) };
        let images = lamp_images(&triangles);
        let rays = arriving_rays(images.len());
        let seen = |image: LampImage| {
            let part = self.arriving(&image.bounds, &hidden.triangles, rays);
            (part > LEAST_ARRIVING).then_some(LampImage { radiance: part * image.radiance, ..image })
        };
        let mut images: Vec<LampImage> = images.into_par_iter().filter_map(seen).collect();
        images.extend(lamp_images(&points));
        (hidden, images)
    }

    /// Those among emissive triangles that glass hides.
    fn emitters_in_glass(&self, emissive: &[u32]) -> Vec<LightInGlass> {
        let count = (RAYS / emissive.len().max(1)).min(MOST_RAYS) as u32;
        let in_glass = |number: u32| {
            let record = &self.triangle_records[number as usize];
            let ray = |side: Vec3, [x, y]: [f32; 2], v: Vec2| {
                let point = TriangleWarp.map(Vec2::new(x, y));
                let direction = Frame::from_normal(side).to_world(CosineHemisphere.map(v));
                Ray::new(self.surface(number, point.x, point.y).origin_towards(direction), direction)
            };
            // The winding may be opposite to the side that emits.
            let glass_before = |side: Vec3| self.glass_around((number, count), |point, v| ray(side, point, v));
            let (distance, alpha) = glass_before(record.normal).or_else(|| glass_before(-record.normal))?;
            let material = self.materials[record.material as usize].without_maps(&self.textures);
            let sides = if material.emits_both_sides { 2.0 } else { 1.0 };
            let power = sides * area(&record.corners) * luminance_weight(material.emission);
            Some(LightInGlass { number, corners: record.corners, power, distance, alpha })
        };
        emissive.par_iter().copied().filter_map(in_glass).collect()
    }

    /// The points and spots in rough glass, ascending.
    fn points_in_glass(&self) -> Vec<LightInGlass> {
        let in_glass = |(number, light): (usize, &Light)| {
            let Light::Punctual(light) = light else { return None };
            let (PunctualLight::Point { position, .. }
            | PunctualLight::Spot { position, .. }
            | PunctualLight::Profiled { position, .. }) = light
            else {
                return None;
            };
            let ray = |_, v: Vec2| Ray::new(*position, UniformSphere.map(v));
            let (distance, alpha) = self.glass_around((number as u32, MOST_RAYS as u32), ray)?;
            let (strength, solid_angle) = light.power();
            let power = luminance_weight(strength) * (solid_angle / std::f64::consts::PI) as f32;
            let light = LightInGlass { number: number as u32, corners: [*position; 3], power, distance, alpha };
            (alpha > 0.0).then_some(light)
        };
        self.lights.lights().iter().enumerate().filter_map(in_glass).collect()
    }

    /// The distance and the greatest `α` of the glass around a light of this number, by so many rays that two pairs of numbers
    /// stand for, if most meet glass first that is no pane.
    fn glass_around(&self, (number, count): (u32, u32), ray: impl Fn([f32; 2], Vec2) -> Ray) -> Option<(f32, f32)> {
        let ray = |i| {
            let sampler = Sampler::new(Pattern::Sobol, 0, number, i);
            let [.., x, y] = sampler.uniform4(1);
            ray([x, y], sampler.uniform2(2))
        };
        let rays: Vec<Ray> = (0..count).map(ray).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        self.intersect_many(&rays, &mut hits);
        let is_glass = |(ray, hit): &(&Ray, &Hit)| self.is_clear_glass(hit) && self.pane_at(ray, hit, MIDDLE).is_none();
        let (mut meeting, mut distance, mut widest) = (0, f32::INFINITY, 0.0_f32);
        for (_, hit) in rays.iter().zip(&hits).filter(is_glass) {
            let inputs = self.surface_at(hit).material.even_inputs();
            let alpha = Ggx::new(inputs.specular_roughness, inputs.specular_anisotropy).alpha.max_element();
            (distance, widest) = (distance.min(hit.t), widest.max(alpha));
            meeting += 1;
        }
        (2 * meeting > rays.len()).then_some((distance, widest))
    }
}

/// Where lamps of these lights show.
fn lamp_images(lights: &[LightInGlass]) -> Vec<LampImage> {
    let lamps = connected(lights.iter().map(|light| &light.corners)).into_iter();
    lamps.map(|numbers| lamp_image(&numbers.into_iter().map(|number| lights[number]).collect::<Vec<_>>())).collect()
}

/// Where a lamp of these lights shows.
fn lamp_image(lights: &[LightInGlass]) -> LampImage {
    let corners: Vec<Vec3> = lights.iter().flat_map(|light| light.corners).collect();
    let distance = lights.iter().map(|light| light.distance).fold(f32::INFINITY, f32::min);
    let alpha = lights.iter().map(|light| light.alpha).fold(0.0, f32::max);
    let (around, margin) =
        (Aabb::around(&corners), distance * (LEAST_MARGIN + MARGIN_BY_ALPHA * alpha).min(MOST_MARGIN));
    let bounds = Aabb { min: around.min - margin, max: around.max + margin };
    let power = lights.iter().map(|light| light.power).sum::<f32>();
    LampImage { bounds, radiance: power / (2.0 * bounds.half_area()), mirror: None }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use super::*;
    use crate::light::{LitPart, box_faces};
    use crate::material::Inputs;
    use crate::scene::{CameraPose, Material, Mesh, Scene};

    fn cube(middle: Vec3, half: f32) -> Mesh {
        let faces = box_faces(&Aabb { min: middle - half, max: middle + half });
        let positions = faces.into_iter().flatten().collect();
        let triangles = (0..12).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
        Mesh { positions, triangles, ..Mesh::default() }
    }

    /// A smooth ball, whose front is outside for the side 1 and inside for -1.
    fn ball(middle: Vec3, radius: f32, side: f32) -> Mesh {
        const ROWS: u32 = 24;
        let normal = |number: u32| {
            let [row, column] = [number / (2 * ROWS), number % (2 * ROWS)].map(|it| PI * it as f32 / ROWS as f32);
            Vec3::new(row.sin() * column.cos(), row.sin() * column.sin(), row.cos())
        };
        let normals: Vec<Vec3> = (0..2 * ROWS * (ROWS + 1)).map(normal).collect();
        let quad = |number: u32| {
            let next = number / (2 * ROWS) * 2 * ROWS + (number + 1) % (2 * ROWS);
            let (low, low_next) = (number + 2 * ROWS, next + 2 * ROWS);
            [[number, low, low_next], [number, low_next, next]]
        };
        let mut triangles: Vec<[u32; 3]> = (0..2 * ROWS * ROWS).flat_map(quad).collect();
        if side < 0.0 {
            triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        let positions = normals.iter().map(|normal| middle + radius * *normal).collect();
        Mesh { positions, normals: normals.iter().map(|normal| side * *normal).collect(), triangles, ..Mesh::default() }
    }

    /// Cubes that emit in shells of glass of this roughness, at x = 0 and 3, and one without glass at x = 6.
    fn world(roughness: f32, lights: Vec<PunctualLight>) -> World {
        World::new(scene(roughness, lights)).unwrap()
    }

    /// The same with lamps of the opposite winding, which emit from both sides.
    fn turned_world() -> World {
        let mut scene = scene(0.0, Vec::new());
        scene.materials[2].emits_both_sides = true;
        let lamps = scene.meshes.iter_mut().filter(|mesh| mesh.material == 2);
        lamps.flat_map(|mesh| &mut mesh.triangles).for_each(|corners| corners.swap(1, 2));
        World::new(scene).unwrap()
    }

    fn scene(roughness: f32, lights: Vec<PunctualLight>) -> Scene {
        let places = [0.0, 3.0, 6.0].map(|x| Vec3::new(x, 0.0, 0.0));
        let lamps = places.map(|place| cube(place, 0.1));
        let glasses =
            [places[0], places[1]].into_iter().flat_map(|place| [ball(place, 1.0, 1.0), ball(place, 0.98, -1.0)]);
        let inputs = Inputs { transmission_weight: 1.0, specular_roughness: roughness, ..Inputs::default() };
        let lamp = Material { emission: Vec3::splat(2.0), ..Material::matte(Vec3::ZERO) };
        let floor = cube(Vec3::new(0.0, 0.0, -53.0), 50.0);
        let materials = vec![Material::matte(Vec3::splat(0.5)), Material { inputs, ..Material::default() }, lamp];
        let of = |material: usize| move |mesh: Mesh| Mesh { material, ..mesh };
        let meshes = [floor].into_iter().chain(glasses.map(of(1))).chain(lamps.map(of(2))).collect();
        let camera = CameraPose { eye: Vec3::new(0.0, -9.0, 3.0), target: Vec3::ZERO, up: Vec3::Z, vfov: 60.0 };
        Scene { meshes, materials, lights, camera: Some(camera), ..Scene::default() }
    }

    fn boxes(world: &World) -> Vec<(Aabb, f32)> {
        let lamps = world.find_lamp_images();
        let bounds =
            |faces: &[LitPart]| Aabb::around(&faces.iter().flat_map(|face| face.light.corners).collect::<Vec<_>>());
        lamps.parts().chunks(12).map(|faces| (bounds(faces), faces[0].light.radiance)).collect()
    }

    #[test]
    fn lamps_that_glass_surrounds_have_boxes() {
        let boxes = boxes(&world(0.0, Vec::new()));
        assert_eq!(boxes.len(), 2);
        for ((bounds, radiance), x) in boxes.into_iter().zip([0.0, 3.0]) {
            let half = 0.5 * (bounds.max - bounds.min);
            assert!((bounds.center() - Vec3::X * x).length() < 1e-5);
            // Wider than the lamp by a part of the distance to the glass.
            assert!((half - (0.1 + 0.05 * 0.88)).abs().max_element() < 0.005, "{half}");
            // The lamp's power, of which the glass reflects a part, on the area of the box.
            let spread = 2.0 * (0.1 / half.x).powi(2);
            assert!(radiance > 0.6 * spread && radiance < 1.05 * spread, "{radiance}, {spread}");
        }
    }

    #[test]
    fn lamps_that_emit_from_both_sides_may_have_any_winding() {
        assert_eq!(boxes(&turned_world()).len(), 2);
    }

    #[test]
    fn rougher_glass_shows_larger_and_dimmer_lamps() {
        let [smooth, rough] = [0.0, 0.5].map(|roughness| boxes(&world(roughness, Vec::new()))[0]);
        assert!(rough.0.max.x > 2.0 * smooth.0.max.x, "{rough:?}, {smooth:?}");
        assert!(rough.1 < 0.5 * smooth.1, "{rough:?}, {smooth:?}");
    }

    #[test]
    fn points_in_rough_glass_are_lamps() {
        let light =
            |x: f32| PunctualLight::Point { position: Vec3::new(x, 0.3, 0.0), intensity: Vec3::ONE, radius: 0.0 };
        let lights = vec![light(3.0), light(6.0)];
        assert_eq!(boxes(&world(0.5, lights.clone())).len(), 3);
        // Of smooth glass the light of points is known.
        assert_eq!(boxes(&world(0.0, lights)).len(), 2);
    }

    #[test]
    fn lamps_show_straight_through_glass_alone() {
        let mut world = world(0.0, Vec::new());
        world.lights.lamp_images = world.find_lamp_images();
        let along =
            |eye: Vec3, direction: Vec3| world.image_along(&Ray::new(eye, direction)).map(|(_, distance)| distance);
        let distance = along(Vec3::new(0.0, -5.0, 0.0), Vec3::Y).unwrap();
        assert!((distance - 4.855).abs() < 0.01, "{distance}");
        assert_eq!(along(Vec3::new(0.5, -5.0, 0.0), Vec3::Y), None, "it passes the lamp");
        assert_eq!(along(Vec3::new(6.0, -5.0, 0.0), Vec3::Y), None, "there is no glass");
        assert_eq!(along(Vec3::new(0.0, -0.5, 0.0), Vec3::Y), None, "from inside");
    }
}
