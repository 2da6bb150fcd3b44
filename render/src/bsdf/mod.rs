//! What surfaces do with light: diffuse reflection, mirrors, glass.
//!
//! An integrator asks two questions only. [`Surface::sample`]: where does a path go on, with what weight, and how
//! densely are such directions sampled? [`Surface::evaluate`]: how much light from a given direction is reflected, and
//! how densely would `sample` have gone there?
//!
//! # Mirrors without a special case
//!
//! Shirley, who wrote his path tracer on the blackboard in 1998, found one line in it "amazingly ugly": emission counts
//! at depth 0 only, as later surfaces get it by sampling the lights, unless the ray comes from a mirror. "Pete hopes
//! there's a clean way to do this. A mirror is direct lighting with a delta function involved". There is one, and it is
//! just that sentence taken at its word. A delta function's density *is* infinite where it is not zero:
//!
//! - `sample` gives a mirror's direction with the density `∞`;
//! - `evaluate` gives what the delta function is anywhere else: no light, density 0;
//! - whoever can find light in two ways weights each by its density (`LightSampling`), and `∞` beats every light.
//!
//! So light that a mirror shows counts in full, and light that was sampled at the mirror not at all, by the same
//! arithmetic as for any other surface; and depth 0 is no exception either, for the camera's ray came from a pinhole,
//! which is one more delta function. No integrator here asks whether a surface is a mirror.
//!
//! # Deviations
//!
//! What paths carry is basic radiance, `L/n²`, which refraction does not change (Nicodemus 1963), instead of `L`, which
//! grows by the square of the refractive index on the way in and shrinks by it on the way out. Both are the same in
//! air, so the scale need not be lost to rounding and found again; a camera inside of glass shows `L/n²`.
//!
//! Where a shading normal would send a mirror's light through the surface, or glass's back, the triangle's own normal
//! is used instead: no light is lost.

mod dielectric;

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::ONE_MINUS_EPSILON;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};

use crate::scene::Specular;
use crate::world::Surface;

/// How a path goes on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounce {
    /// Unit vector.
    pub direction: Vec3,
    /// What the path's throughput is multiplied by: `f cos θ / density`.
    pub weight: Vec3,
    /// Density per solid angle of this direction; infinite for mirrors and glass.
    pub density: f32,
}

impl Specular {
    /// The part of all light that is reflected or let through, at most, by a surface that also reflects `diffuse`.
    pub(crate) fn reflectance(&self, diffuse: Vec3) -> Vec3 {
        match self {
            Self::None => diffuse,
            Self::Mirror { reflectance } => diffuse + reflectance,
            Self::Glass { .. } => Vec3::ONE,
        }
    }

    /// The probability with which a path takes the mirror's or the glass's way.
    fn probability(&self, diffuse: Vec3) -> f32 {
        let specular = match self {
            Self::None => return 0.0,
            Self::Mirror { reflectance } => reflectance.max_element(),
            Self::Glass { .. } => 1.0,
        };
        specular / (specular + diffuse.max_element()).max(f32::MIN_POSITIVE)
    }
}

