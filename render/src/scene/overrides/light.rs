//! The options of what lights a scene.

use clap::Args;
use glam::Vec3;

use super::super::value::{self, argument};
use super::super::{LightTable, LightUnits, PunctualLight, Scene};
use super::SkyOverrides;
use crate::settings::Invalid;

/// Options that are set here; the others are `None` and leave what the model says.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Light")]
pub struct LightOverrides {
    /// Constant radiance of the sky in W/(m² sr), linear sRGB [default: 0]
    #[arg(long, value_name = "R[,G,B]", allow_hyphen_values = true, value_parser = argument(value::radiance))]
    pub sky: Option<Vec3>,
    /// The sky's picture, or daylight.
    #[command(flatten)]
    pub sky_light: SkyOverrides,
    /// Sides from which all emitters emit: front or both [default: from each material]
    ///
    /// The front is where corners are counter-clockwise, or where vertex normals point. Many models do not care: if a
    /// lamp lights the wrong way, try both.
    #[arg(long = "emission", value_name = "SIDES", value_parser = argument(value::emission))]
    pub emits_both_sides: Option<bool>,
    /// Units of the model's lights: photometric (candela and lux, divided by 683 lm/W) or radiometric (W/sr and W/m²)
    /// [default: photometric for strong lights in files by Blender, else radiometric]
    #[arg(long, value_name = "UNITS", value_parser = argument(value::light_units))]
    pub light_units: Option<LightUnits>,
    /// Radius of the model's point and spot lights, in its units, for soft shadows: Blender has 0.1 and does not write
    /// it [default: the light's extras.radius, or 0]
    #[arg(long, value_name = "R", value_parser = argument(value::light_radius), allow_negative_numbers = true)]
    pub light_radius: Option<f32>,
    /// Angle that the disc of the model's directional lights subtends, in degrees: the sun's is 0.53 [default: the
    /// light's extras.angle, or 0]
    #[arg(long, value_name = "DEGREES", value_parser = argument(value::sun_angle), allow_negative_numbers = true)]
    pub sun_angle: Option<f32>,
    /// Lights besides the model's, which the options above leave as they are.
    #[arg(skip)]
    pub added: Vec<LightTable>,
}

impl LightOverrides {
    /// These options, and those of `fallback` where these are not set.
    pub(super) fn or(self, fallback: Self) -> Self {
        Self {
            sky: self.sky.or(fallback.sky),
            sky_light: self.sky_light.or(fallback.sky_light),
            emits_both_sides: self.emits_both_sides.or(fallback.emits_both_sides),
            light_units: self.light_units.or(fallback.light_units),
            light_radius: self.light_radius.or(fallback.light_radius),
            sun_angle: self.sun_angle.or(fallback.sun_angle),
            added: if self.added.is_empty() { fallback.added } else { self.added },
        }
    }

    /// Changes the lights of `scene`. Daylight has the sun's own angle.
    pub(super) fn apply(&self, scene: &mut Scene) -> Result<(), Invalid> {
        if let Some(units) = self.light_units {
            scene.set_light_units(units);
        }
        for light in &mut scene.lights {
            match light {
                PunctualLight::Point { radius, .. }
                | PunctualLight::Spot { radius, .. }
                | PunctualLight::Profiled { radius, .. } => {
                    *radius = self.light_radius.unwrap_or(*radius);
                }
                PunctualLight::Directional { half_angle, .. } => {
                    *half_angle = self.sun_angle.map_or(*half_angle, |degrees| 0.5 * degrees.to_radians());
                }
            }
        }
        if let Some(radiance) = self.sky {
            scene.sky.radiance = radiance;
        }
        if let Some(both) = self.emits_both_sides {
            scene.materials.iter_mut().for_each(|material| material.emits_both_sides = both);
        }
        self.added.iter().for_each(|light| light.add_to(scene));
        self.sky_light.apply(scene)
    }

    /// Whether any option of the sky's picture is set.
    pub(super) fn sets_sky_light(&self) -> bool {
        self.sky_light.sets_any()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_get_their_size() {
        let direction = Vec3::NEG_Y;
        let mut scene = Scene {
            lights: vec![
                PunctualLight::Point { position: Vec3::ZERO, intensity: Vec3::ONE, radius: 0.5 },
                PunctualLight::Directional { direction, irradiance: Vec3::ONE, half_angle: 0.25 },
            ],
            ..Scene::default()
        };
        let before = scene.lights.clone();
        LightOverrides::default().apply(&mut scene).unwrap();
        assert_eq!(scene.lights, before);
        let options = LightOverrides { light_radius: Some(0.1), sun_angle: Some(90.0), ..Default::default() };
        options.apply(&mut scene).unwrap();
        assert!(matches!(scene.lights[0], PunctualLight::Point { radius: 0.1, .. }));
        let PunctualLight::Directional { half_angle, .. } = scene.lights[1] else { panic!("a sun") };
        assert_eq!(half_angle, std::f32::consts::FRAC_PI_4);
    }
}
