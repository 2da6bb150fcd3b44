//! Shading normals: a closure at a point whose shading normal is not the surface's own.
//!
//! A shading normal that `wo` sees from behind is mirrored at the plane that `wo` is normal to: on real bumps the other
//! slopes are visible, few of them at grazing angles. A direction that a closure samples on its side of the shading
//! normal but on the other side of the surface is mirrored at the surface; so an energy-conserving closure stays so
//! about any shading normal. Two directions may then lead to one, and [`Shading::eval`] adds both.
//! Bumps that a map draws shadow each other ([`BumpShadowing`]).

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::Frame;

use super::{Bsdf, BumpShadowing, Evaluation, Sample};

/// The least cosine between `wo` and a bent normal.
const LEAST_COSINE: f32 = 0.01;

/// The shading normal on the side of `wo`; where it faces away, it is turned to face `wo` by as much as it faced away.
/// `geometric` and `wo` are on the same side; all are unit vectors.
#[inline]
pub fn bent_normal(geometric: Vec3, shading: Vec3, wo: Vec3) -> Vec3 {
    let shading = if shading.dot(geometric) < 0.0 { -shading } else { shading };
    let cosine = shading.dot(wo);
    if cosine >= LEAST_COSINE {
        return shading;
    }
    // Within the plane of both.
    let to = (-cosine).max(LEAST_COSINE);
    let across = (shading - cosine * wo).normalize_or(Frame::from_normal(wo).tangent);
    ((1.0 - to) * (1.0 + to)).max(0.0).sqrt() * across + to * wo
}

/// Two normals and a tangent, on the side of `wo`.
#[derive(Clone, Copy, Debug)]
pub struct Shading {
    frame: Frame,
    geometric: Vec3,
    bumps: BumpShadowing,
}

impl Shading {
    /// For unit vectors with `geometric` on the side of `wo`. The tangent need not be perpendicular to the normal; where it
    /// is along the normal, or 0, any other is taken.
    #[inline]
    pub fn new(geometric: Vec3, shading: Vec3, tangent: Vec3, wo: Vec3) -> Self {
        let normal = bent_normal(geometric, shading, wo);
        let across = tangent - normal * normal.dot(tangent);
        let frame = if across.length_squared() > 1e-8 * tangent.length_squared() {
            let tangent = across.normalize();
            Frame { tangent, bitangent: normal.cross(tangent), normal }
        } else {
            Frame::from_normal(normal)
        };
        Self { frame, geometric, bumps: BumpShadowing::NONE }
    }

    /// The shading of a frame whose normal is already corrected, with bumps in that frame.
    #[inline(always)]
    pub(crate) fn of(frame: Frame, geometric: Vec3, bumps: BumpShadowing) -> Self {
        Self { frame, geometric, bumps }
    }

    /// With bumps, whose smooth normal is in world space.
    #[inline]
    pub(crate) fn with_bumps(self, smooth: Vec3, bumps: BumpShadowing) -> Self {
        Self { bumps: bumps.with_smooth(self.frame.to_local(smooth)), ..self }
    }

    /// The bumps around, in the shading frame.
    #[inline(always)]
    pub(crate) fn bumps(&self) -> &BumpShadowing {
        &self.bumps
    }

    /// The factor of bumps' shadowing on light that a closure reflects from a direction in the shading frame.
    #[inline(always)]
    fn shadowing(&self, local: Vec3) -> Vec3 {
        if local.z > 0.0 && self.bumps.are_there() { self.bumps.factor(local) } else { Vec3::ONE }
    }

    /// A direction and the one that is mirrored to it, in the shading frame.
    #[inline(always)]
    pub(crate) fn locals(&self, direction: Vec3) -> [Vec3; 2] {
        [self.frame.to_local(direction), self.frame.to_local(self.mirrored(direction))]
    }

    /// Where a direction leads that was sampled in the shading frame, and the other one of the frame that may lead there.
    #[inline(always)]
    pub(crate) fn onwards(&self, local: Vec3) -> (Vec3, Vec3) {
        let sampled = self.frame.to_world(local);
        let other = self.mirrored(sampled);
        let wi = if (self.geometric.dot(sampled) > 0.0) == (local.z > 0.0) { sampled } else { other };
        (wi, self.frame.to_local(other))
    }

    /// The frame of closures.
    #[inline]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The surface's own normal.
    pub(crate) fn geometric(&self) -> Vec3 {
        self.geometric
    }

    #[inline(always)]
    fn mirrored(&self, w: Vec3) -> Vec3 {
        w - 2.0 * self.geometric.dot(w) * self.geometric
    }

    /// [`Bsdf::eval`] of world directions.
    #[inline]
    pub fn eval(&self, closure: &impl Bsdf, wo: Vec3, wi: Vec3) -> Evaluation {
        let wo = self.frame.to_local(wo);
        let is_before = self.geometric.dot(wi) > 0.0;
        let mut sum = Evaluation::default();
        // The direction itself, and the one that is mirrored to it, each if its shading side is the side of `wi`.
        for w in [wi, self.mirrored(wi)] {
            let local = self.frame.to_local(w);
            if (local.z > 0.0) == is_before {
                let Evaluation { f_cos, density, reverse_density } = closure.eval(wo, local);
                sum.f_cos += f_cos * self.shadowing(local);
                sum.density += density;
                sum.reverse_density += reverse_density;
            }
        }
        sum
    }

    /// [`Bsdf::glossy`] of world directions.
    pub fn glossy(&self, closure: &impl Bsdf, wo: Vec3, wi: Vec3) -> Vec3 {
        let wo = self.frame.to_local(wo);
        let is_before = self.geometric.dot(wi) > 0.0;
        // As `eval` does.
        let both = [wi, self.mirrored(wi)].map(|w| self.frame.to_local(w));
        both.into_iter()
            .filter(|local| (local.z > 0.0) == is_before)
            .map(|local| closure.glossy(wo, local) * self.shadowing(local))
            .sum()
    }

    /// [`Bsdf::sample`] of world directions. Where a direction was mirrored, or another could have been mirrored to it, the
    /// density and the weight are those of both.
    #[inline]
    pub fn sample(&self, closure: &impl Bsdf, wo: Vec3, u: Vec2) -> Option<Sample> {
        let wo = self.frame.to_local(wo);
        let sample = closure.sample(wo, u)?;
        let (wi, other) = self.onwards(sample.wi);
        let weight = sample.weight * self.shadowing(sample.wi);
        if sample.density.is_infinite() || (other.z > 0.0) != (sample.wi.z > 0.0) {
            return Some(Sample { wi, weight, ..sample });
        }
        let Evaluation { f_cos, density, .. } = closure.eval(wo, other);
        let sum = sample.density + density;
        Some(Sample {
            wi,
            weight: (weight * sample.density + f_cos * self.shadowing(other)) / sum,
            density: sum,
            ..sample
        })
    }
}
