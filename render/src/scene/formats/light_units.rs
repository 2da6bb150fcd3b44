//! The units of a glTF file's punctual lights.
//!
//! `KHR_lights_punctual` is photometric: candela and lux. Blender's exporter multiplies watts by 683 lm/W for it by
//! default ("Standard"), but not the emission of surfaces; so in such a file lights are 683 times too bright relative
//! to emitters. Its mode "Unitless" does not multiply, and the file does not store the mode. In files of other
//! programs lights and emission have the same units, and numbers are used unchanged.
//!
//! The mode is inferred from the numbers. People type powers of few digits: 1500 W are 119.366 W/sr, which by
//! "Standard" would have been 2.196193 W. So the mode by which the powers have fewer digits is it. Where that does not
//! decide (powers set with the mouse), brightness does.

use std::cmp::Ordering;
use std::f64::consts::PI;

use glam::Vec3;

use crate::scene::{LightUnits, PunctualLight, Scene};

/// Luminous efficacy by which Blender's exporter multiplies.
pub(crate) const LUMENS_PER_WATT: f32 = 683.0;

/// Lights of a file by Blender that are brighter are lumens: they would be 3100 W otherwise, weaker ones 4.6 W.
const MIN_PHOTOMETRIC_CANDELA: f32 = 250.0;

/// Likewise for its suns: 36 W/m² are much, and 36 lx little.
const MIN_PHOTOMETRIC_LUX: f32 = 36.0;

/// How strong a light is by the numbers of a file, without its colour.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Strength {
    /// Of points and spots, in candela or W/sr.
    Intensity(f32),
    /// Of suns, in lux or W/m².
    Irradiance(f32),
}

impl Strength {
    /// What Blender shows for a light: watts into all directions, or W/m².
    fn blender_power(self, units: LightUnits) -> f64 {
        let power = match self {
            Self::Intensity(intensity) => 4.0 * PI * f64::from(intensity),
            Self::Irradiance(irradiance) => f64::from(irradiance),
        };
        power * f64::from(units.factor())
    }

    fn is_bright(self) -> bool {
        match self {
            Self::Intensity(intensity) => intensity > MIN_PHOTOMETRIC_CANDELA,
            Self::Irradiance(irradiance) => irradiance > MIN_PHOTOMETRIC_LUX,
        }
    }
}

/// How many significant digits a positive number has, up to the rounding of `f32`; [`MANY`] if it has more than three.
fn digits(number: f64) -> u32 {
    if !(number.is_finite() && number > 0.0) {
        return MANY;
    }
    let exponent = number.log10().floor() as i32;
    let has = |count: &u32| {
        let whole = number * 10_f64.powi(*count as i32 - 1 - exponent);
        (whole - whole.round()).abs() < 3e-7 * whole
    };
    (1..MANY).find(has).unwrap_or(MANY)
}

/// See [`digits`]: one number in 4000 has three by chance, one in 400 would have four.
const MANY: u32 = 4;

impl LightUnits {
    /// The name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Photometric => "photometric",
            Self::Radiometric => "radiometric",
        }
    }

    /// The factor on a file's numbers.
    fn factor(self) -> f32 {
        match self {
            Self::Photometric => LUMENS_PER_WATT.recip(),
            Self::Radiometric => 1.0,
        }
    }

    /// The units of the lights of a file by Blender.
    pub(super) fn guess_of_blender(lights: &[Strength]) -> Self {
        let all_digits = |units| lights.iter().map(|light| digits(light.blender_power(units))).sum::<u32>();
        match all_digits(Self::Photometric).cmp(&all_digits(Self::Radiometric)) {
            Ordering::Less => Self::Photometric,
            Ordering::Greater => Self::Radiometric,
            Ordering::Equal if lights.iter().any(|light| light.is_bright()) => Self::Photometric,
            Ordering::Equal => Self::Radiometric,
        }
    }
}

impl Scene {
    /// Takes the numbers of the file's lights as these units.
    pub fn set_light_units(&mut self, units: LightUnits) {
        let factor = units.factor() / self.light_units.unwrap_or(LightUnits::Radiometric).factor();
        if factor != 1.0 {
            let scale = |light: &mut Vec3| *light *= factor;
            self.lights.iter_mut().for_each(|light| match light {
                PunctualLight::Point { intensity, .. }
                | PunctualLight::Spot { intensity, .. }
                | PunctualLight::Profiled { intensity, .. } => scale(intensity),
                PunctualLight::Directional { irradiance, .. } => scale(irradiance),
            });
        }
        self.light_units = Some(units);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(intensity: f32) -> PunctualLight {
        PunctualLight::Point { position: Vec3::ZERO, intensity: Vec3::splat(intensity), radius: 0.0 }
    }

    fn sun(irradiance: f32) -> PunctualLight {
        PunctualLight::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::splat(irradiance), half_angle: 0.0 }
    }

    const FACTORS: [(LightUnits, f64); 2] = [(LightUnits::Radiometric, 1.0), (LightUnits::Photometric, 683.0)];

    fn lamp(watts: f64, factor: f64) -> Strength {
        Strength::Intensity((factor * watts / (4.0 * PI)) as f32)
    }

    /// Powers as people type them: from a candle to a stage, and from moonlight to a sun of the tropics.
    #[test]
    fn powers_of_few_digits_tell_blender_s_modes_apart() {
        for (units, factor) in FACTORS {
            for watts in [0.1, 0.25, 1.0, 2.5, 40.0, 1000.0, 1500.0, 12_500.0, 1e6] {
                assert_eq!(LightUnits::guess_of_blender(&[lamp(watts, factor)]), units, "{watts} W");
            }
            for strength in [0.002, 0.1, 1.0, 3.25, 10.0, 137.0] {
                let sun = Strength::Irradiance((factor * strength) as f32);
                assert_eq!(LightUnits::guess_of_blender(&[sun]), units, "{strength} W/m²");
            }
        }
    }

    /// Powers set with the mouse: lamps of 5 to 3000 W. A few of them beside round ones do not matter.
    #[test]
    fn brightness_tells_them_apart_where_no_power_is_round() {
        for (units, factor) in FACTORS {
            let dragged = [5.123_456, 87.654_32, 2987.654].map(|watts| lamp(watts, factor));
            for light in dragged {
                assert_eq!(LightUnits::guess_of_blender(&[light]), units, "{light:?}");
            }
            let dim = [lamp(0.876_543, factor), lamp(2.0, factor), lamp(1.5, factor)];
            assert_eq!(LightUnits::guess_of_blender(&dim), units);
            let bright = [lamp(9876.543, factor), lamp(5000.0, factor)];
            assert_eq!(LightUnits::guess_of_blender(&bright), units);
        }
    }

    #[test]
    fn lights_that_are_off_tell_nothing() {
        assert_eq!(LightUnits::guess_of_blender(&[Strength::Intensity(0.0)]), LightUnits::Radiometric);
        assert_eq!(LightUnits::guess_of_blender(&[]), LightUnits::Radiometric);
    }

    #[test]
    fn units_may_be_set_again() {
        let mut scene = Scene { lights: vec![point(1366.0), sun(683.0)], ..Scene::default() };
        for _ in 0..2 {
            scene.set_light_units(LightUnits::Photometric);
            assert_eq!(scene.lights, [point(2.0), sun(1.0)]);
        }
        scene.set_light_units(LightUnits::Radiometric);
        assert_eq!(scene.lights, [point(1366.0), sun(683.0)]);
    }
}
