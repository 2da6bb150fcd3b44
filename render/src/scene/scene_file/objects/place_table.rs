//! Tables of places: the transforms of instances.
//!
//! Columns, or properties of PLY's vertices, have these names: `x y z`, and if they are there `qx qy qz qw` (a
//! quaternion), or `rx ry rz` (degrees about x, then y, then z), or `nx ny nz` (where +y points), and `scale` or `sx sy
//! sz`. Other columns are ignored. CSV has the names in its first line; numbers are separated by commas, semicolons or
//! blanks; blank lines and `#` comments are skipped.

use std::path::Path;

use glam::{Affine3A, EulerRot, Quat, Vec3};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use crate::scene::{Place, SceneError};

/// The names, in the order of a row's numbers.
const NAMES: [&str; 17] =
    ["x", "y", "z", "qx", "qy", "qz", "qw", "rx", "ry", "rz", "nx", "ny", "nz", "scale", "sx", "sy", "sz"];
/// Columns that must come together.
const GROUPS: [&[&str]; 6] = [
    &["x", "y", "z"],
    &["qx", "qy", "qz", "qw"],
    &["rx", "ry", "rz"],
    &["nx", "ny", "nz"],
    &["scale"],
    &["sx", "sy", "sz"],
];
const HELP: &str = "name the columns x y z, and if need be qx qy qz qw or rx ry rz or nx ny nz, and scale or sx sy sz";

/// The numbers of a place.
struct Row([f32; NAMES.len()]);

/// The columns' names.
struct Columns([bool; NAMES.len()]);

/// Reads a `.csv`, `.txt` or `.ply`.
pub(super) fn read(path: &Path) -> Result<Vec<Affine3A>, SceneError> {
    let bytes = std::fs::read(path).map_err(|error| SceneError::unreadable(path, &error))?;
    let is_ply = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ply"));
    if is_ply { read_ply(path, &bytes) } else { read_text(path, &bytes) }
}

fn read_text(path: &Path, bytes: &[u8]) -> Result<Vec<Affine3A>, SceneError> {
    let whole = |problem: &str| SceneError::new(path, Place::File, problem, HELP);
    let text = str::from_utf8(bytes).map_err(|_| whole("this is not UTF-8"))?;
    let lines = (1..).zip(text.trim_start_matches('\u{feff}').lines());
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'));
    let words = |line: &'_ str| -> Vec<String> {
        let words = line.split([',', ';', ' ', '\t']).map(|word| word.trim().trim_matches('"'));
        words.filter(|word| !word.is_empty()).map(str::to_owned).collect()
    };
    let Some((first, header)) = lines.next() else { return Err(whole("the table is empty")) };
    let header = words(header);
    if header.iter().all(|word| word.parse::<f32>().is_ok()) {
        return Err(SceneError::new(path, Place::Line(first), "the first line has no names", HELP));
    }
    let columns = Columns::new(header.iter().map(String::as_str));
    columns.check().map_err(|problem| SceneError::new(path, Place::Line(first), problem, HELP))?;
    let places: Vec<Option<usize>> =
        header.iter().map(|word| NAMES.iter().position(|name| name.eq_ignore_ascii_case(word))).collect();
    let mut rows = Vec::new();
    for (number, line) in lines {
        let error = |problem: String| {
            let remedy = format!("write {} numbers, as the first line has names", header.len());
            SceneError::new(path, Place::Line(number), problem, remedy)
        };
        let words = words(line);
        if words.len() != header.len() {
            return Err(error(format!("this line has {} values", words.len())));
        }
        let mut row = Row([0.0; NAMES.len()]);
        for (word, place) in words.iter().zip(&places) {
            if let Some(place) = *place {
                row.0[place] = word.parse().map_err(|_| error(format!("`{word}` is not a number")))?;
            }
        }
        rows.push(columns.transform(&row).map_err(error)?);
    }
    Ok(rows)
}

