//! The options of lights and skies.

use glam::Vec3;

use super::super::value;
use super::SkyOverrides;
use super::options::{Or, options};
use crate::scene::{LightTable, LightUnits, PunctualLight, Scene};
use crate::settings::Invalid;

options! {
    /// Options that are set here; the others are `None` and leave what the model says.
    #[command(next_help_heading = "Light")]
    pub struct LightOverrides;
    options {
        /// Constant radiance of the sky in W/(m² sr), linear sRGB [default: 0]
        #[arg(value_name = "R[,G,B]", allow_hyphen_values = true)]
        sky: Vec3 = value::radiance, in "sky" "radiance";
        /// Sides from which all emitters emit: front or both [default: from each material]
        ///
        /// The front is where corners are counter-clockwise, or where vertex normals point. Many models have unreliable
        /// winding: if a lamp lights the wrong side, use both.
        #[arg(id = "emission", value_name = "SIDES")]
        emits_both_sides: bool = value::emission, in "scene" "emission";
        /// Units of the model's lights: photometric (candela and lux, divided by 683 lm/W) or radiometric (W/sr and
        /// W/m²) [default: photometric for strong lights in files by Blender, else radiometric]
        #[arg(value_name = "UNITS")]
        light_units: LightUnits = value::light_units, in "scene" "lights";
        /// Radius of the model's point and spot lights, in its units, for soft shadows: Blender has 0.1 and does not
        /// write it [default: the light's extras.radius, or 0]
        #[arg(value_name = "R", allow_hyphen_values = true)]
        light_radius: f32 = value::light_radius, in "scene";
        /// Angle that the disc of the model's directional lights subtends, in degrees: the sun's is 0.53 [default: the
        /// light's extras.angle, or 0]
        #[arg(value_name = "DEGREES", allow_hyphen_values = true)]
        sun_angle: f32 = value::sun_angle, in "scene";
    }
    others {
        /// The sky's picture, or daylight.
        #[command(flatten)]
        sky_light: SkyOverrides;
        /// Lights besides the model's, which the options above leave as they are.
        #[arg(skip)]
        added: Vec<LightTable>;
    }
}

impl Or for Vec<LightTable> {
    /// These lights, or if there are none the others.
    fn or(self, others: Self) -> Self {
        if self.is_empty() { others } else { self }
    }
}

impl LightOverrides {
    /// These options, and those of `fallback` where these are not set.
    pub(super) fn or(self, fallback: Self) -> Self {
        self.or_each(fallback)
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
