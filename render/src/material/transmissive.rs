//! Glass mixed with other reflection: see [`Glass`] and [`Glossy`].

use glam::{Vec2, Vec3};

use super::column::Column;
use super::glass::Glass;
use super::lobes::{Choice, Energy, Lobes, Parts, choose};
use super::{Glossy, Inputs};

/// See [`Kind::Transmissive`](super::Kind::Transmissive).
#[derive(Clone, Copy, Debug)]
pub struct Transmissive {
    /// The part of the surface that is glass.
    share: f32,
    glass: Option<Glass>,
    rest: Option<Glossy>,
}

impl Transmissive {
    #[inline]
    pub(super) fn energy(&self) -> Energy {
        let mut energy = Energy { all: 0.0, glossy: Column::ZERO, tint: Vec3::ONE, wide: Column::ONE };
        if let Some(glass) = &self.glass {
            energy.all += self.share * glass.energy();
        }
        if let Some(rest) = &self.rest {
            let (share, rest) = (1.0 - self.share, rest.energy());
            energy.all += share * rest.all;
            energy.glossy = rest.glossy.map(|glossy| share * glossy);
            (energy.tint, energy.wide) = (rest.tint, rest.wide);
        }
        energy
    }
}

impl Lobes for Transmissive {
    #[inline]
    fn new(inputs: &Inputs, is_inside: bool) -> Self {
        let share = (1.0 - inputs.base_metalness) * inputs.transmission_weight;
        let rest = || Glossy::with_metalness(inputs, inputs.base_metalness / (1.0 - share));
        Self { share, glass: (share > 0.0).then(|| Lobes::new(inputs, is_inside)), rest: (share < 1.0).then(rest) }
    }

    #[inline]
    fn parts(&self, wo: Vec3, wi: Vec3) -> Parts {
        let mut parts = Parts::default();
        if let Some(glass) = &self.glass {
            parts.add(self.share, &glass.parts(wo, wi));
        }
        if let Some(rest) = &self.rest {
            parts.add(1.0 - self.share, &rest.parts(wo, wi));
        }
        parts
    }

    #[inline]
    fn choose(&self, wo: Vec3, mut u: Vec2) -> Option<Choice> {
        // Both are chosen as often as there is of them, which is what the weight of a delta function is divided by too.
        if choose(&mut u.x, self.share) {
            self.glass.as_ref()?.choose(wo, u)
        } else {
            self.rest.as_ref()?.choose(wo, u)
        }
    }

    fn mirror_reflectance(&self, wo: Vec3) -> Vec3 {
        let glass = self.glass.as_ref().map_or(Vec3::ZERO, |glass| self.share * glass.mirror_reflectance(wo));
        let rest = |rest: &Glossy| (1.0 - self.share) * Lobes::mirror_reflectance(rest, wo);
        glass + self.rest.as_ref().map_or(Vec3::ZERO, rest)
    }

    fn albedo(&self, wo: Vec3) -> Vec3 {
        let glass = self.glass.as_ref().map_or(Vec3::ZERO, |glass| self.share * glass.albedo(wo));
        glass + self.rest.as_ref().map_or(Vec3::ZERO, |rest| (1.0 - self.share) * Lobes::albedo(rest, wo))
    }

    fn diffuse_albedo(&self, wo: Vec3) -> Vec3 {
        self.rest.as_ref().map_or(Vec3::ZERO, |rest| (1.0 - self.share) * Lobes::diffuse_albedo(rest, wo))
    }

    #[inline]
    fn transmits(&self) -> bool {
        self.glass.as_ref().is_some_and(Lobes::transmits) || self.rest.as_ref().is_some_and(Lobes::transmits)
    }
}
