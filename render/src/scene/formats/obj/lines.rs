//! A block of an OBJ file's lines, read independently, given only the number of vertices before it.

use std::path::Path;

use glam::{Vec2, Vec3};

use super::{Corner, FORMAT, NONE};
use crate::scene::SceneError;
use crate::scene::description::unit;
use crate::scene::error::count;
use crate::scene::formats::blocks::Block;
use crate::scene::formats::statement::{Statement, shown, statements};

/// The contents of lines, in order.
#[derive(Default)]
pub(super) struct Lines {
    pub(super) positions: Vec<Vec3>,
    pub(super) texcoords: Vec<Vec2>,
    /// Unit normals, or zero for those without a direction.
    pub(super) normals: Vec<Vec3>,
    /// The corners of all faces, with indices from the beginning of the file.
    pub(super) corners: Vec<Corner>,
    /// The number of each face's corners.
    pub(super) faces: Vec<u32>,
    /// State changes, each before a face.
    pub(super) changes: Vec<(usize, Change)>,
    pub(super) lines_and_points: usize,
}

/// The state of the following faces.
pub(super) enum Change {
    Object(String),
    Group(String),
    Material(String),
    /// Materials are defined in files.
    Libraries {
        line: usize,
        names: String,
    },
}

/// Numbers of positions, texture coordinates and normals.
#[derive(Clone, Copy, Default)]
pub(super) struct Counts(pub(super) [usize; 3]);

impl Counts {
    /// The counts of a block without errors.
    pub(super) fn of(block: Block) -> Self {
        let mut counts = [0; 3];
        let mut is_continued = false;
        for line in block.bytes.split(|&byte| byte == b'\n') {
            let line = line.trim_ascii();
            let kind = match line {
                [b'v', next, ..] if next.is_ascii_whitespace() => Some(0),
                [b'v', b't', next, ..] if next.is_ascii_whitespace() => Some(1),
                [b'v', b'n', next, ..] if next.is_ascii_whitespace() => Some(2),
                _ => None,
            };
            if let Some(kind) = kind.filter(|_| !is_continued) {
                counts[kind] += 1;
            }
            is_continued = line.ends_with(b"\\") && (is_continued || !line.starts_with(b"#"));
        }
        Self(counts)
    }

    pub(super) fn and(self, other: Self) -> Self {
        Self(std::array::from_fn(|kind| self.0[kind] + other.0[kind]))
    }
}

impl Lines {
    /// Reads a block of the file at `path`; `before` is the number of vertices before it.
    pub(super) fn read(path: &Path, block: Block, before: Counts) -> Result<Self, SceneError> {
        let mut lines = Self::default();
        for statement in statements(path, block, FORMAT) {
            lines.take(&statement?, before)?;
        }
        Ok(lines)
    }

    fn take(&mut self, statement: &Statement, before: Counts) -> Result<(), SceneError> {
        match statement.keyword() {
            b"v" => self.positions.push(Vec3::from_array(statement.numbers()?)),
            b"vn" => self.normals.push(unit(Vec3::from_array(statement.numbers()?)).unwrap_or_default()),
            b"vt" => {
                let texcoord = match statement.quick_numbers() {
                    Some(texcoord) => texcoord,
                    // The second coordinate may be left out: it is 0 then.
                    None if statement.words().count() == 1 => [statement.numbers::<1>()?[0], 0.0],
                    None => statement.numbers()?,
                };
                // OBJ counts from a picture's lower edge.
                self.texcoords.push(Vec2::new(texcoord[0], 1.0 - texcoord[1]));
            }
            b"f" => self.add_face(statement, before)?,
            b"o" => self.changes.push((self.faces.len(), Change::Object(statement.name()))),
            b"g" => self.changes.push((self.faces.len(), Change::Group(statement.name()))),
            b"usemtl" => self.changes.push((self.faces.len(), Change::Material(statement.name()))),
            b"mtllib" => {
                let change = Change::Libraries { line: statement.line(), names: statement.name() };
                self.changes.push((self.faces.len(), change));
            }
            b"l" | b"p" => self.lines_and_points += 1,
            _ => {}
        }
        Ok(())
    }

    fn add_face(&mut self, statement: &Statement, before: Counts) -> Result<(), SceneError> {
        let known = before.and(Counts([self.positions.len(), self.texcoords.len(), self.normals.len()])).0;
        let begin = self.corners.len();
        for word in statement.words() {
            let corner = quick_corner(word, known).map_or_else(|| corner(statement, word, known), Ok)?;
            self.corners.push(corner);
        }
        let corners = self.corners.len() - begin;
        if corners < 3 {
            let corners = count(corners, "corner", "corners");
            return Err(statement.error(format!("this face has {corners}"), "a face needs 3 corners or more"));
        }
        self.faces.push(corners as u32);
        Ok(())
    }
}

/// Reads `v`, `v/vt`, `v//vn` or `v/vt/vn` of positive numbers that exist; `None` for all else.
fn quick_corner(word: &[u8], known: [usize; 3]) -> Option<Corner> {
    let mut corner = [NONE; 3];
    let mut slots = corner.iter_mut().zip(known).enumerate();
    let (mut number, mut digits) = (0_u32, 0);
    for &byte in word.iter().chain(b"/") {
        match byte {
            b'0'..=b'9' => {
                number = number.checked_mul(10)?.checked_add(u32::from(byte - b'0'))?;
                digits += 1;
            }
            b'/' => {
                let (slot, (index, known)) = slots.next()?;
                if digits > 0 {
                    *index = number.checked_sub(1).filter(|index| (*index as usize) < known)?;
                } else if slot != 1 {
                    return None;
                }
                (number, digits) = (0, 0);
            }
            _ => return None,
        }
    }
    Some(corner)
}

/// Reads `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn corner(statement: &Statement, word: &[u8], known: [usize; 3]) -> Result<Corner, SceneError> {
    const NAMES: [(&str, &str); 3] =
        [("vertex", "vertices"), ("texture coordinate", "texture coordinates"), ("normal", "normals")];
    let mut corner = [NONE; 3];
    for (slot, part) in word.split(|&byte| byte == b'/').enumerate() {
        if part.is_empty() && slot > 0 {
            continue;
        }
        let number = str::from_utf8(part).ok().and_then(|part| part.parse::<i64>().ok());
        let (Some(&(one, many)), Some(number)) = (NAMES.get(slot), number) else {
            return Err(statement.error(
                format!("`{}` is not a corner of a face", shown(word)),
                "write corners as whole numbers: v, v/vt, v//vn or v/vt/vn",
            ));
        };
        // Positive numbers count from 1, negative ones back from the latest.
        let known = known[slot];
        let index = if number > 0 { number - 1 } else { known as i64 + number };
        if number == 0 || !(0..known as i64).contains(&index) {
            let known = count(known, one, many);
            return Err(statement.error(
                format!("{one} {number} does not exist: the file has {known} up to this line"),
                "define it before the face, and count from 1, or backwards from -1",
            ));
        }
        corner[slot] = index as u32;
    }
    Ok(corner)
}
