//! Where the scene shows what is in its items, for queries without rays.

use core::ops::ControlFlow;

use glam::{DMat3, DVec3};

use super::SceneHit;
use super::image_box::image;
use super::transform::Placement;
use crate::geometry::moment::Moment;
use crate::geometry::{Aabb, Triangle};

/// Takes coordinates of an item to the outermost scene.
#[derive(Clone, Copy)]
pub(super) struct Space {
    linear: DMat3,
    translation: DVec3,
}

impl Space {
    /// The scene's own.
    pub(super) const OWN: Self = Self { linear: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// That of an item in this space at a time; `None` if it is nowhere to be seen.
    pub(super) fn of(&self, placement: &Placement, time: f32) -> Option<Self> {
        let (linear, translation) = placement.elements(time)?;
        Some(Self { linear: self.linear * linear, translation: self.linear * translation + self.translation })
    }

    /// Where a triangle is: the definition.
    pub(super) fn triangle(&self, corners: &Triangle) -> Triangle {
        corners.map(|corner| (self.linear * corner.as_dvec3() + self.translation).as_vec3())
    }

    /// A box around the image of one.
    pub(super) fn aabb(&self, local: &Aabb) -> Aabb {
        image(&self.linear, self.translation, local, 0.0)
    }
}

/// What is looked for.
pub(super) trait Proximity {
    /// A measure of a box, never greater than that of anything in it.
    fn measure(&self, aabb: &Aabb) -> f32;

    /// What has a greater measure is of no interest.
    fn most(&self) -> f32;

    /// Sees a triangle. `Break` ends the search.
    fn meet(&mut self, triangle: &Triangle, place: SceneHit) -> ControlFlow<()>;

    /// Sees the box of a primitive of a shape.
    fn meet_box(&mut self, aabb: &Aabb, place: SceneHit) -> ControlFlow<()>;
}

/// The key after a moment, if it is not at one.
pub(super) fn next(moment: Moment) -> usize {
    moment.key + usize::from(moment.fraction != 0.0)
}

/// A triangle on its way from one key to the next.
pub(super) fn between(from: &Triangle, to: &Triangle, fraction: f32) -> Triangle {
    let corner = |i: usize| if fraction == 0.0 { from[i] } else { from[i] * (1.0 - fraction) + to[i] * fraction };
    [corner(0), corner(1), corner(2)]
}
