//! `[[light]]` in scene files: lights and lamps added to the model.
//!
//! ```toml
//! [[light]]
//! type = "spot"                  # point, spot, directional (or sun), sphere, disc, rectangle
//! name = "desk"                  # for messages and light path expressions, and of a lamp's mesh and material
//! group = "key"                  # its light group; by default its name
//! position = [0, 2.5, 0]
//! target = [0, 0, 1]             # or direction = [0, -1, 0]
//! power = 40                     # W; or intensity, W/sr
//! color = [1, 0.8, 0.6]          # multiplies it
//! cone = 60                      # the whole angle, degrees, with a blend from 0 to 1: as in Blender
//! blend = 0.15
//! # inner = 20, outer = 30       # instead of them: half angles, degrees, as in glTF
//! radius = 0.05                  # for soft shadows
//! ```
//!
//! A point or spot with `profile = "lamp.ies"` uses the measured distribution: a candela is `scale` / 683 W/sr, or
//! `power` sets the total power. It points along `direction` or at `target`, and `profile_rotation` turns it about
//! that.
//!
//! A point light has `position`, `intensity` or `power`, and `radius`. A directional one has `direction`, `irradiance`
//! (W/m² on what faces it), and `angle` (degrees that its disc subtends). The others are visible lamps, with `radiance`
//! (W/(m² sr)) or `power` (π × radiance × area of all sides): a `sphere` with `position` and `radius`, a `disc` with
//! these and `direction` or `target`, a `rectangle` with `size = [width, height]` and `up` in place of the radius; the
//! last two may be `two_sided`.

mod fields;
mod profiled;

use std::path::{Path, PathBuf};

use glam::Vec3;
use halfdome_kernel::MAX_COORDINATE;
use toml::de::DeValue;

use self::fields::{Kind, Table};
use super::table_reader::TableReader;
use crate::scene::error::SceneError;
use crate::scene::meshes::lamp::{Lamp, Shape};
use crate::scene::{LightLabel, PunctualLight, Scene, SpotEdge};

/// A `[[light]]` table.
#[derive(Clone, Debug, PartialEq)]
pub struct LightTable {
    source: Source,
    /// The name.
    label: LightLabel,
    /// The file of its profile.
    file: Option<PathBuf>,
    /// What is to be told about it.
    warning: Option<String>,
}

#[derive(Clone, Debug, PartialEq)]
enum Source {
    Punctual(PunctualLight),
    Lamp(Lamp),
}

/// The largest size of lamps, and their largest coordinate, so that no corner is too far away.
const MAX_SIZE: f32 = 0.25 * MAX_COORDINATE;
/// As in Blender.
const DEFAULT_CONE: f32 = 45.0;
const DEFAULT_BLEND: f32 = 0.15;

/// The tables in an array called `light`, of a scene file at `path` with this text.
pub(super) fn read(path: &Path, text: &str, tables: &DeValue<'_>, at: usize) -> Result<Vec<LightTable>, SceneError> {
    let reader = TableReader { path, text, name: "light" };
    let lights = reader.tables(tables, at, |table, at| Table::new(&reader, table, at)?.light())?;
    let named = (1..).zip(lights).map(|(number, mut light)| {
        if let Source::Lamp(Lamp { name, .. }) = &mut light.source
            && name.is_empty()
        {
            *name = format!("light {number}");
        }
        light
    });
    Ok(named.collect())
}

impl LightTable {
    /// Adds the light to a scene.
    pub(crate) fn add_to(&self, scene: &mut Scene) {
        scene.files.extend(self.file.clone());
        scene.warnings.extend(self.warning.clone());
        match &self.source {
            Source::Punctual(light) => scene.add_light(light.clone(), self.label.clone()),
            Source::Lamp(lamp) => lamp.add_to(scene),
        }
    }
}

impl<'a> Table<'a> {
    fn light(&self) -> Result<LightTable, SceneError> {
        let source = match self.kind {
            Kind::Point => Source::Punctual(PunctualLight::Point {
                position: self.position()?,
                intensity: self.strength("intensity", 4.0 * std::f64::consts::PI)?,
                radius: self.number("radius", 0.0, PunctualLight::MAX_RADIUS, 0.0)?,
            }),
            Kind::Spot => Source::Punctual(self.spot()?),
            Kind::ProfiledPoint | Kind::ProfiledSpot => return self.profiled(self.required("profile", "profile = …")?),
            Kind::Directional => Source::Punctual(PunctualLight::Directional {
                direction: self.direction()?,
                irradiance: self.strength("irradiance", 0.0)?,
                half_angle: 0.5 * self.number("angle", 0.0, 179.0, 0.0)?.to_radians(),
            }),
            Kind::Sphere => Source::Lamp(self.lamp(Shape::Sphere { radius: self.size()? })?),
            Kind::Disc => Source::Lamp(self.lamp(Shape::Disc {
                radius: self.size()?,
                direction: self.direction()?,
                two_sided: self.flag("two_sided")?,
            })?),
            Kind::Rectangle => Source::Lamp(self.lamp(self.rectangle()?)?),
        };
        Ok(self.finish(source, None))
    }

