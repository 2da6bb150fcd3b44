//! Points and spots with a photometric profile.

use std::sync::Arc;

use glam::Vec3;

use super::fields::{Kind, Table};
use super::{LightTable, Source};
use crate::scene::error::SceneError;
use crate::scene::formats::ies;
use crate::scene::formats::light_units::LUMENS_PER_WATT;
use crate::scene::scene_file::toml_text::Entry;
use crate::scene::{ProfileFrame, PunctualLight};

impl<'a> Table<'a> {
    /// A light with the profile that `entry` names.
    pub(super) fn profiled(&self, entry: &Entry<'a>) -> Result<LightTable, SceneError> {
        let file = self.reader.file(entry)?;
        if !file.is_file() {
            let remedy = "name a photometric file (.ies), relative to the folder of this scene file";
            return Err(self.reader.error(
                entry.value_at.start,
                format!("there is no file {}", file.display()),
                remedy,
            ));
        }
        let bytes = std::fs::read(&file).map_err(|error| SceneError::unreadable(&file, &error))?;
        let profile = ies::parse(&file, &bytes)?;
        let is_aimed = self.kind == Kind::ProfiledSpot || self.get("direction").or(self.get("target")).is_some();
        let axis = if is_aimed { self.direction()? } else { Vec3::NEG_Y };
        let per_candela = match self.either("scale", "power")? {
            None => Vec3::splat(LUMENS_PER_WATT.recip()),
            Some(it) if it.name == "scale" => self.reader.color(it, 0.0, f32::MAX)? / LUMENS_PER_WATT,
            Some(power) if profile.lumens() > 0.0 => {
                (self.reader.color(power, 0.0, f32::MAX)?.as_dvec3() / profile.lumens()).as_vec3()
            }
            Some(power) => {
                let problem = "a profile without light has no power";
                return Err(self.reader.error(power.at.start, problem, "name another profile"));
            }
        };
        let intensity = self.color()? * per_candela;
        if !(intensity * profile.greatest()).is_finite() {
            return self.reader.wrong(entry, "a profile with less light, or a smaller scale");
        }
        let light = PunctualLight::Profiled {
            position: self.position()?,
            frame: ProfileFrame::new(axis, self.number("profile_rotation", f32::MIN, f32::MAX, 0.0)?),
            intensity,
            radius: self.number("radius", 0.0, PunctualLight::MAX_RADIUS, 0.0)?,
            profile: Arc::new(profile),
        };
        Ok(self.finish(Source::Punctual(light), Some(file)))
    }
}
