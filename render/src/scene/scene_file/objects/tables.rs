//! The keys of `[[object]]` and `[[instance]]`.

use std::path::{Path, PathBuf};

use glam::{Affine3A, EulerRot, Mat3A, Quat, Vec3, Vec3A};
use toml::de::{DeTable, DeValue};

use crate::scene::SceneError;
use crate::scene::nearest::suggestion;
use crate::scene::scene_file::table_reader::TableReader;
use crate::scene::scene_file::toml_text::{Entry, entries, value_of};
use crate::scene::scene_file::value::Value;

/// An `[[object]]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObjectTable {
    pub(super) name: String,
    pub(super) file: PathBuf,
    pub(super) line: usize,
}

/// An `[[instance]]`, or a table of them.
#[derive(Clone, Debug, PartialEq)]
pub struct InstanceTable {
    pub(super) of: String,
    pub(super) to_world: Affine3A,
    pub(super) file: Option<PathBuf>,
    /// Names of the object's materials, and of those in their place.
    pub(super) materials: Vec<(String, String)>,
    pub(super) line: usize,
}

const OBJECT_KEYS: [&str; 2] = ["name", "file"];
const INSTANCE_KEYS: [&str; 7] = ["of", "at", "rotate", "scale", "matrix", "table", "materials"];

/// The tables in an array called `object`, of a scene file at `path` with this text.
pub(in crate::scene) fn read_objects(
    path: &Path,
    text: &str,
    tables: &DeValue<'_>,
    at: usize,
) -> Result<Vec<ObjectTable>, SceneError> {
    let reader = TableReader { path, text, name: "object" };
    reader.tables(tables, at, |table, at| {
        let table = Keys::new(&reader, table, at, &OBJECT_KEYS)?;
        let entry = table.required("file", "file = \"model.glb\"")?;
        let file = existing(&reader, entry)?;
        if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
            return Err(reader.error(entry.at.start, "an object is a model, not a scene file", "name its model"));
        }
        let name = reader.text_of(table.required("name", "name = \"…\"")?)?;
        Ok(ObjectTable { name, file, line: reader.line(at) })
    })
}

/// The tables in an array called `instance`.
pub(in crate::scene) fn read_instances(
    path: &Path,
    text: &str,
    tables: &DeValue<'_>,
    at: usize,
) -> Result<Vec<InstanceTable>, SceneError> {
    let reader = TableReader { path, text, name: "instance" };
    reader.tables(tables, at, |table, at| {
        let table = Keys::new(&reader, table, at, &INSTANCE_KEYS)?;
        Ok(InstanceTable {
            of: reader.text_of(table.required("of", "of = \"…\", an object's name")?)?,
            to_world: table.transform()?,
            file: table.get("table").map(|entry| existing(&reader, entry)).transpose()?,
            materials: table.get("materials").map_or(Ok(Vec::new()), |entry| names(&reader, entry))?,
            line: reader.line(at),
        })
    })
}

/// The path of a file that exists.
fn existing(reader: &TableReader<'_>, entry: &Entry<'_>) -> Result<PathBuf, SceneError> {
    let file = reader.file(entry)?;
    if file.is_file() {
        return Ok(file);
    }
    let problem = format!("{}.{} is {}, which does not exist", reader.name, entry.name, file.display());
    Err(reader.error(entry.value_at.start, problem, "name a file, relative to the folder of this file"))
}

/// Pairs of text.
fn names(reader: &TableReader<'_>, entry: &Entry<'_>) -> Result<Vec<(String, String)>, SceneError> {
    let DeValue::Table(table) = entry.value else {
        return reader
            .wrong(entry, "names of the object's materials, each with another material: { leaf = \"autumn\" }");
    };
    entries(table).iter().map(|entry| Ok((entry.name.to_owned(), reader.text_of(entry)?))).collect()
}

/// A table whose keys are known.
struct Keys<'a> {
    reader: &'a TableReader<'a>,
    entries: Vec<Entry<'a>>,
    at: usize,
}

impl<'a> Keys<'a> {
    fn new(reader: &'a TableReader<'a>, table: &'a DeTable<'a>, at: usize, known: &[&str]) -> Result<Self, SceneError> {
        let entries = entries(table);
        if let Some(entry) = entries.iter().find(|entry| !known.contains(&entry.name)) {
            let problem = format!("unknown key {:?} of an {}", entry.name, reader.name);
            return Err(reader.error(entry.at.start, problem, suggestion(entry.name, known)));
        }
        Ok(Self { reader, entries, at })
    }

    fn get(&self, name: &str) -> Option<&Entry<'a>> {
        self.entries.iter().find(|entry| entry.name == name)
    }

    fn required(&self, name: &str, remedy: &str) -> Result<&Entry<'a>, SceneError> {
        let problem = || format!("this {} has no {name}", self.reader.name);
        self.get(name).ok_or_else(|| self.reader.error(self.at, problem(), format!("write {remedy}")))
    }

    fn vector(&self, name: &str, default: Vec3) -> Result<Vec3, SceneError> {
        let Some(entry) = self.get(name) else { return Ok(default) };
        let value = value_of(entry.value);
        let all = if name == "scale" { value.finite().map(Vec3::splat) } else { None };
        match all.or_else(|| value.three()) {
            Some(vector) => Ok(vector),
            None => {
                let or = if name == "scale" { "one number, or " } else { "" };
                self.reader.wrong(entry, &format!("{or}three numbers x, y, z"))
            }
        }
    }

    fn transform(&self) -> Result<Affine3A, SceneError> {
        let Some(matrix) = self.get("matrix") else {
            let (at, degrees) = (self.vector("at", Vec3::ZERO)?, self.vector("rotate", Vec3::ZERO)?);
            let scale = self.vector("scale", Vec3::ONE)?;
            let Vec3 { x, y, z } = degrees * std::f32::consts::PI / 180.0;
            // About x first.
            let rotation = Quat::from_euler(EulerRot::ZYX, z, y, x);
            return Ok(Affine3A::from_scale_rotation_translation(scale, rotation, at));
        };
        if let Some(other) = ["at", "rotate", "scale"].iter().find_map(|name| self.get(name)) {
            let problem = format!("this instance has both matrix and {}", other.name);
            return Err(self.reader.error(other.at.start, problem, "leave one of them out"));
        }
        let expected = "12 or 16 numbers, row by row; a fourth row is 0, 0, 0, 1";
        let Value::List(values) = value_of(matrix.value) else { return self.reader.wrong(matrix, expected) };
        let numbers: Option<Vec<f32>> = values.iter().map(Value::finite).collect();
        match numbers.as_deref() {
            Some(&[a, b, c, x, d, e, f, y, g, h, i, z, ref last @ ..]) if matches!(last, [] | [0.0, 0.0, 0.0, 1.0]) => {
                let columns = Mat3A::from_cols(Vec3A::new(a, d, g), Vec3A::new(b, e, h), Vec3A::new(c, f, i));
                Ok(Affine3A { matrix3: columns, translation: Vec3A::new(x, y, z) })
            }
            _ => self.reader.wrong(matrix, expected),
        }
    }
}
