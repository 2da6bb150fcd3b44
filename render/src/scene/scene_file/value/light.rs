//! Values of lights: radiance, scales, extents, daylight.

use glam::Vec3;

use super::{Reading, Value, expected};
use crate::scene::{Daylight, DaylightModel, LightUnits, PunctualLight};

/// Radiance: one number for all channels, or three.
pub(crate) fn radiance(value: &Value) -> Reading<Vec3> {
    match value.finite().map(Vec3::splat).or_else(|| value.three()) {
        Some(radiance) if radiance.min_element() >= 0.0 => Ok(radiance),
        _ => expected("one number, or three for red, green and blue, finite and not negative"),
    }
}

/// A factor of light.
pub(crate) fn scale(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(scale) if scale >= 0.0 => Ok(scale),
        _ => expected("a number, finite and not negative"),
    }
}

/// The radius of lights; 0 makes them delta lights.
pub(crate) fn light_radius(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(radius) if (0.0..=PunctualLight::MAX_RADIUS).contains(&radius) => Ok(radius),
        _ => expected("a number from 0 (hard shadows) to 1e15"),
    }
}

/// The angle that a directional light subtends, degrees.
pub(crate) fn sun_angle(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(angle) if (0.0..=179.0).contains(&angle) => Ok(angle),
        _ => expected("degrees from 0 (hard shadows) to 179"),
    }
}

/// The sun's elevation and azimuth, and turbidity.
pub(crate) fn daylight(value: &Value) -> Reading<Daylight> {
    const TURBIDITY: std::ops::RangeInclusive<f32> = Daylight::MIN_TURBIDITY..=Daylight::MAX_TURBIDITY;
    let numbers = match value {
        Value::List(values) => values.iter().map(Value::finite).collect::<Option<Vec<f32>>>().unwrap_or_default(),
        _ => Vec::new(),
    };
    let (elevation, azimuth, turbidity) = match numbers[..] {
        [elevation, azimuth] => (elevation, azimuth, 3.0),
        [elevation, azimuth, turbidity] => (elevation, azimuth, turbidity),
        _ => return expected("the sun's elevation and azimuth in degrees, and the turbidity if it is not 3"),
    };
    match (0.0..=90.0).contains(&elevation) && TURBIDITY.contains(&turbidity) {
        true => Ok(Daylight { elevation, azimuth, turbidity }),
        false => expected(format!(
            "an elevation from 0 to 90 degrees, and a turbidity from {} to {}",
            TURBIDITY.start(),
            TURBIDITY.end()
        )),
    }
}

/// The model of daylight's sky.
pub(crate) fn daylight_model(value: &Value) -> Reading<DaylightModel> {
    value.one_of(&DaylightModel::NAMES)
}

/// Reflectance: one number for all channels, or three.
pub(crate) fn albedo(value: &Value) -> Reading<Vec3> {
    match value.finite().map(Vec3::splat).or_else(|| value.three()) {
        Some(albedo) if albedo.min_element() >= 0.0 && albedo.max_element() <= 1.0 => Ok(albedo),
        _ => expected("one number, or three for red, green and blue, from 0 to 1"),
    }
}

/// Whether both sides emit.
pub(crate) fn emission(value: &Value) -> Reading<bool> {
    value.one_of(&[("front", false), ("both", true)])
}

/// The units of a model's light sources.
pub(crate) fn light_units(value: &Value) -> Reading<LightUnits> {
    value.one_of(&[LightUnits::Photometric, LightUnits::Radiometric].map(|units| (units.name(), units)))
}
