//! The options that say which moment of a model's animations is shown.

use clap::Args;

use super::super::value::{self, argument};
use super::super::{Moment, Scene};

/// Blender's default.
const DEFAULT_FPS: f64 = 24.0;

/// Options that are set here; the others are `None`.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Model")]
pub struct MomentOverrides {
    /// Frame of the model's animations to show, also between two frames, for example 12.5: frame F is F / fps seconds after
    /// the file's time 0, as Blender counts [default: no animation, the pose of the model's nodes]
    #[arg(long, value_name = "F", value_parser = argument(value::frame), allow_negative_numbers = true)]
    pub frame: Option<f64>,
    /// Frames per second [default: 24]
    #[arg(long, value_name = "N", value_parser = argument(value::fps), allow_negative_numbers = true)]
    pub fps: Option<f64>,
    /// Animation to play, can be given several times [default: all, but for those that move what an earlier one moves]
    #[arg(long = "animation", value_name = "NAME")]
    pub animations: Option<Vec<String>>,
}

impl MomentOverrides {
    /// These options, and those of `fallback` where these are not set.
    pub(crate) fn or(self, fallback: Self) -> Self {
        Self {
            frame: self.frame.or(fallback.frame),
            fps: self.fps.or(fallback.fps),
            animations: self.animations.or(fallback.animations),
        }
    }

    /// The moment, if a frame is set.
    pub fn moment(&self) -> Option<Moment> {
        let time = self.frame? / self.fps.unwrap_or(DEFAULT_FPS);
        Some(Moment { time, animations: self.animations.clone().unwrap_or_default() })
    }

    /// Warns of options that change nothing.
    pub(super) fn warn(&self, scene: &mut Scene) {
        if self.frame.is_some() && scene.animations.is_empty() {
            scene.warnings.push("the scene has no animations, so all its frames are the same".to_owned());
        }
        let idle = [("fps", self.fps.is_some()), ("animation", self.animations.is_some())];
        for (name, _) in idle.iter().filter(|(_, is_set)| *is_set && self.frame.is_none()) {
            scene.warnings.push(format!("the option {name} changes nothing without a frame"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Animation;

    #[test]
    fn frames_count_from_the_time_0() {
        let set = MomentOverrides { frame: Some(12.0), ..MomentOverrides::default() };
        assert_eq!(set.moment().unwrap().time, 0.5);
        let file = MomentOverrides { frame: Some(7.0), fps: Some(30.0), animations: Some(vec!["Walk".into()]) };
        let both = set.clone().or(file);
        assert_eq!(both.moment(), Some(Moment { time: 0.4, animations: vec!["Walk".to_owned()] }));
        let mut scene = Scene::default();
        scene.animations.push(Animation { name: "Walk".to_owned(), begin: 0.0, end: 1.0 });
        both.warn(&mut scene);
        assert!(scene.warnings.is_empty());
        MomentOverrides { frame: None, ..both.clone() }.warn(&mut scene);
        let idle = ["fps", "animation"].map(|name| format!("the option {name} changes nothing without a frame"));
        assert_eq!(scene.warnings, idle);
        let mut still = Scene::default();
        both.warn(&mut still);
        assert_eq!(still.warnings, ["the scene has no animations, so all its frames are the same"]);
        assert_eq!(MomentOverrides { fps: Some(30.0), ..MomentOverrides::default() }.moment(), None);
    }
}
