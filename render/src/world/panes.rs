//! Shadow rays through panes of glass.
//!
//! What points, spots and suns send through glass to surfaces that scatter, light samples alone find: of no size they cannot
//! be hit, and those of a size are left to them. Where the two faces of a solid are parallel, as those of a window are, light
//! leaves as it came, and a shadow ray that goes straight on finds it, less what the pane keeps. With `F` reflected by a face
//! and `a` left by the way between them,
//!
//! `T = (1 - F)² a / (1 - F² a²)`,
//!
//! all passages summed (a thin wall has `a = 1`). A single face, as that of water above its floor, lets `1 - F` through. What
//! crosses a plane, a parallel one receives; as paths carry basic radiance, that is `1/n²` of it inside, and `n²` of it
//! outside of a solid with the light inside.
//!
//! Smooth faces alone are crossed: the closures of rough ones find lights by samples of their own.
//!
//! Deviations: light leaves a pane where it came, not beside it; a single face does not bend light; films and coats reflect
//! nothing. Faces that are not parallel throw shadows: what they focus is found by paths to lamps that have a surface.

use glam::Vec3;
use halfdome_kernel::geometry::Aabb;
use halfdome_kernel::{Ray, Triangle};

use super::{MIDDLE, Surface, TriangleRecord, World};
use crate::material::Inputs;
use crate::material::fresnel::Dielectric;
use crate::material::ggx::Ggx;
use crate::scene::Material;

/// The cosine of the angle, 3°, from which on two faces are not parallel.
const PARALLEL: f32 = 0.998_63;
/// The most faces or pairs of faces on the way to a light.
const MOST: usize = 16;

/// Which materials light passes through, if any does and there are lights that no bounce can hit.
#[derive(Debug)]
pub(super) struct Panes {
    transmits: Vec<bool>,
    /// Where all of these are.
    bounds: Aabb,
}

impl Panes {
    /// Those of triangles, of which the first have these `corners`; where the others are is not known.
    pub(super) fn new(
        materials: &[Material],
        records: &[TriangleRecord],
        corners: &[Triangle],
        has_punctual: bool,
    ) -> Self {
        let transmits: Vec<bool> = materials.iter().map(Material::is_glass).collect();
        let is_pane = |record: &TriangleRecord| transmits[record.material as usize];
        if !has_punctual || !records.iter().any(is_pane) {
            return Self { transmits: Vec::new(), bounds: Aabb::EMPTY };
        }
        let everywhere = Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };
        let placed = corners.iter().zip(records).filter(|(_, record)| is_pane(record));
        let bounds = placed.fold(Aabb::EMPTY, |all, (corners, _)| all.union(&Aabb::around(corners)));
        let is_known = !records[corners.len()..].iter().any(is_pane);
        Self { bounds: if is_known { bounds } else { everywhere }, transmits }
    }

    /// Whether a ray may meet any; rounding does not hide one.
    fn may_meet(&self, ray: &Ray) -> bool {
        let margin = 1e-4 * (self.bounds.max.abs().max(self.bounds.min.abs()).max_element() + ray.origin.length());
        let [a, b] = [self.bounds.min - margin, self.bounds.max + margin].map(|at| (at - ray.origin) / ray.direction);
        let (near, far) = (a.min(b).max_element().max(0.0), a.max(b).min_element().min(ray.t_max));
        // Of NaN nothing is known.
        near <= far || near.is_nan() || far.is_nan()
    }
}

/// What a face does to light that crosses it.
struct Face {
    /// The part that it reflects, and what the rest is multiplied by.
    reflected: f32,
    tint: Vec3,
    is_thin: bool,
    absorption: Vec3,
    /// Cosine inside.
    cos_inside: f32,
    /// The square of the refractive index inside.
    ior_squared: f32,
}

impl World {
    /// Whether light that no bounce can find may pass through anything.
    #[inline(always)]
    pub(crate) fn has_panes(&self) -> bool {
        !self.panes.transmits.is_empty()
    }

