//! Values of cameras.

use glam::Vec2;

use super::{Reading, Value, expected};
use crate::scene::{CameraKind, FisheyeMapping, SensorFit};

/// The greatest length, so that squares stay within 32 bits.
const MAX_LENGTH: f32 = 1e15;

/// A length, distance or number that is not zero.
pub(in crate::scene) fn length(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(length) if length > 0.0 && length <= MAX_LENGTH => Ok(length),
        _ => expected(format!("a number of more than 0, up to {MAX_LENGTH:e}")),
    }
}

/// The diameter of an aperture, or the distance of two eyes, in mm.
pub(in crate::scene) fn aperture(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(mm) if (0.0..=MAX_LENGTH).contains(&mm) => Ok(mm),
        _ => expected(format!("millimetres from 0 to {MAX_LENGTH:e}")),
    }
}

/// The distance of the near plane.
pub(in crate::scene) fn near(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(near) if (0.0..=MAX_LENGTH).contains(&near) => Ok(near),
        _ => expected(format!("a number from 0 to {MAX_LENGTH:e}")),
    }
}

/// The size of a sensor in mm.
pub(in crate::scene) fn sensor(value: &Value) -> Reading<Vec2> {
    match value.two() {
        Some(size) if size.min_element() > 0.0 && size.max_element() <= MAX_LENGTH => Ok(size),
        _ => expected("two numbers of more than 0: width and height in millimetres"),
    }
}

/// The shift of a lens.
pub(in crate::scene) fn shift(value: &Value) -> Reading<Vec2> {
    match value.two() {
        Some(shift) if shift.abs().max_element() <= 1e3 => Ok(shift),
        _ => expected("two numbers from -1000 to 1000: to the right and up, in parts of the picture's side"),
    }
}

/// The number of an aperture's blades.
pub(in crate::scene) fn blades(value: &Value) -> Reading<u32> {
    match value.integer() {
        Some(blades @ (0 | 3..=64)) => Ok(blades),
        _ => expected("0 for a disc, or a whole number from 3 to 64"),
    }
}

/// The height of an aperture over its width.
pub(in crate::scene) fn anamorphic(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(ratio) if (0.01..=100.0).contains(&ratio) => Ok(ratio),
        _ => expected("a number from 0.01 to 100: the aperture's height over its width"),
    }
}

/// The field of view of a fisheye.
pub(in crate::scene) fn fisheye_fov(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(degrees) if degrees > 0.0 && degrees <= 360.0 => Ok(degrees),
        _ => expected("degrees, more than 0 and at most 360"),
    }
}

/// A kind of camera.
pub(in crate::scene) fn camera_kind(value: &Value) -> Reading<CameraKind> {
    value.one_of(&CameraKind::ALL.map(|kind| (kind.name(), kind)))
}

/// The mapping of a fisheye.
pub(in crate::scene) fn fisheye(value: &Value) -> Reading<FisheyeMapping> {
    value.one_of(&FisheyeMapping::ALL.map(|mapping| (mapping.name(), mapping)))
}

/// The side that a sensor fits.
pub(in crate::scene) fn sensor_fit(value: &Value) -> Reading<SensorFit> {
    value.one_of(&SensorFit::ALL.map(|fit| (fit.name(), fit)))
}
