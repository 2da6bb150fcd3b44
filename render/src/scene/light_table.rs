//! `[[light]]` in scene files: lights and lamps that the model lacks.
//!
//! ```toml
//! [[light]]
//! type = "spot"                  # point, spot, directional, sphere, disc, rectangle
//! name = "desk"                  # for messages, and of a lamp's mesh and material
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
//! A point light has `position`, `intensity` or `power`, and `radius`. A directional one has `direction`, `irradiance` (W/m² on
//! what faces it), and `angle` (degrees that its disc subtends). The others are lamps that one sees, with `radiance`
//! (W/(m² sr)) or `power` (π × radiance × area of all sides): a `sphere` with `position` and `radius`, a `disc` with these and
//! `direction` or `target`, a `rectangle` with `size = [width, height]` and `up` in place of the radius; the last two may
//! be `two_sided`.

use std::path::Path;

use glam::{DVec3, Vec3};
use halfdome_kernel::MAX_COORDINATE;
use toml::de::{DeTable, DeValue};

use super::description::unit;
use super::error::SceneError;
use super::lamp::{Lamp, Shape};
use super::nearest::suggestion;
use super::table_reader::TableReader;
use super::toml_text::{Entry, entries, value_of};
use super::value;
use super::{PunctualLight, Scene, SpotEdge};

/// A `[[light]]` table.
#[derive(Clone, Debug, PartialEq)]
pub struct LightTable(Source);

#[derive(Clone, Debug, PartialEq)]
enum Source {
    Punctual(PunctualLight),
    Lamp(Lamp),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Point,
    Spot,
    Directional,
    Sphere,
    Disc,
    Rectangle,
}

const KINDS: [(&str, Kind); 6] = [
    ("point", Kind::Point),
    ("spot", Kind::Spot),
    ("directional", Kind::Directional),
    ("sphere", Kind::Sphere),
    ("disc", Kind::Disc),
    ("rectangle", Kind::Rectangle),
];

impl Kind {
    /// Its keys, besides those of all kinds.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Point => &["position", "intensity", "power", "radius"],
            Self::Spot => {
                &["position", "direction", "target", "intensity", "power", "radius", "cone", "blend", "inner", "outer"]
            }
            Self::Directional => &["direction", "irradiance", "angle"],
            Self::Sphere => &["position", "radius", "radiance", "power"],
            Self::Disc => &["position", "direction", "target", "radius", "radiance", "power", "two_sided"],
            Self::Rectangle => &["position", "direction", "target", "up", "size", "radiance", "power", "two_sided"],
        }
    }
}

/// Keys of all kinds.
const KEYS: [&str; 3] = ["type", "name", "color"];

/// The largest light without a surface; lamps have coordinates.
const MAX_RADIUS: f32 = 1e15;
/// Of lamps, as of their places: so no corner is too far away.
const MAX_SIZE: f32 = 0.25 * MAX_COORDINATE;
/// As in Blender.
const DEFAULT_CONE: f32 = 45.0;
const DEFAULT_BLEND: f32 = 0.15;

/// The tables in an array called `light`, of a scene file at `path` with this text.
pub(super) fn read(path: &Path, text: &str, tables: &DeValue<'_>, at: usize) -> Result<Vec<LightTable>, SceneError> {
    let reader = TableReader { path, text, name: "light" };
    let lights = reader.tables(tables, at, |table, at| Table::new(&reader, table, at)?.light())?;
    let named = (1..).zip(lights).map(|(number, LightTable(mut source))| {
        if let Source::Lamp(Lamp { name, .. }) = &mut source
            && name.is_empty()
        {
            *name = format!("light {number}");
        }
        LightTable(source)
    });
    Ok(named.collect())
}

impl LightTable {
    /// Adds the light to a scene.
    pub(super) fn add_to(&self, scene: &mut Scene) {
        match &self.0 {
            Source::Punctual(light) => scene.lights.push(light.clone()),
            Source::Lamp(lamp) => lamp.add_to(scene),
        }
    }
}

/// A table whose keys are known to be of its kind.
struct Table<'a> {
    reader: &'a TableReader<'a>,
    entries: Vec<Entry<'a>>,
    kind: Kind,
    /// The kind's name.
    what: &'static str,
    /// The light's own, or empty.
    name: String,
    at: usize,
}

impl<'a> Table<'a> {
    fn new(reader: &'a TableReader<'a>, table: &'a DeTable<'a>, at: usize) -> Result<Self, SceneError> {
        let entries = entries(table);
        let names = KINDS.map(|(name, _)| name).join(", ");
        let Some(of_kind) = entries.iter().find(|entry| entry.name == "type") else {
            return Err(reader.error(at, "this light has no type", format!("write type = \"…\" with one of {names}")));
        };
        let kind = reader.one_of(of_kind, &KINDS)?;
        let what = KINDS.iter().find(|(_, it)| *it == kind).map_or("", |(name, _)| name);
        let known = || kind.keys().iter().chain(&KEYS).copied();
        if let Some(entry) = entries.iter().find(|entry| !known().any(|key| key == entry.name)) {
            let problem = format!("unknown key {:?} of a {what} light", entry.name);
            return Err(reader.error(entry.at.start, problem, suggestion(entry.name, &known().collect::<Vec<_>>())));
        }
        let name = entries.iter().find(|entry| entry.name == "name").map(|entry| reader.text_of(entry));
        Ok(Self { reader, kind, what, name: name.transpose()?.unwrap_or_default(), entries, at })
    }

