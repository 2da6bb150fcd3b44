//! The options of the sky.

use std::path::PathBuf;

use glam::Vec3;

use super::super::value;
use super::options::options;
use crate::film::MAX_SAMPLE;
use crate::scene::{Daylight, DaylightModel, Scene, SkyPicture, count};
use crate::settings::Invalid;

options! {
    /// Options that are set here; the others are `None` and leave the defaults.
    #[command(next_help_heading = "Light")]
    pub struct SkyOverrides;
    options {
        /// Rotation of the environment map about +y in degrees, counter-clockwise as seen from above; at 0 its middle
        /// is towards -z [default: 0]
        #[arg(id = "sky-rotation", value_name = "DEGREES")]
        #[arg(allow_hyphen_values = true)]
        rotation: f32 = value::degrees, in "sky";
        /// Factor on the environment map or the daylight [default: 1]
        #[arg(id = "sky-scale", value_name = "S", allow_hyphen_values = true)]
        scale: f32 = value::scale, in "sky";
        /// Clear sky with a sun (Preetham 1999): elevation and azimuth of the sun in degrees (azimuth 0 is -z, 90 is
        /// +x), and turbidity from 2 (very clear) to 10 (hazy) [default turbidity: 3]
        #[arg(value_name = "ELEVATION,AZIMUTH[,T]")]
        daylight: Daylight = value::daylight, in "sky";
        /// Model of the daylight's sky: preetham, or hosek (Hosek and Wilkie 2012), which is better for a low sun and
        /// much haze [default: preetham]
        #[arg(value_name = "NAME")]
        daylight_model: DaylightModel = value::daylight_model, in "sky";
        /// Albedo of the ground below the sky of hosek, which lights it [default: 0.3]
        #[arg(value_name = "R[,G,B]", allow_hyphen_values = true)]
        daylight_albedo: Vec3 = value::albedo, in "sky";
    }
    others {
        /// Environment map, equirectangular, .hdr or .exr; added to --sky
        #[arg(long = "sky-picture", value_name = "FILE")]
        picture: Option<PathBuf>, in "sky";
    }
}

/// The albedo of the ground: about that of grass and soil.
const GROUND: Vec3 = Vec3::splat(0.3);

impl SkyOverrides {
    /// These options, and those of `fallback` where these are not set. A picture or a daylight here replaces either.
    pub(super) fn or(self, mut fallback: Self) -> Self {
        if self.picture.is_some() || self.daylight.is_some() {
            fallback = Self::default();
        }
        self.or_each(fallback)
    }

    /// Gives `scene` the sky, and the sun.
    pub(super) fn apply(&self, scene: &mut Scene) -> Result<(), Invalid> {
        let scale = self.scale.unwrap_or(1.0);
        let model = self.daylight_model.unwrap_or_default();
        if self.daylight.is_none() && (self.daylight_model.is_some() || self.daylight_albedo.is_some()) {
            let remedy = "give its sun with --daylight or daylight = [...] in [sky], or leave model and albedo out";
            return Err(Invalid::new("there is no daylight whose model or albedo could be set", remedy));
        }
        if model == DaylightModel::Preetham && self.daylight_albedo.is_some() {
            let remedy = "give --daylight-model hosek, or leave the albedo out";
            return Err(Invalid::new("Preetham's daylight has no albedo of the ground", remedy));
        }
        match (&self.picture, self.daylight) {
            (None, None) if self.rotation.is_some() || self.scale.is_some() => {
                return Err(Invalid::new(
                    "there is no environment map to rotate or scale",
                    "give one with --sky-picture or picture = \"...\" in [sky], or leave these options out",
                ));
            }
            (Some(_), Some(_)) => {
                return Err(Invalid::new("the sky is both an environment map and daylight", "leave one of them out"));
            }
            (None, Some(_)) if self.rotation.is_some() => {
                return Err(Invalid::new("daylight cannot be rotated", "give the sun another azimuth"));
            }
            (None, None) => {}
            (None, Some(daylight)) => {
                let (picture, sun) = daylight.light(scale, model, self.daylight_albedo.unwrap_or(GROUND));
                scene.sky.picture = Some(picture);
                scene.lights.push(sun);
            }
            (Some(path), None) => {
                let picture = SkyPicture::read(path, scale).map_err(|error| {
                    Invalid::new(format!("{}: {}", error.file.display(), error.problem), error.remedy)
                })?;
                if let Some((number, [x, y], radiance)) = picture.beyond_samples() {
                    let texels = count(number, "texel is", "texels are");
                    scene.warnings.push(format!(
                        "{}: {texels} brighter than {MAX_SAMPLE:.1e} W/(m² sr), to which samples of a picture are cut: \
                         texel {x}, {y} has {radiance:.1e}; scale it down (--sky-scale)",
                        path.display()
                    ));
                }
                scene.sky.picture = Some(picture.turned(self.rotation.unwrap_or(0.0)));
                scene.files.push(path.clone());
            }
        }
        Ok(())
    }

