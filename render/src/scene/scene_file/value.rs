//! Values of scene files and command lines, with the types and ranges that options require.
//!
//! Both sources are read by the same functions, so that they accept the same values and give the same errors.

mod film;
mod integrating;
mod optical;
mod shutter;

use glam::{Vec2, Vec3};
use halfdome_kernel::Quality;
use halfdome_kernel::sampling::Pattern;

use crate::scene::nearest::nearest;
use crate::scene::{Daylight, DaylightModel, LightUnits, Sharing};
use crate::settings::MAX_SIDE;
use crate::settings::{Filter, PathOptions};

pub use film::MatteKinds;
pub(super) use film::{matte_kinds, matte_levels};
pub(crate) use integrating::accuracy;
pub(super) use integrating::*;
pub(super) use optical::*;
pub(super) use shutter::{shutter, shutter_keys, shutter_ramp};

/// A value whose meaning is not known yet.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Integer(i128),
    Number(f64),
    Boolean(bool),
    Text(String),
    List(Vec<Value>),
    /// A kind that no option takes.
    Other,
}

/// The remedy for a wrong value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected {0}")]
pub(crate) struct Expected(pub(crate) String);

type Reading<T> = Result<T, Expected>;

impl Value {
    /// The value of a command-line argument: a list if it has commas, else a number if it reads as one.
    fn from_argument(text: &str) -> Self {
        if text.contains(',') {
            return Self::List(text.split(',').map(Self::from_argument).collect());
        }
        let text = text.trim();
        let integer = text.parse().map(Self::Integer).ok();
        let number = || text.parse().map(Self::Number).ok();
        let boolean = || text.parse().map(Self::Boolean).ok();
        integer.or_else(number).or_else(boolean).unwrap_or_else(|| Self::Text(text.to_owned()))
    }

    /// The number, unless it is NaN or out of a 32-bit float's range.
    pub(crate) fn finite(&self) -> Option<f32> {
        let number = match self {
            Self::Integer(value) => *value as f32,
            Self::Number(value) => *value as f32,
            _ => return None,
        };
        number.is_finite().then_some(number)
    }

    /// The number in double precision.
    fn double(&self) -> Option<f64> {
        match self {
            Self::Integer(value) => Some(*value as f64),
            Self::Number(value) => Some(*value),
            _ => None,
        }
    }

    pub(super) fn three(&self) -> Option<Vec3> {
        let Self::List(values) = self else { return None };
        let [x, y, z] = values.as_slice() else { return None };
        Some(Vec3::new(x.finite()?, y.finite()?, z.finite()?))
    }

    /// Two numbers.
    fn two(&self) -> Option<Vec2> {
        let Self::List(values) = self else { return None };
        let [x, y] = values.as_slice() else { return None };
        Some(Vec2::new(x.finite()?, y.finite()?))
    }

    fn integer<T: TryFrom<i128>>(&self) -> Option<T> {
        let Self::Integer(value) = self else { return None };
        T::try_from(*value).ok()
    }

    /// What `named` makes of one of the names.
    fn named<T>(&self, names: &[&str], named: fn(&str) -> Option<T>) -> Reading<T> {
        let known: Vec<_> = names.iter().map(|&name| (name, name)).collect();
        self.one_of(&known).map(|name| named(name).expect("every listed name has a value"))
    }

    pub(super) fn one_of<T: Copy>(&self, known: &[(&str, T)]) -> Reading<T> {
        let Self::Text(text) = self else { return expected(list(known)) };
        let found = known.iter().find(|(name, _)| name == text);
        found.map_or_else(|| expected(meant(text, known)), |&(_, value)| Ok(value))
    }
}

/// Reads command-line arguments with `read`.
pub(crate) fn argument<T>(read: fn(&Value) -> Reading<T>) -> impl Fn(&str) -> Reading<T> + Clone {
    move |text| {
        // A name may look like a number or a list.
        let as_text = |error| read(&Value::Text(text.to_owned())).map_err(|_| error);
        read(&Value::from_argument(text)).or_else(as_text)
    }
}

fn expected<T>(what: impl Into<String>) -> Reading<T> {
    Err(Expected(what.into()))
}

fn list<T>(known: &[(&str, T)]) -> String {
    let names: Vec<_> = known.iter().map(|(name, _)| *name).collect();
    format!("one of {}", names.join(", "))
}

fn meant<T>(text: &str, known: &[(&str, T)]) -> String {
    let names: Vec<_> = known.iter().map(|(name, _)| *name).collect();
    match nearest(text, &names) {
        Some(near) => format!("{}; did you mean `{near}`?", list(known)),
        None => list(known),
    }
}

/// Any text.
pub(super) fn text(value: &Value) -> Reading<String> {
    match value {
        Value::Text(text) => Ok(text.clone()),
        _ => expected("text"),
    }
}

/// A point in space.
pub(crate) fn point(value: &Value) -> Reading<Vec3> {
    value.three().map_or_else(|| expected("three finite numbers x, y, z"), Ok)
}

/// A vector that has a direction.
pub(super) fn direction(value: &Value) -> Reading<Vec3> {
    match value.three() {
        Some(v) if v != Vec3::ZERO => Ok(v),
        _ => expected("three finite numbers x, y, z that are not all zero"),
    }
}

/// A field of view in degrees.
pub(super) fn vfov(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(degrees) if degrees > 0.0 && degrees < 180.0 => Ok(degrees),
        _ => expected("degrees, more than 0 and less than 180"),
    }
}

