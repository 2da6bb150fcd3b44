//! Values of pictures: size, frames, filter and sampler.

use halfdome_kernel::sampling::Pattern;

use super::{Reading, Value, expected};
use crate::settings::{Filter, MAX_SIDE};

/// The width or height of a picture.
pub(in crate::scene) fn side(value: &Value) -> Reading<u32> {
    match value.integer() {
        Some(pixels @ 1..=MAX_SIDE) => Ok(pixels),
        _ => expected(format!("a whole number of pixels from 1 to {MAX_SIDE}")),
    }
}

/// A frame of an animation, also between two.
pub(in crate::scene) fn frame(value: &Value) -> Reading<f64> {
    match value.double() {
        Some(frame) if frame.abs() <= 1e6 => Ok(frame),
        _ => expected("a number of a frame from -1000000 to 1000000, for example 12 or 12.5"),
    }
}

/// Frames per second.
pub(in crate::scene) fn fps(value: &Value) -> Reading<f64> {
    match value.double() {
        Some(fps) if fps > 0.0 && fps <= 1e6 => Ok(fps),
        _ => expected("frames per second, more than 0 and at most 1000000"),
    }
}

/// A pixel filter's name.
pub(in crate::scene) fn filter(value: &Value) -> Reading<String> {
    value.one_of(&Filter::NAMES.map(|name| (name, name))).map(str::to_owned)
}

/// A filter's full width in pixels.
pub(in crate::scene) fn filter_width(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(width) if width > 0.0 && width <= Filter::MAX_WIDTH => Ok(width),
        _ => expected(format!("a number of pixels, more than 0 and at most {}", Filter::MAX_WIDTH)),
    }
}

/// A filter's sharpness.
pub(in crate::scene) fn sharpness(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(sharpness @ 0.0..=1.0) => Ok(sharpness),
        _ => expected("a number from 0 (soft) to 1 (sharp)"),
    }
}

/// The sampler of random numbers.
pub(in crate::scene) fn sampler(value: &Value) -> Reading<Pattern> {
    value.one_of(&[("random", Pattern::Random), ("sobol", Pattern::Sobol), ("r2", Pattern::R2)])
}