    /// The light of this source; one that is turned off by a mistake would only be missed in the picture.
    fn finish(&self, source: Source, file: Option<PathBuf>) -> LightTable {
        let strength = match &source {
            Source::Lamp(lamp) => lamp.radiance,
            Source::Punctual(light) => light.power().0,
        };
        let warning = (strength == Vec3::ZERO).then(|| {
            let name = if self.name.is_empty() { String::new() } else { format!(" {:?}", self.name) };
            let place = format!("{}:{}", self.reader.path.display(), self.reader.line(self.at));
            format!("{place}: this {} light{name} has a strength of 0: it emits nothing", self.what)
        });
        LightTable { source, label: self.label(), file, warning }
    }

    fn label(&self) -> LightLabel {
        LightLabel { name: self.name.clone(), group: self.group.clone() }
    }

    /// The radius of a lamp.
    fn size(&self) -> Result<f32, SceneError> {
        self.reader.number(self.required("radius", "radius = …")?, f32::MIN_POSITIVE, MAX_SIZE)
    }

    fn lamp(&self, shape: Shape) -> Result<Lamp, SceneError> {
        let radiance = self.strength("radiance", std::f64::consts::PI * shape.area())?;
        let LightLabel { name, group } = self.label();
        Ok(Lamp { name, group, position: self.position()?, shape, radiance })
    }

    fn rectangle(&self) -> Result<Shape, SceneError> {
        let entry = self.required("size", "size = [width, height]")?;
        let what = "a width and a height, each more than 0";
        let size = self.reader.pair(entry, what)?;
        if !(size.min_element() > 0.0 && size.max_element() <= MAX_SIZE) {
            return self.reader.wrong(entry, what);
        }
        let direction = self.direction()?;
        let up = match self.get("up") {
            Some(entry) => across(self.unit(entry)?, direction)
                .map_or_else(|| self.reader.wrong(entry, "a vector that is not parallel to the direction"), Ok)?,
            None => across(Vec3::Y, direction).or_else(|| across(Vec3::Z, direction)).unwrap_or(Vec3::X),
        };
        Ok(Shape::Rectangle { size, direction, up, two_sided: self.flag("two_sided")? })
    }

    fn spot(&self) -> Result<PunctualLight, SceneError> {
        let gltf = [self.get("inner"), self.get("outer")].into_iter().flatten().next();
        let blender = [self.get("cone"), self.get("blend")].into_iter().flatten().next();
        let (cos_inner, cos_outer, edge) = match (blender, gltf) {
            (Some(a), Some(b)) => {
                let problem = format!("this spot light has both {} and {}", a.name, b.name);
                let remedy = "write cone and blend, or inner and outer";
                return Err(self.reader.error(a.at.start.max(b.at.start), problem, remedy));
            }
            (_, None) => {
                let cone = self.number("cone", f32::MIN_POSITIVE, 180.0, DEFAULT_CONE)?;
                let blend = self.number("blend", 0.0, 1.0, DEFAULT_BLEND)?;
                let (inner, outer) = SpotEdge::blended(0.5 * cone.to_radians(), blend);
                (inner, outer, SpotEdge::Smooth)
            }
            (None, Some(_)) => {
                let outer = self.required("outer", "outer = …, half the angle of the cone, degrees")?;
                let outer = self.reader.number(outer, f32::MIN_POSITIVE, 90.0)?;
                let inner = self.number("inner", 0.0, outer, 0.0)?;
                (inner.to_radians().cos(), outer.to_radians().cos(), SpotEdge::Square)
            }
        };
        let (cos_inner, cos_outer) = SpotEdge::apart(cos_inner, cos_outer);
        Ok(PunctualLight::Spot {
            position: self.position()?,
            direction: self.direction()?,
            intensity: self.strength("intensity", edge.solid_angle(cos_inner, cos_outer))?,
            radius: self.number("radius", 0.0, PunctualLight::MAX_RADIUS, 0.0)?,
            cos_inner,
            cos_outer,
            edge,
        })
    }
}

/// The unit vector at a right angle to `direction` that is nearest to `up`; `None` if they are parallel.
fn across(up: Vec3, direction: Vec3) -> Option<Vec3> {
    let (up, direction) = (up.as_dvec3(), direction.as_dvec3());
    let across = up - direction * up.dot(direction);
    (across.length() > 1e-4).then(|| across.normalize().as_vec3())
}

#[cfg(test)]
mod tests;
