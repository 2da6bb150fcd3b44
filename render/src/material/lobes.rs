//! Sampling of closures with several lobes: one lobe is chosen by its expected energy at this angle, and its direction
//! is weighted with all lobes and their densities. Delta functions are kept separate.

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::ONE_MINUS_EPSILON;

use super::column::Column;
use super::{Bsdf, Evaluation, Event, Inputs, Sample};

/// An [`Evaluation`] in two parts, as layers above treat them differently.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Parts {
    /// `f |cos θi|` of lobes about one direction.
    pub(super) glossy: Vec3,
    /// `f |cos θi|` of lobes that scatter everywhere.
    pub(super) wide: Vec3,
    /// See [`Evaluation`].
    pub(super) density: f32,
    /// See [`Evaluation`].
    pub(super) reverse_density: f32,
}

impl Parts {
    /// Adds what a part of the surface does.
    #[inline]
    pub(super) fn add(&mut self, share: f32, parts: &Self) {
        self.glossy += share * parts.glossy;
        self.wide += share * parts.wide;
        self.density += share * parts.density;
        self.reverse_density += share * parts.reverse_density;
    }
}

/// Roughly how much is scattered.
#[derive(Clone, Copy)]
pub(super) struct Energy {
    /// In all.
    pub(super) all: f32,
    /// About one direction, by angle, and its tint, of what is not glass.
    pub(super) glossy: Column,
    pub(super) tint: Vec3,
    /// The energy of wide lobes by angle, in any unit but 0.
    pub(super) wide: Column,
}

/// A sample of a lobe.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    /// Unit vector.
    pub(super) wi: Vec3,
    /// The lobe.
    pub(super) event: Event,
    /// For a delta function: its value divided by the probability of its choice.
    pub(super) delta: Option<Vec3>,
}

impl Choice {
    /// A sample of a lobe with a density.
    #[inline]
    pub(super) fn new(wi: Vec3, event: Event) -> Self {
        Self { wi, event, delta: None }
    }

    /// A sample of a delta function on this side.
    #[inline]
    pub(super) fn delta(wi: Vec3, weight: Vec3, side: Event) -> Self {
        Self { wi, event: Event::SPECULAR | side, delta: Some(weight) }
    }
}

/// What a closure of lobes is made of; it gives a [`Bsdf`].
pub(super) trait Lobes {
    /// See [`Bsdf::new`].
    fn new(inputs: &Inputs, is_inside: bool) -> Self;
    /// All lobes but delta functions.
    fn parts(&self, wo: Vec3, wi: Vec3) -> Parts;
    /// A direction from one of the lobes.
    fn choose(&self, wo: Vec3, u: Vec2) -> Option<Choice>;
    /// See [`Bsdf::mirror_reflectance`].
    fn mirror_reflectance(&self, wo: Vec3) -> Vec3;
    /// See [`Bsdf::albedo`].
    fn albedo(&self, wo: Vec3) -> Vec3;
    /// See [`Bsdf::diffuse_albedo`].
    fn diffuse_albedo(&self, wo: Vec3) -> Vec3;
    /// See [`Bsdf::transmits`].
    fn transmits(&self) -> bool;
}

impl<T: Lobes> Bsdf for T {
    #[inline]
    fn new(inputs: &Inputs, is_inside: bool) -> Self {
        Lobes::new(inputs, is_inside)
    }

    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> Evaluation {
        let Parts { glossy, wide, density, reverse_density } = self.parts(wo, wi);
        Evaluation { f_cos: glossy + wide, density, reverse_density }
    }

    fn glossy(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        self.parts(wo, wi).glossy
    }

    #[inline]
    fn sample(&self, wo: Vec3, u: Vec2) -> Option<Sample> {
        let Choice { wi, event, delta } = self.choose(wo, u)?;
        if let Some(weight) = delta {
            return Some(Sample { wi, weight, density: f32::INFINITY, event });
        }
        let Evaluation { f_cos, density, .. } = self.eval(wo, wi);
        (density > 0.0).then(|| Sample { wi, weight: f_cos / density, density, event })
    }

    fn mirror_reflectance(&self, wo: Vec3) -> Vec3 {
        Lobes::mirror_reflectance(self, wo)
    }

    #[inline]
    fn albedo(&self, wo: Vec3) -> Vec3 {
        Lobes::albedo(self, wo)
    }

    #[inline]
    fn diffuse_albedo(&self, wo: Vec3) -> Vec3 {
        Lobes::diffuse_albedo(self, wo)
    }

    #[inline]
    fn transmits(&self) -> bool {
        Lobes::transmits(self)
    }
}

/// The energy of a colour in the choice of lobes.
#[inline]
pub(super) fn mean(color: Vec3) -> f32 {
    (color.x + color.y + color.z) * (1.0 / 3.0)
}

/// Whether an event of this probability happens by `u` in [0, 1), which is left uniform.
#[inline(always)]
pub(super) fn choose(u: &mut f32, probability: f32) -> bool {
    let happens = *u < probability;
    *u = if happens { *u / probability } else { (*u - probability) / (1.0 - probability) }.min(ONE_MINUS_EPSILON);
    happens
}