    /// Whether any of them is set.
    pub(super) fn sets_any(&self) -> bool {
        *self != Self::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{PunctualLight, cornell_box};

    #[test]
    fn daylight_is_a_sky_and_a_sun() {
        let mut scene = cornell_box();
        let daylight = Some(Daylight { elevation: 45.0, azimuth: 0.0, turbidity: 3.0 });
        SkyOverrides { daylight, scale: Some(0.5), ..Default::default() }.apply(&mut scene).unwrap();
        assert!(scene.sky.mean().min_element() > 0.0);
        let Some(PunctualLight::Directional { direction, .. }) = scene.lights.last() else { panic!("a sun") };
        assert!((direction.z - 0.5_f32.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn texels_that_no_sample_holds_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sun.hdr");
        let texels = [Vec3::ONE, Vec3::ONE, Vec3::splat(1e20), Vec3::ONE];
        let map = crate::output::Map { width: 2, height: 2, texels: &texels };
        std::fs::write(&path, crate::output::encode_hdr(&path, &map).unwrap().bytes).unwrap();
        let warnings = |scale: f32| {
            let mut scene = cornell_box();
            let sky = SkyOverrides { picture: Some(path.clone()), scale: Some(scale), ..Default::default() };
            sky.apply(&mut scene).unwrap();
            scene.warnings
        };
        let told = warnings(1.0).pop().unwrap();
        assert!(
            told.contains("sun.hdr: 1 texel is brighter than 1.1e12") && told.contains("texel 0, 1 has 1.0e20"),
            "{told}"
        );
        assert_eq!(warnings(1e-9), [""; 0]);
    }

    #[test]
    fn options_must_go_together() {
        let daylight = Some(Daylight { elevation: 45.0, azimuth: 0.0, turbidity: 3.0 });
        let problem = |options: SkyOverrides| options.apply(&mut cornell_box()).unwrap_err().problem;
        let turned = SkyOverrides { rotation: Some(1.0), ..Default::default() };
        assert_eq!(problem(turned.clone()), "there is no environment map to rotate or scale");
        assert_eq!(problem(SkyOverrides { daylight, ..turned.clone() }), "daylight cannot be rotated");
        let model = SkyOverrides { daylight_model: Some(DaylightModel::Hosek), ..Default::default() };
        assert_eq!(problem(model.clone()), "there is no daylight whose model or albedo could be set");
        let albedo = SkyOverrides { daylight, daylight_albedo: Some(Vec3::ONE), ..Default::default() };
        assert_eq!(problem(albedo.clone()), "Preetham's daylight has no albedo of the ground");
        SkyOverrides { daylight_model: model.daylight_model, ..albedo }.apply(&mut cornell_box()).unwrap();
        let picture = Some("no.hdr".into());
        let both = SkyOverrides { daylight, picture: picture.clone(), ..Default::default() };
        assert_eq!(problem(both), "the sky is both an environment map and daylight");
        let missing = SkyOverrides { picture: picture.clone(), ..turned.clone() };
        assert_eq!(problem(missing), "no.hdr: no such file");
        // The command line's daylight wins over the scene file's picture, with its rotation.
        let file = SkyOverrides { picture, ..turned };
        let line = SkyOverrides { daylight, ..Default::default() };
        assert_eq!(line.clone().or(file), line);
    }
}
