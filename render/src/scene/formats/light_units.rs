//! The units of a glTF file's punctual lights.
//!
//! `KHR_lights_punctual` is photometric: candela and lux. Blender's exporter multiplies watts by 683 lm/W for it by
//! default ("Standard"), but not the emission of surfaces; so in such a file lights are 683 times too bright relative
//! to emitters. Its modes "Unitless" and "Raw" do not multiply, and the file does not store the mode. In files of other
//! programs lights and emission have the same units, and numbers are used unchanged.

use glam::Vec3;

use crate::scene::{LightUnits, PunctualLight, Scene};

/// Luminous efficacy by which Blender's exporter multiplies.
pub(crate) const LUMENS_PER_WATT: f32 = 683.0;

/// Lights of a file by Blender that are brighter are lumens: they would be 1200 W otherwise, weaker ones 2 W.
const MIN_PHOTOMETRIC_CANDELA: f32 = 93.0;

/// Likewise for its suns: 36 W/m² are much, and 36 lx little.
const MIN_PHOTOMETRIC_LUX: f32 = 36.0;

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

    /// What lights are that have been read with the numbers of the file.
    pub(super) fn guess(lights: &[PunctualLight], is_from_blender: bool) -> Self {
        let is_bright = |light: &PunctualLight| match light {
            PunctualLight::Point { intensity, .. } | PunctualLight::Spot { intensity, .. } => {
                intensity.max_element() > MIN_PHOTOMETRIC_CANDELA
            }
            // Blender writes none.
            PunctualLight::Profiled { .. } => false,
            PunctualLight::Directional { irradiance, .. } => irradiance.max_element() > MIN_PHOTOMETRIC_LUX,
        };
        if is_from_blender && lights.iter().any(is_bright) { Self::Photometric } else { Self::Radiometric }
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

    /// Blender's intensities for lamps of 5 to 1000 W, and suns of strength 0.1 to 20, in both modes.
    #[test]
    fn blender_s_modes_are_told_apart_for_usual_lights() {
        let tell = |light: PunctualLight| LightUnits::guess(&[light], true);
        for watts in [5.0_f32, 40.0, 1000.0] {
            let intensity = watts / (4.0 * std::f32::consts::PI);
            assert_eq!(tell(point(intensity)), LightUnits::Radiometric, "{watts} W");
            assert_eq!(tell(point(683.0 * intensity)), LightUnits::Photometric, "{watts} W");
        }
        for strength in [0.1, 1.0, 20.0] {
            assert_eq!(tell(sun(strength)), LightUnits::Radiometric, "{strength}");
            assert_eq!(tell(sun(683.0 * strength)), LightUnits::Photometric, "{strength}");
        }
        assert_eq!(LightUnits::guess(&[sun(1000.0)], false), LightUnits::Radiometric);
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