/// Of a surface whose normals face the side that light is reflected to.
impl Surface<'_> {
    /// The part of all light that is reflected or let through, at most.
    #[inline]
    pub(crate) fn reflectance(&self) -> Vec3 {
        self.material.specular.reflectance(self.diffuse)
    }

    /// The probability with which a path takes the mirror's or the glass's way.
    #[inline(always)]
    pub(crate) fn specular_probability(&self) -> f32 {
        self.material.specular.probability(self.diffuse)
    }

    /// Where a path along the unit vector `incoming` goes on; `None` if it is absorbed.
    pub(crate) fn sample(&self, incoming: Vec3, u: Vec2) -> Option<Bounce> {
        self.sample_with(incoming, u, CosineHemisphere.map(u))
    }

    /// The same for whoever knows the direction that [`CosineHemisphere`] gives for `u`: batches of them are quick.
    #[inline(always)]
    pub(crate) fn sample_with(&self, incoming: Vec3, mut u: Vec2, cosine: Vec3) -> Option<Bounce> {
        let specular = self.specular_probability();
        if specular == 0.0 {
            let (bounce, reflects) = self.scatter(cosine, self.diffuse, 1.0);
            return reflects.then_some(bounce);
        }
        if u.x < specular {
            u.x = (u.x / specular).min(ONE_MINUS_EPSILON);
            let (direction, weight) = match self.material.specular {
                Specular::None => return None,
                Specular::Mirror { reflectance } => (self.mirrored(incoming), reflectance),
                Specular::Glass { ior, transmittance } => self.refracted(incoming, ior, transmittance, u.x),
            };
            return Some(Bounce { direction, weight: weight / specular, density: f32::INFINITY });
        }
        let probability = 1.0 - specular;
        u.x = ((u.x - specular) / probability).min(ONE_MINUS_EPSILON);
        let (bounce, reflects) = self.scatter(CosineHemisphere.map(u), self.diffuse / probability, probability);
        reflects.then_some(bounce)
    }

    /// Diffuse reflection in a direction about the normal, which was chosen with this probability; and whether there is
    /// any. Without a branch, so that loops over it become lanes.
    #[inline(always)]
    pub(crate) fn scatter(&self, local: Vec3, weight: Vec3, probability: f32) -> (Bounce, bool) {
        let direction = self.frame().to_world(local);
        // A shading normal may send light through the surface: none comes from there.
        let reflects = (self.normal.dot(direction) > 0.0) & (weight.max_element() > 0.0);
        (Bounce { direction, weight, density: probability * local.z * FRAC_1_PI }, reflects)
    }

    /// `f cos θ` for light from the unit vector `direction`, and the density with which [`sample`](Self::sample) gives
    /// it: nothing and zero for mirrors and glass.
    #[inline(always)]
    pub(crate) fn evaluate(&self, direction: Vec3) -> (Vec3, f32) {
        let lambert = self.lambert(direction);
        (self.diffuse * lambert, (1.0 - self.specular_probability()) * lambert)
    }

    /// `cos θ / π` of the unit vector `direction`, or 0 from behind.
    #[inline(always)]
    pub(crate) fn lambert(&self, direction: Vec3) -> f32 {
        let cosine = self.shading_normal.dot(direction);
        let is_before = (cosine > 0.0) & (self.normal.dot(direction) > 0.0);
        if is_before { cosine * FRAC_1_PI } else { 0.0 }
    }

    /// The mirror's direction.
    fn mirrored(&self, incoming: Vec3) -> Vec3 {
        let direction = reflect(incoming, self.shading_normal);
        if self.normal.dot(direction) > 0.0 { direction } else { reflect(incoming, self.normal) }
    }

    /// Glass's reflection, chosen with the probability of what is reflected, or refraction.
    fn refracted(&self, incoming: Vec3, ior: f32, transmittance: Vec3, choice: f32) -> (Vec3, Vec3) {
        // Of the medium that light comes from to the one beyond.
        let ratio = if self.is_back { ior } else { 1.0 / ior };
        let way = |normal: Vec3| {
            let cosine = -normal.dot(incoming);
            let (reflected, cosine_beyond) = dielectric::fresnel(cosine, ratio);
            if choice < reflected {
                (reflect(incoming, normal), Vec3::ONE, self.normal)
            } else {
                let direction = ratio * incoming + (ratio * cosine - cosine_beyond) * normal;
                (direction.normalize(), transmittance, -self.normal)
            }
        };
        let (direction, weight, side) = way(self.shading_normal);
        if side.dot(direction) > 0.0 && self.shading_normal.dot(incoming) < 0.0 {
            return (direction, weight);
        }
        let (direction, weight, _) = way(self.normal);
        (direction, weight)
    }
}

fn reflect(incoming: Vec3, normal: Vec3) -> Vec3 {
    incoming - 2.0 * incoming.dot(normal) * normal
}

#[cfg(test)]
mod tests;
