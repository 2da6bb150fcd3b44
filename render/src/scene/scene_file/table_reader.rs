//! Reads the values of tables in a scene file, such as `[[material]]`, with errors for invalid ones.

use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};
use toml::de::{DeTable, DeValue};

use super::toml_text::{Entry, line_of, shortened, value_of};
use super::value::Value;
use crate::scene::error::{Place, SceneError};

/// A scene file, and what its tables of one kind are called.
pub(super) struct TableReader<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
    pub(super) name: &'static str,
}

impl TableReader<'_> {
    /// What `read` makes of each table in an array and of its place.
    pub(super) fn tables<T>(
        &self,
        tables: &DeValue<'_>,
        at: usize,
        read: impl Fn(&DeTable<'_>, usize) -> Result<T, SceneError>,
    ) -> Result<Vec<T>, SceneError> {
        let remedy = format!("write [[{}]] on a line", self.name);
        let DeValue::Array(tables) = tables else {
            return Err(self.error(at, format!("`{}` is not a list of tables", self.name), remedy));
        };
        let table = |table: &toml::Spanned<DeValue<'_>>| match table.get_ref() {
            DeValue::Table(entries) => read(entries, table.span().start),
            _ => Err(self.error(table.span().start, format!("this {} is not a table", self.name), remedy.as_str())),
        };
        tables.iter().map(table).collect()
    }

    pub(crate) fn line(&self, offset: usize) -> usize {
        line_of(self.text.as_bytes(), offset)
    }

    pub(crate) fn error(&self, offset: usize, problem: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError::new(self.path, Place::Line(self.line(offset)), problem, remedy)
    }

    /// The error that `entry` has another value than it should.
    pub(crate) fn wrong<T>(&self, entry: &Entry<'_>, expected: &str) -> Result<T, SceneError> {
        let written = self.text.get(entry.value_at.clone()).unwrap_or_default();
        let problem = format!("{}.{} is {}", self.name, entry.name, shortened(written));
        Err(self.error(entry.value_at.start, problem, format!("expected {expected}")))
    }

    pub(super) fn text_of(&self, entry: &Entry<'_>) -> Result<String, SceneError> {
        match value_of(entry.value) {
            Value::Text(text) if !text.is_empty() => Ok(text),
            _ => self.wrong(entry, "text"),
        }
    }

    pub(crate) fn number(&self, entry: &Entry<'_>, least: f32, greatest: f32) -> Result<f32, SceneError> {
        match value_of(entry.value).finite() {
            Some(number) if (least..=greatest).contains(&number) => Ok(number),
            _ => self.wrong(entry, &format!("a number{}", range(least, greatest))),
        }
    }

    pub(crate) fn flag(&self, entry: &Entry<'_>) -> Result<bool, SceneError> {
        match value_of(entry.value) {
            Value::Boolean(flag) => Ok(flag),
            _ => self.wrong(entry, "true or false"),
        }
    }

    /// Three numbers, or one for all.
    pub(crate) fn color(&self, entry: &Entry<'_>, least: f32, greatest: f32) -> Result<Vec3, SceneError> {
        let value = value_of(entry.value);
        match value.finite().map(Vec3::splat).or_else(|| value.three()) {
            Some(color) if color.min_element() >= least && color.max_element() <= greatest => Ok(color),
            _ => self.wrong(entry, &format!("one number, or three for red, green and blue,{}", range(least, greatest))),
        }
    }

    /// Two numbers, which `what` describes.
    pub(super) fn pair(&self, entry: &Entry<'_>, what: &str) -> Result<Vec2, SceneError> {
        let Value::List(values) = value_of(entry.value) else { return self.wrong(entry, what) };
        match values.iter().map(Value::finite).collect::<Option<Vec<f32>>>().as_deref() {
            Some(&[x, y]) => Ok(Vec2::new(x, y)),
            _ => self.wrong(entry, what),
        }
    }

    /// A path, relative to the folder of the scene file.
    pub(crate) fn file(&self, entry: &Entry<'_>) -> Result<PathBuf, SceneError> {
        Ok(self.path.parent().unwrap_or(Path::new("")).join(self.text_of(entry)?))
    }

    pub(super) fn one_of<T: Copy>(&self, entry: &Entry<'_>, known: &[(&str, T)]) -> Result<T, SceneError> {
        value_of(entry.value).one_of(known).or_else(|expected| self.wrong(entry, &expected.0))
    }
}

/// " from 0 to 1", " of 0 or more", or nothing.
fn range(least: f32, greatest: f32) -> String {
    match (least, greatest) {
        (f32::MIN, f32::MAX) => String::new(),
        (f32::MIN_POSITIVE, f32::MAX) => " that is more than 0".to_owned(),
        (f32::MIN_POSITIVE, greatest) => format!(" that is more than 0, up to {greatest}"),
        (least, f32::MAX) => format!(" of {least} or more"),
        (least, greatest) => format!(" from {least} to {greatest}"),
    }
}
