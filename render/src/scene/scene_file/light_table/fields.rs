//! The keys of a `[[light]]` table by kind, and their values.

use glam::{DVec3, Vec3};
use halfdome_kernel::MAX_COORDINATE;
use toml::de::DeTable;

use crate::scene::description::unit;
use crate::scene::error::SceneError;
use crate::scene::nearest::suggestion;
use crate::scene::scene_file::table_reader::TableReader;
use crate::scene::scene_file::toml_text::{Entry, entries, value_of};
use crate::scene::scene_file::value;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Point,
    Spot,
    /// Either of them with a profile.
    ProfiledPoint,
    ProfiledSpot,
    Directional,
    Sphere,
    Disc,
    Rectangle,
}

/// A kind may have two names, of which messages use the first.
const KINDS: [(&str, Kind); 7] = [
    ("point", Kind::Point),
    ("spot", Kind::Spot),
    ("directional", Kind::Directional),
    ("sun", Kind::Directional),
    ("sphere", Kind::Sphere),
    ("disc", Kind::Disc),
    ("rectangle", Kind::Rectangle),
];

impl Kind {
    /// Its keys, besides those of all kinds.
    pub(super) fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Point => &["position", "intensity", "power", "radius"],
            Self::Spot => {
                &["position", "direction", "target", "intensity", "power", "radius", "cone", "blend", "inner", "outer"]
            }
            Self::ProfiledPoint | Self::ProfiledSpot => {
                &["position", "direction", "target", "profile", "profile_rotation", "scale", "power", "radius"]
            }
            Self::Directional => &["direction", "irradiance", "angle"],
            Self::Sphere => &["position", "radius", "radiance", "power"],
            Self::Disc => &["position", "direction", "target", "radius", "radiance", "power", "two_sided"],
            Self::Rectangle => &["position", "direction", "target", "up", "size", "radiance", "power", "two_sided"],
        }
    }
}

/// Keys of all kinds.
const KEYS: [&str; 4] = ["type", "name", "group", "color"];
/// Keys that points and spots have with a profile alone.
const PROFILE_KEYS: [&str; 3] = ["profile", "profile_rotation", "scale"];

/// A table whose keys are known to be of its kind.
pub(super) struct Table<'a> {
    pub(super) reader: &'a TableReader<'a>,
    entries: Vec<Entry<'a>>,
    pub(super) kind: Kind,
    /// The kind's name.
    pub(super) what: &'static str,
    /// The light's own, or empty.
    pub(super) name: String,
    /// The light group that it is in, or empty.
    pub(super) group: String,
    pub(super) at: usize,
}

impl<'a> Table<'a> {
    pub(super) fn new(reader: &'a TableReader<'a>, table: &'a DeTable<'a>, at: usize) -> Result<Self, SceneError> {
        let entries = entries(table);
        let has = |name: &str| entries.iter().any(|entry| entry.name == name);
        let names = KINDS.map(|(name, _)| name).join(", ");
        let Some(of_kind) = entries.iter().find(|entry| entry.name == "type") else {
            return Err(reader.error(at, "this light has no type", format!("write type = \"…\" with one of {names}")));
        };
        let named = reader.one_of(of_kind, &KINDS)?;
        let kind = match named {
            Kind::Point if has("profile") => Kind::ProfiledPoint,
            Kind::Spot if has("profile") => Kind::ProfiledSpot,
            other => other,
        };
        let what = KINDS.iter().find(|(_, it)| *it == named).map_or("", |(name, _)| name);
        let known = || kind.keys().iter().chain(&KEYS).copied();
        if let Some(entry) = entries.iter().find(|entry| !known().any(|key| key == entry.name)) {
            let mut known: Vec<&str> = known().collect();
            let with = if has("profile") { " with a profile" } else { "" };
            known.extend(PROFILE_KEYS.iter().filter(|_| matches!(kind, Kind::Point | Kind::Spot)));
            let problem = format!("unknown key {:?} of a {what} light{with}", entry.name);
            let needs = PROFILE_KEYS.contains(&entry.name) && known.contains(&entry.name);
            let remedy =
                if needs { "name a profile = \"….ies\" too".to_owned() } else { suggestion(entry.name, &known) };
            return Err(reader.error(entry.at.start, problem, remedy));
        }
        let text = |key: &str| {
            let entry = entries.iter().find(|entry| entry.name == key);
            entry.map_or_else(|| Ok(String::new()), |entry| reader.text_of(entry))
        };
        Ok(Self { reader, kind, what, name: text("name")?, group: text("group")?, entries, at })
    }

