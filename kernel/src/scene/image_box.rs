//! Boxes around the images of boxes.

use glam::{Affine3A, DMat3, DVec3, Vec3};

use super::inverse::{linear, translation};
use crate::geometry::Aabb;

/// Boxes that move are widened by this times their largest coordinate: for the rounding of fractions of time and of
/// interpolation.
pub(super) const MOVING_PAD: f64 = 16.0 / (1u32 << 24) as f64;

/// The widening of boxes that move with these transforms and a box.
pub(super) fn moving_pad(keys: &[Affine3A], local: &Aabb) -> f64 {
    let images = keys.iter().map(|transform| image_at(transform, local, 0.0));
    let largest = images.fold(Vec3::ZERO, |largest, aabb| largest.max(aabb.min.abs()).max(aabb.max.abs()));
    f64::from(largest.max_element()) * MOVING_PAD
}

/// A box around the image of a box, widened by `pad`.
pub(super) fn image_at(transform: &Affine3A, local: &Aabb, pad: f64) -> Aabb {
    image(&linear(transform), translation(transform), local, pad)
}

/// A box around the image of a box, by the transform's elements.
pub(super) fn image(linear: &DMat3, translation: DVec3, local: &Aabb, pad: f64) -> Aabb {
    if local.is_empty() {
        return Aabb::EMPTY;
    }
    if !(local.min.is_finite() && local.max.is_finite()) {
        // Zero times infinity would be no number, and the box seem empty.
        return Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };
    }
    let (mut min, mut max, mut size) = (translation, translation, translation.abs());
    for axis in 0..3 {
        let (low, high) =
            (linear.col(axis) * f64::from(local.min[axis]), linear.col(axis) * f64::from(local.max[axis]));
        min += low.min(high);
        max += low.max(high);
        size += low.abs().max(high.abs());
    }
    // The sums are rounded, and then once more to `f32`.
    let pad = size * (8.0 * f64::EPSILON) + pad;
    let (min, max) = ((min - pad).to_array(), (max + pad).to_array());
    Aabb {
        min: Vec3::from_array(min.map(|x| (x as f32).next_down())),
        max: Vec3::from_array(max.map(|x| (x as f32).next_up())),
    }
}

pub(super) fn round_up(x: f64) -> f32 {
    (x as f32).next_up()
}