fn read_ply(path: &Path, bytes: &[u8]) -> Result<Vec<Affine3A>, SceneError> {
    let whole = |problem: String| SceneError::new(path, Place::File, problem, "export the points again");
    let mut reader = Reader::new(bytes);
    let header = Parser::<Row>::new().read_header(&mut reader).map_err(|error| {
        let message = error.to_string();
        whole(format!("its header is wrong: {}", message.lines().next().unwrap_or_default()))
    })?;
    let left = reader.get_ref().len();
    let mut found = None;
    for element in header.elements.values() {
        // No element takes less than a byte.
        if element.count > left {
            return Err(whole(format!("the file is too short for {} of `{}`", element.count, element.name)));
        }
        let rows = Parser::<Row>::new().read_payload_for_element(&mut reader, element, &header).map_err(|error| {
            let message = error.to_string();
            whole(format!("element `{}`: {}", element.name, message.lines().next().unwrap_or_default()))
        })?;
        if element.name == "vertex" {
            let columns = Columns::new(element.properties.keys().map(String::as_str));
            columns
                .check()
                .map_err(|problem| SceneError::new(path, Place::Part("element `vertex`".into()), problem, HELP))?;
            let transform = |(number, row): (usize, &Row)| {
                let part = || Place::Part(format!("vertex {number}"));
                columns
                    .transform(row)
                    .map_err(|problem| SceneError::new(path, part(), problem, "export the points again"))
            };
            found = Some(rows.iter().enumerate().map(transform).collect::<Result<Vec<_>, _>>()?);
        }
    }
    found.ok_or_else(|| whole("it has no element `vertex`".to_owned()))
}

impl PropertyAccess for Row {
    fn new() -> Self {
        Self([0.0; NAMES.len()])
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let Some(place) = NAMES.iter().position(|it| *it == name) else { return PropertyAccessResult::Ignored };
        let Some(value) = value.to_f32_lossy() else { return PropertyAccessResult::UnsupportedType };
        self.0[place] = value;
        PropertyAccessResult::Set
    }
}

impl Columns {
    fn new<'n>(names: impl Iterator<Item = &'n str>) -> Self {
        let mut columns = Self([false; NAMES.len()]);
        for name in names {
            if let Some(place) = NAMES.iter().position(|it| it.eq_ignore_ascii_case(name)) {
                columns.0[place] = true;
            }
        }
        columns
    }

    fn has(&self, name: &str) -> bool {
        NAMES.iter().zip(self.0).any(|(it, is_there)| *it == name && is_there)
    }

    /// The error of the names.
    fn check(&self) -> Result<(), String> {
        if !self.has("x") {
            return Err("there is no column x".to_owned());
        }
        for group in GROUPS {
            let missing = group.iter().find(|name| !self.has(name));
            if let (Some(missing), Some(there)) = (missing, group.iter().find(|name| self.has(name))) {
                return Err(format!("there is a column {there}, but none called {missing}"));
            }
        }
        for group in [["qx", "rx", "nx"].as_slice(), &["scale", "sx"]] {
            let mut there = group.iter().filter(|name| self.has(name));
            if let (Some(a), Some(b)) = (there.next(), there.next()) {
                return Err(format!("there are both {a} and {b}"));
            }
        }
        Ok(())
    }

    /// The transform that a row means.
    fn transform(&self, Row(row): &Row) -> Result<Affine3A, String> {
        if let Some(place) = (0..NAMES.len()).find(|&place| self.0[place] && !row[place].is_finite()) {
            return Err(format!("{} is {}, which is not finite", NAMES[place], row[place]));
        }
        let [x, y, z, qx, qy, qz, qw, rx, ry, rz, nx, ny, nz, scale, sx, sy, sz] = *row;
        let rotation = if self.has("qx") {
            let quaternion = Quat::from_xyzw(qx, qy, qz, qw);
            if quaternion.length_squared() == 0.0 {
                return Err("the quaternion is zero".to_owned());
            }
            quaternion.normalize()
        } else if self.has("rx") {
            Quat::from_euler(EulerRot::ZYX, rz.to_radians(), ry.to_radians(), rx.to_radians())
        } else if self.has("nx") {
            let Some(up) = Vec3::new(nx, ny, nz).try_normalize() else { return Err("the normal is zero".to_owned()) };
            Quat::from_rotation_arc(Vec3::Y, up)
        } else {
            Quat::IDENTITY
        };
        let scale = match (self.has("scale"), self.has("sx")) {
            (true, _) => Vec3::splat(scale),
            (_, true) => Vec3::new(sx, sy, sz),
            _ => Vec3::ONE,
        };
        Ok(Affine3A::from_scale_rotation_translation(scale, rotation, Vec3::new(x, y, z)))
    }
}