    pub(super) fn get(&self, name: &str) -> Option<&Entry<'a>> {
        self.entries.iter().find(|entry| entry.name == name)
    }

    pub(super) fn required(&self, name: &str, remedy: &str) -> Result<&Entry<'a>, SceneError> {
        let problem = || format!("this {} light has no {name}", self.what);
        self.get(name).ok_or_else(|| self.reader.error(self.at, problem(), format!("write {remedy}")))
    }

    /// Of two keys that say the same, the one that is there, if any is.
    pub(super) fn either(&self, a: &str, b: &str) -> Result<Option<&Entry<'a>>, SceneError> {
        match (self.get(a), self.get(b)) {
            (Some(a), Some(b)) => {
                let second = if a.at.start > b.at.start { a } else { b };
                let problem = format!("this {} light has both {} and {}", self.what, a.name, b.name);
                Err(self.reader.error(second.at.start, problem, "leave one of them out"))
            }
            (a, b) => Ok(a.or(b)),
        }
    }

    pub(super) fn number(&self, name: &str, least: f32, greatest: f32, default: f32) -> Result<f32, SceneError> {
        self.get(name).map_or(Ok(default), |entry| self.reader.number(entry, least, greatest))
    }

    pub(super) fn flag(&self, name: &str) -> Result<bool, SceneError> {
        self.get(name).map_or(Ok(false), |entry| self.reader.flag(entry))
    }

    pub(super) fn point(&self, entry: &Entry<'a>) -> Result<Vec3, SceneError> {
        match value_of(entry.value).three() {
            Some(point) if point.abs().max_element() <= MAX_COORDINATE * 0.5 => Ok(point),
            _ => self.reader.wrong(entry, &format!("three numbers x, y, z, of {:e} at most", 0.5 * MAX_COORDINATE)),
        }
    }

    pub(super) fn position(&self) -> Result<Vec3, SceneError> {
        self.point(self.required("position", "position = [x, y, z]")?)
    }

    /// The unit vector along which it shines.
    pub(super) fn direction(&self) -> Result<Vec3, SceneError> {
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
        let vector = self.point(entry)?.as_dvec3() - self.position()?.as_dvec3();
        match vector.try_normalize() {
            Some(direction) => Ok(direction.as_vec3()),
            None => self.reader.wrong(entry, "another point than the position"),
        }
    }

    pub(super) fn unit(&self, entry: &Entry<'a>) -> Result<Vec3, SceneError> {
        match value::direction(&value_of(entry.value)).map(unit) {
            Ok(Some(direction)) => Ok(direction),
            _ => self.reader.wrong(entry, "three numbers x, y, z, of 1e38 at most, that are not all zero"),
        }
    }

    /// The strength by the key `name`, or by the power over `extent`; with an extent of 0 there is no power.
    pub(super) fn strength(&self, name: &str, extent: f64) -> Result<Vec3, SceneError> {
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
        let scale = if entry.name == "power" { extent.recip() } else { 1.0 };
        let strength: DVec3 = value * self.color()?.as_dvec3() * scale;
        if strength.max_element() > f64::from(f32::MAX) {
            return self.reader.wrong(entry, "less light, or a larger lamp");
        }
        Ok(strength.as_vec3())
    }

    /// The factor on the strength.
    pub(super) fn color(&self) -> Result<Vec3, SceneError> {
        self.get("color").map_or(Ok(Vec3::ONE), |color| self.reader.color(color, 0.0, f32::MAX))
    }
}
