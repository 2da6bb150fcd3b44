//! All lights that can be sampled: emissive triangles, delta lights and the sky, chosen by their estimated contribution
//! to a point.
//!
//! Triangles are in one light tree, points and spots in another (see [`tree`]). Lights at infinity are not in a tree:
//! of directional lights the irradiance at the receiver is known, of the sky there is an estimate by its normal (see
//! [`distant`]). All these weights are irradiances, and a light's probability is its part of their sum.

mod ambient;
mod cells;
mod choice;
mod distant;
mod emitters;
pub(crate) mod few;
mod grid;
mod lamp_images;
mod receiver;
mod secondary_lights;
mod sized;
mod sky;
mod slices;
mod tree;

use std::f64::consts::PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::{Aabb, Triangle};

use self::cells::PartTable;
pub(crate) use self::cells::{Division, TrianglePart};
pub(crate) use self::choice::{LightChoice, SampledLight, Weights};
use self::distant::Patches;
pub(crate) use self::emitters::EmissiveParts;
use self::emitters::Emitters;
use self::few::FEW;
pub(crate) use self::lamp_images::{HiddenLights, LampImage, LampImages, MirrorPlane, box_faces};
pub(crate) use self::receiver::Receiver;
pub(crate) use self::secondary_lights::{ChosenPart, LitPart, PartAt, Reach, SecondaryLights};
pub(crate) use self::sized::SizedLights;
pub(crate) use self::sky::{Openings, SkyLight, SkyPart, SkySample, SkyView};
pub(crate) use self::slices::{most_slices, slices};
use self::tree::Tree;
use self::tree::leaf::{PointLight, Points, Triangles};
pub(crate) use self::tree::leaf::{SpotCone, TriangleLight};
use crate::film::LUMINANCE;
use crate::scene::{Material, PunctualLight};
use crate::settings::LightSampling;

/// The lights of a world.
#[derive(Debug)]
pub(crate) struct LightSampler {
    /// Triangles, then points and spots, then directional lights, then the sky.
    lights: Vec<Light>,
    triangles: Option<Tree<Triangles>>,
    /// The triangles once more, if there are few and no other lights but perhaps the sky.
    few: Vec<TriangleLight>,
    points: Option<Tree<Points>>,
    directional: Patches,
    /// The same as if nothing were in between.
    free_directional: Patches,
    /// The numbers of punctual lights in the scene, in the order of `lights`.
    punctual_numbers: Vec<u32>,
    pub(crate) sky: SkyLight,
    /// Points, spots and directional lights that rays can meet.
    pub(crate) sized: SizedLights,
    /// Triangles that reflect so much that paths aim at them.
    pub(crate) lit: SecondaryLights,
    /// Where lamps show through glass and in mirrors, at which paths aim likewise.
    pub(crate) lamp_images: LampImages,
    /// Which light a point of a triangle belongs to.
    emitters: PartTable,
    /// The box around all points near an emissive triangle.
    surroundings: Aabb,
    /// An estimate of the mean radiance that surfaces receive and send.
    mean_radiance: Vec3,
}

/// One light.
#[derive(Clone, Debug)]
pub(crate) enum Light {
    /// A triangle that emits, or a part of one.
    Triangle(TrianglePart),
    /// A delta light.
    Punctual(PunctualLight),
    /// The sky.
    Sky,
}

