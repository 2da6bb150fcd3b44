//! The shared arguments of commands that light a scene and have no camera.

use clap::Args;
use glam::Vec3;

use crate::scene::{LightOverrides, MomentOverrides, Overrides};

/// The lighting of a scene besides its own, and the seed.
#[derive(Args, Clone, Debug)]
pub(crate) struct LightArguments {
    #[command(flatten)]
    light: LightOverrides,

    /// Material variant of the model to use (glTF's KHR_materials_variants)
    #[arg(long, value_name = "NAME", help_heading = "Model")]
    variant: Option<String>,
    /// The moment of the model's animations.
    #[command(flatten)]
    moment: MomentOverrides,

    /// Seed of the random numbers [default: 0]
    #[arg(long, value_name = "N", help_heading = "Light", allow_hyphen_values = true)]
    pub(crate) seed: Option<u64>,
}

impl LightArguments {
    /// The overrides of a scene by these arguments, with an unused camera, as its lack needs no warning.
    pub(crate) fn overrides(&self) -> Overrides {
        Overrides {
            light: self.light.clone(),
            variant: self.variant.clone(),
            moment: self.moment.clone(),
            seed: self.seed,
            eye: Some(Vec3::ZERO),
            target: Some(Vec3::NEG_Z),
            up: Some(Vec3::Y),
            ..Overrides::default()
        }
    }
}
