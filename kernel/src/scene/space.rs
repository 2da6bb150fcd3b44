//! Spaces of items relative to the outermost scene, for queries without rays.

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
    /// The scene's own space.
    pub(super) const OWN: Self = Self { linear: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// The space of an item in this space at a time; `None` if the item is hidden.
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

/// A proximity search.
pub(super) trait Proximity {
    /// A measure of a box, never greater than that of anything in it.
    fn measure(&self, aabb: &Aabb) -> f32;

    /// Primitives with a greater measure are ignored.
    fn most(&self) -> f32;

    /// Takes a triangle. `Break` ends the search.
    fn meet(&mut self, triangle: &Triangle, place: SceneHit) -> ControlFlow<()>;

    /// Takes the box of a primitive of a shape.
    fn meet_box(&mut self, aabb: &Aabb, place: SceneHit) -> ControlFlow<()>;
}

/// The key after a moment, if it is not at one.
pub(super) fn next(moment: Moment) -> usize {
    moment.key + usize::from(moment.fraction != 0.0)
}

/// A triangle interpolated between two keys.
pub(super) fn between(from: &Triangle, to: &Triangle, fraction: f32) -> Triangle {
    let corner = |i: usize| if fraction == 0.0 { from[i] } else { from[i] * (1.0 - fraction) + to[i] * fraction };
    [corner(0), corner(1), corner(2)]
}
