//! Scenes with only a few emissive triangles as lights, such as rooms with one lamp: no tree is traversed, and the
//! weights of many receivers are computed in lanes, which is faster than the weights of many lights for one receiver.

use halfdome_kernel::sampling::ONE_MINUS_EPSILON;

use super::Receiver;
use super::tree::leaf::{TriangleLight, triangle};

/// The most lights.
pub(crate) const FEW: usize = 4;

/// The weight of each of a few lights for a receiver, as in [`Tree`](super::tree::Tree); 0 beyond the last.
#[inline(always)]
pub(crate) fn weight(light: &TriangleLight, receiver: &Receiver) -> f32 {
    let TriangleLight { corners, normal, radiance, area, both_sides } = *light;
    triangle(receiver, corners, normal, radiance, area, f32::from(both_sides))
}

/// The sum of a few weights.
#[inline(always)]
pub(crate) fn sum([a, b, c, d]: [f32; FEW]) -> f32 {
    (a + b) + (c + d)
}

/// The 24 bits that a choice among few takes of a number in [0, 1).
pub(super) fn coarse(u: f64) -> f32 {
    const STEPS: f64 = 16_777_216.0;
    ((u * STEPS).floor() / STEPS) as f32
}

/// Chooses one of a few lights with these weights by a number in [0, 1), with its probability and the remainder of the
/// number. Without a branch, and in single precision, so that loops over it are vectorised. If all weights are 0, so is
/// the probability.
#[inline(always)]
pub(crate) fn choose(weights: [f32; FEW], u: f32) -> (u32, f32, f32) {
    let total = sum(weights);
    let place = u * total;
    let (mut index, mut chosen, mut start, mut end) = (0, 0.0, 0.0, 0.0);
    for (i, &weight) in (0..).zip(&weights) {
        // The last that is not 0, if rounding led behind all of them.
        let is_next = (place >= end) & (weight > 0.0);
        index = if is_next { i } else { index };
        chosen = if is_next { weight } else { chosen };
        start = if is_next { end } else { start };
        end += weight;
    }
    let is_lit = total > 0.0;
    let rest = (place - start) / if is_lit { chosen } else { 1.0 };
    let probability = chosen / if is_lit { total } else { 1.0 };
    (index, probability, rest.clamp(0.0, ONE_MINUS_EPSILON))
}
