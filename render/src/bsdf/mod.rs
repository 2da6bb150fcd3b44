//! BSDFs of surfaces: closures in world space.
//!
//! A closure ([`material`](crate::material)) works in the shading frame alone, and [`Shading`] handles light that a
//! shading normal sends through the surface. [`Scattering`] combines both in world space.

mod lambert;

use glam::{Vec2, Vec3};

use crate::material::{Bsdf, BumpShadowing, Closure, Inputs, Kind, Matte, Shading};
use crate::scene::CoatNormal;
use crate::world::{Surface, World};

/// The direction whose cosine is the mean cosine of diffuse light: closures have about the albedo there that they have for
/// light from everywhere.
const AVERAGE_DIRECTION: Vec3 = Vec3::new(0.745_356, 0.0, 2.0 / 3.0);

/// The continuation of a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounce {
    /// Unit vector.
    pub direction: Vec3,
    /// The factor on the path's throughput: `f cos θ / density`.
    pub weight: Vec3,
    /// Density per solid angle of this direction; infinite for mirrors and clear glass.
    pub density: f32,
}

impl Bounce {
    /// The value for no bounce.
    pub(crate) const NONE: Self = Self { direction: Vec3::Z, weight: Vec3::ZERO, density: 0.0 };
}

/// The closure at a surface, in world space, for light that leaves towards the surface's `wo`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scattering<B> {
    closure: B,
    shading: Shading,
    wo: Vec3,
}

impl<B: Bsdf> Scattering<B> {
    /// Of a surface whose normals face `wo`, and its closure on this side.
    #[inline]
    pub(crate) fn new(surface: &Surface, closure: B) -> Self {
        let Surface { normal, smooth_normal, shading_normal, tangent, wo, .. } = *surface;
        let mut shading = Shading::new(normal, shading_normal, tangent, wo);
        // A coat with normals of its own, which reflects most light at low angles, is not in the shadow of bumps below it.
        if shading_normal != smooth_normal && surface.material.coat_normal == CoatNormal::OfBase {
            let tilted = shading.frame().normal;
            let bumps = BumpShadowing::new(smooth_normal, tilted, closure.albedo(AVERAGE_DIRECTION));
            shading = shading.with_bumps(smooth_normal, bumps);
        }
        Self { closure, shading, wo }
    }

    /// The closure, in the shading frame.
    pub(crate) fn closure(&self) -> &B {
        &self.closure
    }

    /// The shading frame.
    pub(crate) fn shading(&self) -> &Shading {
        &self.shading
    }

    /// The unit vector to where it is seen from.
    pub(crate) fn wo(&self) -> Vec3 {
        self.wo
    }

    /// `f cos θ` for light from the unit vector `direction`, and the density per solid angle with which
    /// [`sample`](Self::sample) gives it: nothing and zero for mirrors and clear glass.
    #[inline]
    pub(crate) fn eval(&self, direction: Vec3) -> (Vec3, f32) {
        let evaluation = self.shading.eval(&self.closure, self.wo, direction);
        (evaluation.f_cos, evaluation.density)
    }

    /// The part of [`eval`](Self::eval)'s light that is that of glossy lobes.
    pub(crate) fn glossy(&self, direction: Vec3) -> Vec3 {
        self.shading.glossy(&self.closure, self.wo, direction)
    }

    /// The next direction of a path; `None` if it is absorbed.
    #[inline]
    pub(crate) fn sample(&self, u: Vec2) -> Option<Bounce> {
        let sample = self.shading.sample(&self.closure, self.wo, u)?;
        Some(Bounce { direction: sample.wi, weight: sample.weight, density: sample.density })
    }

    /// The part of light from the mirror direction about the shading normal that delta functions reflect to `wo`.
    pub(crate) fn mirror_reflectance(&self) -> Vec3 {
        self.closure.mirror_reflectance(self.shading.frame().to_local(self.wo))
    }

    /// The part of uniform light around the surface that reaches `wo`.
    #[inline]
    pub(crate) fn albedo(&self) -> Vec3 {
        self.closure.albedo(self.shading.frame().to_local(self.wo)) * self.shading.bumps().mean()
    }

    /// The albedo of diffuse reflection alone.
    #[inline]
    pub(crate) fn diffuse_albedo(&self) -> Vec3 {
        self.closure.diffuse_albedo(self.shading.frame().to_local(self.wo)) * self.shading.bumps().mean()
    }

    /// Whether light from behind is scattered, mirrors and clear glass left aside.
    #[inline]
    pub(crate) fn transmits(&self) -> bool {
        self.closure.transmits()
    }
}

impl World {
    /// The closure of a surface whose normals face the viewer; passes the surface the data that it needs, and the shading
    /// normal as it is bent to the viewer.
    pub(crate) fn scattering(&self, surface: &mut Surface) -> Scattering<Closure> {
        let kind = self.kind(surface.prim_id);
        let scattering = if kind == Kind::Matte {
            let inputs = Inputs { base_color: surface.diffuse, ..Inputs::default() };
            Scattering::new(surface, Closure::of_kind(kind, &inputs, surface.is_back))
        } else {
            let scattering = Scattering::new(surface, self.closure::<Closure>(surface));
            surface.transmits = scattering.transmits();
            surface.diffuse = scattering.diffuse_albedo();
            scattering
        };
        surface.shading_normal = scattering.shading.frame().normal;
        scattering
    }
}

impl Surface<'_> {
    /// The closure of a white diffuse surface here: what it reflects is what it receives, by π.
    pub(crate) fn white(&self) -> Scattering<Matte> {
        let inputs = Inputs { base_color: Vec3::ONE, ..Inputs::default() };
        Scattering::new(self, Matte::new(&inputs, self.is_back))
    }
}

#[cfg(test)]
mod tests;
