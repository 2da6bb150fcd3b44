//! The arguments that all commands share which light a scene and have no camera.

use clap::Args;
use glam::Vec3;

use crate::scene::{LightUnits, Overrides, SkyOverrides, value};

/// What lights a scene, besides what is in it, and by which random numbers its light is found.
#[derive(Args, Clone, Debug)]
pub(super) struct LightArguments {
    /// Constant radiance of the sky in W/(m² sr), linear sRGB [default: 0]
    #[arg(long, value_name = "R[,G,B]", allow_hyphen_values = true, help_heading = "Light")]
    #[arg(value_parser = value::argument(value::radiance))]
    sky: Option<Vec3>,

    #[command(flatten)]
    sky_light: SkyOverrides,

    /// Sides from which all emitters emit: front or both [default: from each material]
    #[arg(long = "emission", value_name = "SIDES", help_heading = "Light")]
    #[arg(value_parser = value::argument(value::emission))]
    emits_both_sides: Option<bool>,

    /// Units of the model's lights: photometric (candela and lux, divided by 683 lm/W) or radiometric (W/sr and W/m²)
    /// [default: photometric for strong lights in files by Blender, else radiometric]
    #[arg(long, value_name = "UNITS", help_heading = "Light", value_parser = value::argument(value::light_units))]
    light_units: Option<LightUnits>,

    /// Material variant of the model to use (glTF's KHR_materials_variants)
    #[arg(long, value_name = "NAME", help_heading = "Model")]
    variant: Option<String>,

    /// Seed of the random numbers [default: 0]
    #[arg(long, value_name = "N", help_heading = "Light")]
    pub(super) seed: Option<u64>,
}

impl LightArguments {
    /// What these arguments say of a scene, with a camera that is not used, as the lack of one needs no warning.
    pub(super) fn overrides(&self) -> Overrides {
        Overrides {
            sky: self.sky,
            sky_light: self.sky_light.clone(),
            emits_both_sides: self.emits_both_sides,
            light_units: self.light_units,
            variant: self.variant.clone(),
            seed: self.seed,
            eye: Some(Vec3::ZERO),
            target: Some(Vec3::NEG_Z),
            up: Some(Vec3::Y),
            ..Overrides::default()
        }
    }
}
