//! The state of a path between two surfaces, and the decision whether it continues.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::unit_double;

use crate::light::Receiver;
use crate::settings::Survival;

/// A path that is under way, in eight words.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Path {
    /// Its camera ray.
    pub index: u32,
    /// The throughput.
    pub throughput: Vec3,
    /// Density per solid angle of its last bounce; infinite after mirrors and glass, and for the camera's ray.
    pub density: f32,
    /// The probability with which light samples of its last surface looked at the sky.
    pub sky_probability: f32,
    /// The normal of its last surface, packed as a [`Receiver`] has it: which light might have been sampled there? And in the
    /// first bit, whether it [sees lights](Self::sees_lights) of a size.
    pub normal: u32,
    /// One more than the `prim_id` of the secondary light that it was aimed at; 0 for a path that has left a surface that
    /// aims, and [`UNAIMED`](Self::UNAIMED) for one that has left another.
    pub target: u32,
}

impl Path {
    /// The flag in `normal`.
    const SEES_LIGHTS: u32 = 1 << 31;

    /// The density per solid angle from which on a bounce is about one direction: a cosine's is less, and of microfacets of the
    /// roughness 0.1 one in forty bounces has less.
    const NARROW: f32 = 0.5;

    /// The normal of a path that has left no surface yet. None has coordinates like these.
    const NOWHERE: u32 = u32::MAX;

    /// The normal of a path that has left only mirrors and clear glass, where it does not matter.
    const MIRRORED: u32 = u32::MAX - 1;

    /// The `target` of a path that has left a secondary light: these do not aim, as their own bounces find the others.
    pub(super) const UNAIMED: u32 = u32::MAX;

    /// Whether it was aimed at a secondary light.
    #[inline(always)]
    pub(super) fn is_aimed(&self) -> bool {
        self.target.wrapping_add(1) > 1
    }

    /// Whether it has left no surface yet.
    #[inline(always)]
    pub(super) fn is_first(&self) -> bool {
        self.normal >= Self::MIRRORED
    }

    /// Whether it sees lights of a size that no triangle stands for. The camera does not, mirrors and clear glass that it
    /// sees do, and glossy surfaces where their light samples know of it. Of what mirrors show to surfaces, only what these
    /// reflect about one direction counts: paths would find the rest too rarely, and it is left out, as the light of those
    /// of no size is.
    #[inline(always)]
    pub(super) fn sees_lights(&self) -> bool {
        self.normal & Self::SEES_LIGHTS != 0 && self.normal != Self::NOWHERE
    }

    /// Whether it has been spread by a wide lobe: in its last bounce, or before the mirrors and clear glass that followed.
    #[inline(always)]
    pub(super) fn is_spread(&self) -> bool {
        let is_shown_to_wide = self.normal & Self::SEES_LIGHTS == 0;
        !self.is_first()
            && if self.density == f32::INFINITY { is_shown_to_wide } else { !Self::is_narrow(self.density) }
    }

    /// Whether a bounce of this density is about one direction.
    #[inline(always)]
    pub(super) fn is_narrow(density: f32) -> bool {
        density >= Self::NARROW
    }

    /// The `normal` of a path that leaves a surface with this packed normal, where it had `normal` and `density` before, and
    /// now has the density `next`; whether it was reflected, and whether light samples there leave a part of the lights to it.
    #[inline(always)]
    pub(super) fn normal_after(
        packed: u32,
        (normal, density): (u32, f32),
        (next, is_reflected): (f32, bool),
        shares_lights: bool,
    ) -> u32 {
        // Through glass the light samples of a surface may have come.
        let is_narrow = (density == f32::INFINITY) | (Self::is_narrow(density) & is_reflected);
        let is_shown = is_narrow & (normal & Self::SEES_LIGHTS != 0);
        let sees = if next == f32::INFINITY { is_shown } else { shares_lights };
        packed | if sees { Self::SEES_LIGHTS } else { 0 }
    }

    /// The `normal` after a mirror or clear glass.
    #[inline]
    pub(super) fn normal_mirrored(&self) -> u32 {
        if self.is_first() && self.density == f32::INFINITY { Self::MIRRORED } else { self.normal & !Self::SEES_LIGHTS }
    }

    /// The `normal` behind panes, whose straight light of lights of a size is known.
    pub(super) fn normal_behind_pane(&self) -> u32 {
        if self.is_first() { self.normal } else { self.normal & !Self::SEES_LIGHTS }
    }

    /// The `normal` after a reflection by a mirror with this packed normal.
    pub(super) fn normal_mirrored_by(&self, packed: u32) -> u32 {
        Self::normal_after(packed, (self.normal, self.density), (f32::INFINITY, true), false)
    }

    /// The path that begins with the camera ray of this number, whose direction had this density.
    pub(super) fn from_camera(index: u32, density: f32) -> Self {
        Self { index, throughput: Vec3::ONE, density, sky_probability: 0.0, normal: Self::NOWHERE, target: 0 }
    }

    /// The surface that it comes from along a ray with this origin.
    #[inline(always)]
    pub(super) fn receiver(&self, origin: Vec3) -> Receiver {
        Receiver::unpack(origin, self.normal)
    }
}

/// The number that chooses the light.
#[inline(always)]
pub(super) fn u_light_choice(u_light: Vec2, u_direction: Vec2) -> f64 {
    unit_double(Vec2::new(u_light.x, u_direction.x))
}

/// The survival probability of a path with the remaining light `reflected`.
#[inline(always)]
pub(super) fn survive(survival: Survival, reflected: Vec3) -> f32 {
    match survival {
        Survival::Constant(probability) => probability,
        Survival::Throughput { max } => reflected.max_element().min(max),
        Survival::RootThroughput => reflected.max_element().sqrt().min(1.0),
    }
}

impl AsMut<Self> for Path {
    fn as_mut(&mut self) -> &mut Self {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_that_have_lost_nothing_end_by_no_root() {
        let of = |survival, throughput: f32| survive(survival, Vec3::new(0.0, throughput, 0.5 * throughput));
        assert_eq!([1.0, 0.25, 4.0].map(|throughput| of(Survival::RootThroughput, throughput)), [1.0, 0.5, 1.0]);
        assert_eq!([1.0, 0.25].map(|throughput| of(Survival::THROUGHPUT, throughput)), [0.95, 0.25]);
        assert_eq!(of(Survival::Constant(0.7), 0.1), 0.7);
    }
}
