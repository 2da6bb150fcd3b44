//! The data of a PLY file cut into pieces, each of which can be read without the others.

use ply_rs_bw::ply::{ElementDef, Header};

use super::File;
use super::values::{Bytes, Field, Values};
use crate::scene::formats::blocks::blocks;
use crate::scene::{Place, SceneError};

/// Elements of one kind that follow each other.
pub(super) struct Piece<'a> {
    /// Their name.
    pub(super) name: &'a str,
    /// The index of the first among those of its kind.
    pub(super) first: usize,
    pub(super) count: usize,
    pub(super) bytes: &'a [u8],
    /// The number of the first line; 0 where there are none.
    pub(super) line: usize,
}

/// As many elements have some hundred thousand bytes.
const ELEMENTS: usize = 1 << 15;

/// Cuts text, of which every line is an element; `data` begin with the line of number `line`.
pub(super) fn of_text<'a>(
    file: &File<'a>,
    header: &'a Header,
    data: &'a [u8],
    line: usize,
) -> Result<Vec<Piece<'a>>, SceneError> {
    let mut pieces = Vec::new();
    let mut blocks = blocks(data, line).into_iter();
    let mut rest = None;
    for element in header.elements.values() {
        let mut first = 0;
        while first < element.count {
            let block = rest.take().or_else(|| blocks.next()).ok_or_else(|| cut_short(file, element))?;
            let block = match block.split_at(element.count - first) {
                Some((block, others)) => {
                    rest = Some(others);
                    block
                }
                None => block,
            };
            pieces.push(Piece { name: &element.name, first, count: block.lines, bytes: block.bytes, line: block.line });
            first += block.lines;
        }
    }
    Ok(pieces)
}

/// Cuts binary data. Those of elements with lists are as long as these say.
pub(super) fn of_bytes<'a, const BIG: bool>(
    file: &File<'a>,
    header: &'a Header,
    mut data: &'a [u8],
) -> Result<Vec<Piece<'a>>, SceneError> {
    let mut pieces = Vec::new();
    for element in header.elements.values() {
        let fields = Field::all(element);
        let size: Option<usize> = fields.iter().map(Field::size).sum();
        let mut first = 0;
        while first < element.count {
            let count = ELEMENTS.min(element.count - first);
            let length = match size {
                Some(size) => count.checked_mul(size).filter(|length| *length <= data.len()),
                None => length::<BIG>(data, &fields, count),
            };
            let length = length.ok_or_else(|| cut_short(file, element))?;
            let (bytes, rest) = data.split_at(length);
            data = rest;
            pieces.push(Piece { name: &element.name, first, count, bytes, line: 0 });
            first += count;
        }
    }
    Ok(pieces)
}

/// The length in bytes of so many elements that `data` begin with; `None` if they are not all there.
fn length<const BIG: bool>(data: &[u8], fields: &[Field], count: usize) -> Option<usize> {
    let mut values = Bytes::<BIG>::new(data);
    for _ in 0..count {
        fields.iter().try_for_each(|field| field.skip(&mut values))?;
    }
    Some(data.len() - values.0.len())
}

fn cut_short(file: &File, element: &ElementDef) -> SceneError {
    let problem = format!("the file ends before the last of {}", element.count);
    file.error(Place::Part(format!("element `{}`", element.name)), problem, "copy or export the model again")
}