impl LightSampler {
    /// The lights among `triangles`, whose materials `material` gives, `punctual`, and the sky; `bounds` are the
    /// scene's. Of a triangle `front` gives the unit normal of its front, `None` if that is not the same side
    /// everywhere, and `emissive_parts` those of its parts that emit, `None` if it is one light.
    pub(crate) fn new<'m>(
        triangles: &[Triangle],
        material: impl Fn(usize) -> &'m Material,
        front: impl Fn(usize) -> Option<Vec3>,
        emissive_parts: impl Fn(usize) -> Option<EmissiveParts>,
        (punctual, sky): (Vec<PunctualLight>, SkyLight),
        bounds: Aabb,
    ) -> Self {
        let mean_radiance = ambient::mean_radiance(triangles, &material, &punctual, sky.mean(), bounds);
        let Emitters { parts, lights: emitting, table } = Emitters::new(triangles, material, front, emissive_parts);
        let areas: f32 = emitting.iter().map(|light| light.area).sum();
        let around = |bounds: Aabb, light: &TriangleLight| bounds.union(&Aabb::around(&light.corners));
        let box_of_lights = emitting.iter().fold(Aabb::EMPTY, around);
        let mut lights: Vec<Light> = parts.into_iter().map(Light::Triangle).collect();
        let (mut points, mut directional) = (Vec::new(), Patches::default());
        let (distant, near): (Vec<_>, Vec<_>) =
            (0..).zip(punctual).partition(|(_, light)| matches!(light, PunctualLight::Directional { .. }));
        let mut punctual_numbers = Vec::new();
        for (number, light) in near.into_iter().chain(distant) {
            punctual_numbers.push(number);
            match light {
                PunctualLight::Directional { direction, irradiance, half_angle } => {
                    directional.push(-direction, half_angle, luminance_weight(irradiance));
                }
                PunctualLight::Point { position, intensity, radius } => {
                    let intensity = luminance_weight(intensity);
                    let everywhere = SpotCone { cos_outer: -2.0, slope: 1.0, smoothness: 0.0 };
                    points.push(PointLight {
                        position,
                        axis: Vec3::Z,
                        intensity,
                        radius,
                        cone: everywhere,
                        moments: None,
                        envelope: None,
                    });
                }
                PunctualLight::Spot { position, direction: axis, intensity, radius, cos_inner, cos_outer, edge } => {
                    let (intensity, cone) = (luminance_weight(intensity), SpotCone::new(cos_inner, cos_outer, edge));
                    points.push(PointLight { position, axis, intensity, radius, cone, moments: None, envelope: None });
                }
                PunctualLight::Profiled { position, frame, intensity, radius, ref profile } => {
                    let per_candela = luminance_weight(intensity);
                    let moments = Some(profile.moments().map(|moment| moment * f64::from(per_candela)));
                    // The angles differ over a sphere, so the greatest intensity is used.
                    let envelope = (radius == 0.0).then(|| profile.envelope());
                    // A little more than its cone, for what is rounded.
                    let cos_outer = profile.cos_outer() - 1e-3;
                    let cone = SpotCone { cos_outer, slope: 1e6, smoothness: 0.0 };
                    let intensity = per_candela * profile.greatest();
                    points.push(PointLight { position, axis: frame.axis, intensity, radius, cone, moments, envelope });
                }
            }
            lights.push(Light::Punctual(light));
        }
        lights.push(Light::Sky);
        // Beyond the radius of a disc as large as all of them a sample contributes no more than a hemisphere full of
        // light.
        let reach = Vec3::splat((areas * std::f32::consts::FRAC_1_PI).sqrt());
        let surroundings = Aabb { min: box_of_lights.min - reach, max: box_of_lights.max + reach };
        let are_few = emitting.len() <= FEW && punctual_numbers.is_empty();
        Self {
            triangles: Tree::build(&emitting),
            few: if are_few { emitting } else { Vec::new() },
            points: Tree::build(&points),
            sized: SizedLights::new(&lights),
            lights,
            free_directional: directional.clone(),
            directional,
            punctual_numbers,
            sky,
            lit: SecondaryLights::default(),
            lamp_images: LampImages::default(),
            emitters: table,
            surroundings,
            mean_radiance,
        }
    }

    /// Whether anything shines from infinitely far away.
    pub(crate) fn has_distant(&self) -> bool {
        self.directional.len() > 0 || self.sky.mean() != Vec3::ZERO
    }

    /// How many lights are directional.
    pub(crate) fn directional_count(&self) -> usize {
        self.directional.len()
    }

    /// The direction towards a directional light.
    pub(crate) fn towards_directional(&self, index: usize) -> Vec3 {
        self.directional.direction(index)
    }

    /// Multiplies weights by the part of the scene that each directional light and each part of the sky reaches; `open`
    /// is the part of scattered rays that see the sky.
    pub(crate) fn set_visibility(&mut self, directional: &[f32], sky: [f32; 3], open: f32) {
        for (index, &visibility) in directional.iter().enumerate() {
            self.directional.scale(index, visibility);
        }
        self.sky.set_visibility(sky, open);
    }

    /// Knows of nothing that is in between.
    pub(crate) fn forget_visibility(&mut self) {
        self.directional.clone_from(&self.free_directional);
        self.sky.forget_visibility();
    }

    /// All lights, if they are few triangles and light samples are to find nothing of this part of the sky.
    #[inline(always)]
    pub(crate) fn few(&self, part: SkyPart) -> &[TriangleLight] {
        if self.sky.has(part) { &[] } else { &self.few }
    }

    /// The number of the sky.
    pub(crate) fn sky_number(&self) -> u32 {
        self.lights.len() as u32 - 1
    }

    /// All lights, by their numbers.
    pub(crate) fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// The number of the light at a point of triangle `prim_id` with these barycentric coordinates, if light samples find
    /// any there.
    #[inline(always)]
    pub(crate) fn emitter_at(&self, prim_id: u32, place: Vec2) -> Option<u32> {
        self.emitters.at(prim_id, place)
    }

    /// Replaces the punctual light of this index by another one, which lights no point that the old one does not light.
    pub(crate) fn replace_punctual(&mut self, number: usize, light: PunctualLight) {
        let triangles = self.triangles.as_ref().map_or(0, Tree::len);
        if let Some(place) = self.punctual_numbers.iter().position(|&it| it as usize == number) {
            self.lights[triangles + place] = Light::Punctual(light);
        }
    }

    /// The number in the scene of the punctual light that is light `index`.
    pub(crate) fn punctual_number(&self, index: u32) -> usize {
        let triangles = self.triangles.as_ref().map_or(0, Tree::len);
        self.punctual_numbers[index as usize - triangles] as usize
    }

    /// Bytes of the light trees.
    pub(crate) fn tree_bytes(&self) -> usize {
        self.triangles.as_ref().map_or(0, Tree::bytes) + self.points.as_ref().map_or(0, Tree::bytes)
    }

    /// Whether a surface emits.
    pub(crate) fn has_emitters(&self) -> bool {
        self.triangles.is_some()
    }

    /// Whether light samples may find anything, of the sky this part.
    pub(crate) fn has_any(&self, part: SkyPart) -> bool {
        self.lights.len() > 1 || self.sky.has(part)
    }

    /// The probability with which this triangle or part of one is chosen for a receiver, among all lights and this part
    /// of the sky.
    #[inline(always)]
    pub(crate) fn probability(&self, light: u32, receiver: &Receiver, part: SkyPart) -> f32 {
        let weight = self.triangles.as_ref().map_or(0.0, |tree| tree.weight(light, receiver));
        if weight > 0.0 { weight / self.weigh(receiver, part).total() } else { 0.0 }
    }

    /// The probability with which the punctual light of this number is chosen for a receiver, among all lights and this part of
    /// the sky.
    pub(crate) fn punctual_probability(&self, number: u32, receiver: &Receiver, part: SkyPart) -> f32 {
        let weight = match number.checked_sub(self.first_distant()) {
            Some(place) => self.directional.weight(place as usize, receiver),
            None => self.points.as_ref().map_or(0.0, |tree| tree.weight(number - self.first_point(), receiver)),
        };
        if weight > 0.0 { weight / self.weigh(receiver, part).total() } else { 0.0 }
    }

    /// The sampling of lights at a point with known indirect light. An emissive triangle may be so near to it that
    /// samples of its area, whose density per solid angle falls with the square of the distance, are better combined
    /// with scattered rays; elsewhere such rays would miss.
    #[inline]
    pub(crate) fn techniques_at(&self, point: Vec3) -> LightSampling {
        let are_near = (point.cmpge(self.surroundings.min) & point.cmple(self.surroundings.max)).all();
        if are_near { LightSampling::Mis } else { LightSampling::Direct }
    }

    /// The typical radiance that a point receives and reflects: an estimate for the whole scene.
    pub(crate) fn mean_radiance(&self) -> Vec3 {
        self.mean_radiance
    }
}

/// The weight of a colour in linear sRGB: luminance, but not zero unless it is black, as each light must have a chance.
#[inline(always)]
pub(crate) fn luminance_weight(rgb: Vec3) -> f32 {
    rgb.dot(LUMINANCE.as_vec3()).max(0.05 * rgb.max_element())
}

/// Area of a triangle.
pub(crate) fn area(triangle: &Triangle) -> f32 {
    let [a, b, c] = triangle.map(|p| p.as_dvec3());
    (0.5 * (b - a).cross(c - a).length()) as f32
}

/// A light's colour, and what it is multiplied by to give the power that falls on a scene with these bounds.
fn flux(light: &PunctualLight, bounds: Aabb) -> (Vec3, f64) {
    let (color, extent) = light.power();
    let is_distant = matches!(light, PunctualLight::Directional { .. });
    (color, if is_distant { PI * radius(bounds).powi(2) } else { extent })
}

/// The radius of the scene's sphere.
fn radius(bounds: Aabb) -> f64 {
    let diagonal = (bounds.max - bounds.min).as_dvec3().length();
    if bounds.is_empty() { 1.0 } else { 0.5 * diagonal }
}

#[cfg(test)]
mod tests;
