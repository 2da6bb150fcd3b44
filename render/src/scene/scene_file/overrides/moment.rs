//! The options of animations: frame, shutter.

use super::super::value;
use super::options::options;
use crate::scene::{Moment, Scene, Shutter};

/// Blender's default.
const DEFAULT_FPS: f64 = 24.0;

options! {
    /// Options that are set here; the others are `None`.
    #[command(next_help_heading = "Model")]
    pub struct MomentOverrides;
    options {
        /// Frame of the model's animations to show, also between two frames, for example 12.5: frame F is F / fps
        /// seconds after the file's time 0, as Blender counts [default: no animation, the pose of the model's nodes]
        #[arg(value_name = "F", allow_hyphen_values = true)]
        frame: f64 = value::frame, in "scene";
        /// Frames per second [default: 24]
        #[arg(value_name = "N", allow_hyphen_values = true)]
        fps: f64 = value::fps, in "scene";
        /// Motion blur: opening and closing of the shutter in frames relative to --frame, such as -0.25,0.25 or 0,1, or
        /// in seconds, such as 0s,0.01s; or the number of frames that it is open around --frame, such as 0.5, Blender's
        /// default [default: no motion blur]
        #[arg(value_name = "OPEN,CLOSE", allow_hyphen_values = true)]
        #[arg(help_heading = "Camera")]
        shutter: Shutter = value::shutter, in "camera";
        /// Part of that time during which the shutter opens, and again closes, linearly, from 0 to 0.5 [default: 0, at
        /// once]
        #[arg(value_name = "PART", allow_hyphen_values = true)]
        #[arg(help_heading = "Camera")]
        shutter_ramp: f32 = value::shutter_ramp, in "camera";
        /// Number of times from opening to closing at which the model is posed, odd; motion in between is linear
        /// [default: 5]
        #[arg(value_name = "N", allow_hyphen_values = true)]
        #[arg(help_heading = "Camera")]
        shutter_keys: usize = value::shutter_keys, in "camera";
    }
    others {
        /// Animation to play, can be given several times [default: all, except those that animate the same property as
        /// an earlier one]
        #[arg(long = "animation", value_name = "NAME")]
        animations: Option<Vec<String>>, in "scene" "animation";
    }
}

impl MomentOverrides {
    /// These options, and those of `fallback` where these are not set.
    pub(crate) fn or(self, fallback: Self) -> Self {
        self.or_each(fallback)
    }

    /// The moment, if a frame is set: with a shutter the middle of the time that it is open.
    pub fn moment(&self) -> Option<Moment> {
        match self.shutter_moments() {
            Some(moments) => moments.get(moments.len() / 2).cloned(),
            None => Some(self.at(0.0)?),
        }
    }

    /// The moments of all keys from the shutter's opening to its closing, if both a frame and a shutter are set.
    pub fn shutter_moments(&self) -> Option<Vec<Moment>> {
        let keys = self.shutter_keys.unwrap_or(Shutter::DEFAULT_KEYS);
        self.shutter?.times(keys, self.fps.unwrap_or(DEFAULT_FPS)).map(|after| self.at(after)).collect()
    }

    /// So many seconds after the frame, if one is set.
    fn at(&self, after: f64) -> Option<Moment> {
        let time = self.frame? / self.fps.unwrap_or(DEFAULT_FPS) + after;
        Some(Moment { time, animations: self.animations.clone().unwrap_or_default() })
    }

    /// Warns of options that change nothing.
    pub(super) fn warn(&self, scene: &mut Scene) {
        if self.frame.is_some() && scene.animations.is_empty() {
            scene.warnings.push("the scene has no animations, so all its frames are the same".to_owned());
        }
        let idle = [
            ("fps", self.fps.is_some()),
            ("animation", self.animations.is_some()),
            ("shutter", self.shutter.is_some()),
        ];
        for (name, _) in idle.iter().filter(|(_, is_set)| *is_set && self.frame.is_none()) {
            scene.warnings.push(format!("the option {name} changes nothing without a frame"));
        }
        let idle = [("shutter-ramp", self.shutter_ramp.is_some()), ("shutter-keys", self.shutter_keys.is_some())];
        for (name, _) in idle.iter().filter(|(_, is_set)| *is_set && self.shutter.is_none()) {
            scene.warnings.push(format!("the option {name} changes nothing without a shutter"));
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
        let file = MomentOverrides {
            frame: Some(7.0),
            fps: Some(30.0),
            animations: Some(vec!["Walk".into()]),
            ..MomentOverrides::default()
        };
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

        let shutter = Some(Shutter { open: 0.0, close: 1.0, in_seconds: false });
        let blurred =
            MomentOverrides { frame: Some(24.0), shutter, shutter_keys: Some(3), ..MomentOverrides::default() };
        let times = blurred.shutter_moments().unwrap().into_iter().map(|moment| moment.time);
        let expected = [1.0, 1.0 + 0.5 / 24.0, 1.0 + 1.0 / 24.0];
        assert!(times.zip(expected).all(|(time, expected)| (time - expected).abs() < 1e-12));
        assert_eq!(blurred.moment(), blurred.shutter_moments().map(|moments| moments[1].clone()));
        assert_eq!(MomentOverrides { shutter, ..MomentOverrides::default() }.shutter_moments(), None);
    }
}