    fn light(&self) -> Result<LightTable, SceneError> {
        Ok(LightTable(match self.kind {
            Kind::Point => Source::Punctual(PunctualLight::Point {
                position: self.position()?,
                intensity: self.strength("intensity", 4.0 * std::f64::consts::PI)?,
                radius: self.number("radius", 0.0, MAX_RADIUS, 0.0)?,
            }),
            Kind::Spot => Source::Punctual(self.spot()?),
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
        }))
    }

    fn get(&self, name: &str) -> Option<&Entry<'a>> {
        self.entries.iter().find(|entry| entry.name == name)
    }

    fn required(&self, name: &str, remedy: &str) -> Result<&Entry<'a>, SceneError> {
        let problem = || format!("this {} light has no {name}", self.what);
        self.get(name).ok_or_else(|| self.reader.error(self.at, problem(), format!("write {remedy}")))
    }

    /// Of two keys that say the same, the one that is there, if any is.
    fn either(&self, a: &str, b: &str) -> Result<Option<&Entry<'a>>, SceneError> {
        match (self.get(a), self.get(b)) {
            (Some(a), Some(b)) => {
                let second = if a.at.start > b.at.start { a } else { b };
                let problem = format!("this {} light has both {} and {}", self.what, a.name, b.name);
                Err(self.reader.error(second.at.start, problem, "leave one of them out"))
            }
            (a, b) => Ok(a.or(b)),
        }
    }

    fn number(&self, name: &str, least: f32, greatest: f32, default: f32) -> Result<f32, SceneError> {
        self.get(name).map_or(Ok(default), |entry| self.reader.number(entry, least, greatest))
    }

    fn flag(&self, name: &str) -> Result<bool, SceneError> {
        self.get(name).map_or(Ok(false), |entry| self.reader.flag(entry))
    }

    fn point(&self, entry: &Entry<'a>) -> Result<Vec3, SceneError> {
        match value_of(entry.value).three() {
            Some(point) if point.abs().max_element() <= MAX_COORDINATE * 0.5 => Ok(point),
            _ => self.reader.wrong(entry, &format!("three numbers x, y, z, of {:e} at most", 0.5 * MAX_COORDINATE)),
        }
    }

    fn position(&self) -> Result<Vec3, SceneError> {
        self.point(self.required("position", "position = [x, y, z]")?)
    }

    /// The unit vector along which it shines.
    fn direction(&self) -> Result<Vec3, SceneError> {
        let has_target = self.kind.keys().contains(&"target");
        let entry = if has_target { self.either("direction", "target")? } else { self.get("direction") };
        let Some(entry) = entry else {
            let remedy =
                if has_target { "direction = [x, y, z], or target = [x, y, z]" } else { "direction = [x, y, z]" };
            return self.required("direction", remedy).map(|_| Vec3::ZERO);
        };
        if entry.name == "direction" {
            return self.unit(entry);
        }
        let way = self.point(entry)?.as_dvec3() - self.position()?.as_dvec3();
        match way.try_normalize() {
            Some(direction) => Ok(direction.as_vec3()),
            None => self.reader.wrong(entry, "another point than the position"),
        }
    }

    fn unit(&self, entry: &Entry<'a>) -> Result<Vec3, SceneError> {
        match value::direction(&value_of(entry.value)).map(unit) {
            Ok(Some(direction)) => Ok(direction),
            _ => self.reader.wrong(entry, "three numbers x, y, z that are not all zero"),
        }
    }

    /// The strength by the key `name`, or by the power over `extent`; with an extent of 0 there is no power.
    fn strength(&self, name: &str, extent: f64) -> Result<Vec3, SceneError> {
        let has_power = extent > 0.0;
        let entry = if has_power { self.either(name, "power")? } else { self.get(name) };
        let Some(entry) = entry else {
            let units = [("intensity", "W/sr"), ("irradiance", "W/m²"), ("radiance", "W/(m² sr)")];
            let unit = units.iter().find(|(it, _)| *it == name).map_or("", |(_, unit)| unit);
            let power = if has_power { ", or power = … (W)" } else { "" };
            let missing = if has_power { format!("{name} and no power") } else { name.to_owned() };
            let problem = format!("this {} light has no {missing}", self.what);
            return Err(self.reader.error(self.at, problem, format!("write {name} = … ({unit}){power}")));
        };
        let value = self.reader.color(entry, 0.0, f32::MAX)?.as_dvec3();
        let color = self.get("color").map_or(Ok(Vec3::ONE), |color| self.reader.color(color, 0.0, f32::MAX))?;
        let scale = if entry.name == "power" { extent.recip() } else { 1.0 };
        let strength: DVec3 = value * color.as_dvec3() * scale;
        if strength.max_element() > f64::from(f32::MAX) {
            return self.reader.wrong(entry, "less light, or a larger lamp");
        }
        Ok(strength.as_vec3())
    }

    /// The radius of a lamp.
    fn size(&self) -> Result<f32, SceneError> {
        self.reader.number(self.required("radius", "radius = …")?, f32::MIN_POSITIVE, MAX_SIZE)
    }

    fn lamp(&self, shape: Shape) -> Result<Lamp, SceneError> {
        let radiance = self.strength("radiance", std::f64::consts::PI * shape.area())?;
        Ok(Lamp { name: self.name.clone(), position: self.position()?, shape, radiance })
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
            radius: self.number("radius", 0.0, MAX_RADIUS, 0.0)?,
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