/// Radiance: one number for all channels, or three.
pub(crate) fn radiance(value: &Value) -> Reading<Vec3> {
    match value.finite().map(Vec3::splat).or_else(|| value.three()) {
        Some(radiance) if radiance.min_element() >= 0.0 => Ok(radiance),
        _ => expected("one number, or three for red, green and blue, finite and not negative"),
    }
}

/// An angle.
pub(crate) fn degrees(value: &Value) -> Reading<f32> {
    value.finite().map_or_else(|| expected("a finite number of degrees"), Ok)
}

/// A factor of light.
pub(crate) fn scale(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(scale) if scale >= 0.0 => Ok(scale),
        _ => expected("a number, finite and not negative"),
    }
}

/// The greatest radiance of a sample.
pub(crate) fn clamp(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(most) if most > 0.0 => Ok(most),
        _ => expected("a number, finite and more than 0"),
    }
}

/// Whether paths are guided, or by how many others; 0 for none.
pub(crate) fn guide(value: &Value) -> Reading<u32> {
    match (value, value.integer()) {
        (Value::Boolean(true), _) => Ok(PathOptions::GUIDE_PATHS),
        (Value::Boolean(false), _) => Ok(0),
        (_, Some(paths @ PathOptions::MIN_GUIDE_PATHS..=PathOptions::MAX_GUIDE_PATHS)) => Ok(paths),
        _ => {
            let (least, most) = (PathOptions::MIN_GUIDE_PATHS, PathOptions::MAX_GUIDE_PATHS);
            expected(format!("true, false, or a number of paths from {least} to {most}"))
        }
    }
}

/// The radius of lights; 0 makes them delta lights.
pub(crate) fn light_radius(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(radius) if (0.0..=1e15).contains(&radius) => Ok(radius),
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

/// The width or height of a picture.
pub(super) fn side(value: &Value) -> Reading<u32> {
    match value.integer() {
        Some(pixels @ 1..=MAX_SIDE) => Ok(pixels),
        _ => expected(format!("a whole number of pixels from 1 to {MAX_SIDE}")),
    }
}

/// Something of which there is at least one.
pub(super) fn count(value: &Value) -> Reading<u32> {
    match value.integer() {
        Some(count @ 1..) => Ok(count),
        _ => expected(format!("a whole number from 1 to {}", u32::MAX)),
    }
}

/// Something of which there may be none.
pub(super) fn number(value: &Value) -> Reading<u32> {
    value.integer().map_or_else(|| expected(format!("a whole number from 0 to {}", u32::MAX)), Ok)
}

/// A seed.
pub(super) fn seed(value: &Value) -> Reading<u64> {
    value.integer().map_or_else(|| expected(format!("a whole number from 0 to {}", u64::MAX)), Ok)
}

/// A frame of an animation, also between two.
pub(super) fn frame(value: &Value) -> Reading<f64> {
    match value.double() {
        Some(frame) if frame.abs() <= 1e6 => Ok(frame),
        _ => expected("a number of a frame from -1000000 to 1000000, for example 12 or 12.5"),
    }
}

/// Frames per second.
pub(super) fn fps(value: &Value) -> Reading<f64> {
    match value.double() {
        Some(fps) if fps > 0.0 && fps <= 1e6 => Ok(fps),
        _ => expected("frames per second, more than 0 and at most 1000000"),
    }
}

/// A name, or several.
pub(super) fn names(value: &Value) -> Reading<Vec<String>> {
    match value {
        Value::List(values) if !values.is_empty() => values.iter().map(text).collect(),
        value => text(value).map(|name| vec![name]),
    }
}

/// A pixel filter's name.
pub(super) fn filter(value: &Value) -> Reading<String> {
    value.one_of(&Filter::NAMES.map(|name| (name, name))).map(str::to_owned)
}

/// A filter's full width in pixels.
pub(super) fn filter_width(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(width) if width > 0.0 && width <= Filter::MAX_WIDTH => Ok(width),
        _ => expected(format!("a number of pixels, more than 0 and at most {}", Filter::MAX_WIDTH)),
    }
}

/// A filter's sharpness.
pub(super) fn sharpness(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(sharpness @ 0.0..=1.0) => Ok(sharpness),
        _ => expected("a number from 0 (soft) to 1 (sharp)"),
    }
}

/// Whether something is wanted.
pub(super) fn flag(value: &Value) -> Reading<bool> {
    match value {
        Value::Boolean(flag) => Ok(*flag),
        _ => expected("true or false"),
    }
}

/// The sampler of random numbers.
pub(super) fn sampler(value: &Value) -> Reading<Pattern> {
    value.one_of(&[("random", Pattern::Random), ("sobol", Pattern::Sobol), ("r2", Pattern::R2)])
}

/// The quality of a tree.
pub(crate) fn quality(value: &Value) -> Reading<Quality> {
    value.one_of(&Quality::ALL.map(|quality| (quality.name(), quality)))
}

/// Whether both sides emit.
pub(crate) fn emission(value: &Value) -> Reading<bool> {
    value.one_of(&[("front", false), ("both", true)])
}

/// Whether what is shown several times is kept once.
pub(crate) fn sharing(value: &Value) -> Reading<Sharing> {
    value.one_of(&[("auto", Sharing::Auto), ("always", Sharing::Always), ("never", Sharing::Never)])
}

/// The units of a model's light sources.
pub(crate) fn light_units(value: &Value) -> Reading<LightUnits> {
    value.one_of(&[LightUnits::Photometric, LightUnits::Radiometric].map(|units| (units.name(), units)))
}

#[cfg(test)]
mod tests;