    /// The part of a shadow ray beyond the panes that it crosses first, in the middle of the shutter's time.
    pub(super) fn past_panes(&self, shadow: Ray) -> Ray {
        if self.has_panes() { self.beyond_panes(shadow, MIDDLE).0 } else { shadow }
    }

    /// The part of a shadow ray beyond the panes that it crosses first, and what they leave of light. A ray that is refracted
    /// is the same, and so is blocked where it meets glass.
    #[inline(never)]
    pub(crate) fn beyond_panes(&self, shadow: Ray, time: f32) -> (Ray, Vec3) {
        let (mut ray, mut left) = (shadow, Vec3::ONE);
        if !self.panes.may_meet(&shadow) {
            return (ray, left);
        }
        for _ in 0..MOST {
            let Some((surface, face)) = self.glass_face(&ray, time) else { return (ray, left) };
            let inner = beyond(&ray, &surface);
            if face.is_thin {
                left *= face.tint * (1.0 - face.reflected) / (1.0 + face.reflected);
                ray = inner;
                continue;
            }
            let single = face.tint * (1.0 - face.reflected);
            if surface.is_back {
                // Out of the solid that the ray begins in; of absorption the path knows as long as the light is inside.
                if face.absorption != Vec3::ZERO {
                    return (shadow, Vec3::ONE);
                }
                (ray, left) = (inner, left * single / face.ior_squared);
                continue;
            }
            let other = self
                .glass_face(&inner, time)
                .filter(|(other, _)| other.is_back && std::ptr::eq(other.material, surface.material));
            let Some((exit, behind)) = other else {
                (ray, left) = (inner, left * single * face.ior_squared);
                continue;
            };
            if surface.smooth_normal.dot(exit.smooth_normal) < PARALLEL {
                return (shadow, Vec3::ONE);
            }
            // Straight on the way is as long as the pane is thick by the cosine outside.
            let cos = surface.smooth_normal.dot(ray.direction.normalize()).abs();
            let way = (exit.position - surface.position).length() * cos / face.cos_inside.max(1e-3);
            let absorbed = (-way * face.absorption).exp();
            let [f, g] = [face.reflected, behind.reflected];
            left *= face.tint * behind.tint * (1.0 - f) * (1.0 - g) * absorbed / (1.0 - f * g * absorbed * absorbed);
            ray = beyond(&inner, &exit);
        }
        (ray, left)
    }

    /// The nearest surface along a ray, turned towards it, if that is smooth glass.
    fn glass_face(&self, ray: &Ray, time: f32) -> Option<(Surface<'_>, Face)> {
        let hit = &self.intersect_at(ray, time);
        if !hit.is_hit() || !self.panes.transmits[self.triangle_records[hit.prim_id as usize].material as usize] {
            return None;
        }
        let surface = self.surface_at(hit).facing(ray.direction);
        let inputs = self.inputs(&surface);
        let weight = inputs.transmission_weight * (1.0 - inputs.base_metalness);
        if weight == 0.0 || !Ggx::new(inputs.specular_roughness, inputs.specular_anisotropy).is_delta() {
            return None;
        }
        // Outside, whichever side that is: straight on there is one angle.
        let cos = surface.smooth_normal.dot(ray.direction.normalize()).abs();
        let Inputs { specular_ior: ior, specular_weight, specular_color, .. } = inputs;
        let (reflected, cos_inside) = Dielectric::new(ior, false, specular_weight, specular_color).at(cos);
        let face = Face {
            // As glass itself has it: what is reflected of any colour is transmitted of none.
            reflected: reflected.max_element(),
            tint: weight * inputs.transmission_color,
            is_thin: inputs.thin_walled,
            absorption: inputs.absorption,
            cos_inside,
            ior_squared: ior * ior,
        };
        Some((surface, face))
    }
}

/// The rest of a ray behind a surface that it has hit.
fn beyond(ray: &Ray, surface: &Surface) -> Ray {
    let origin = surface.origin_towards(ray.direction);
    let t = (origin - ray.origin).dot(ray.direction) / ray.direction.length_squared();
    Ray { origin, t_min: 0.0, t_max: ray.t_max - t, ..*ray }
}

#[cfg(test)]
mod tests;
