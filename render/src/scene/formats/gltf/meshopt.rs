//! `EXT_meshopt_compression`: buffer views in the bit streams of Arseny Kapoulkine's meshoptimizer, as the extension's
//! specification defines them (appendices A and B).
//!
//! This decoder is our own, since those on crates.io bind a C++ library or read only an older stream. Output grows as
//! its input is read, so a short file cannot claim much memory.

mod attributes;
mod filter;
mod indices;
mod stream;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use ::gltf::json::{Buffer, Root};
use serde::Deserialize;

use crate::scene::{Place, SceneError};
use attributes::attributes;
use filter::Filter;
use indices::{indices, triangles};

/// The extension's data of a buffer view.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Compression {
    buffer: usize,
    #[serde(default)]
    byte_offset: u64,
    byte_length: u64,
    byte_stride: usize,
    count: usize,
    mode: Mode,
    #[serde(default)]
    filter: Filter,
}

/// The kinds of streams.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

const NAME: &str = "EXT_meshopt_compression";

/// The bytes of all buffer views that are compressed, by their indices.
pub(super) fn decompress(
    path: &Path,
    root: &Root,
    buffers: &[Cow<[u8]>],
) -> Result<BTreeMap<usize, Vec<u8>>, SceneError> {
    let mut decompressed = BTreeMap::new();
    for (index, view) in root.buffer_views.iter().enumerate() {
        let objects = view.extensions.as_ref().map(|extensions| &extensions.others);
        let Some(value) = objects.and_then(|objects| objects.get(NAME)) else { continue };
        let error = |problem: String| {
            let place = Place::Part(format!("bufferView {index}"));
            SceneError::new(path, place, problem, "export the model again, without meshopt compression")
        };
        let it = Compression::deserialize(value).map_err(|cause| error(format!("its {NAME} is wrong: {cause}")))?;
        let buffer = buffers
            .get(it.buffer)
            .ok_or_else(|| error(format!("it refers to buffer {}, which does not exist", it.buffer)))?;
        let start = usize::try_from(it.byte_offset).unwrap_or(usize::MAX);
        let end = start.saturating_add(usize::try_from(it.byte_length).unwrap_or(usize::MAX));
        let data =
            buffer.get(start..end).ok_or_else(|| error(format!("its stream goes beyond buffer {}", it.buffer)))?;
        decompressed.insert(index, decode(&it, data).map_err(error)?);
    }
    Ok(decompressed)
}

/// Whether a buffer is only a place for what compressed views hold.
pub(super) fn is_fallback(buffer: &Buffer) -> bool {
    let objects = buffer.extensions.as_ref().map(|extensions| &extensions.others);
    objects.and_then(|objects| objects.get(NAME)).is_some_and(|it| it["fallback"] == true)
}

/// The bytes of a buffer view; or what is wrong with it.
fn decode(compression: &Compression, data: &[u8]) -> Result<Vec<u8>, String> {
    let &Compression { byte_stride: stride, count, mode, filter, .. } = compression;
    match mode {
        Mode::Attributes => {
            if stride == 0 || stride > 256 || stride % 4 != 0 {
                return Err(format!("its stride is {stride}, which is no multiple of 4 from 4 to 256"));
            }
            let mut bytes = attributes(data, count, stride)?;
            filter.apply(&mut bytes, stride)?;
            Ok(bytes)
        }
        Mode::Triangles => {
            if count % 3 != 0 {
                return Err(format!("its triangles have {count} corners together"));
            }
            Ok(narrow(triangles(data, count / 3)?, index_size(stride)?))
        }
        Mode::Indices => Ok(narrow(indices(data, count)?, index_size(stride)?)),
    }
}

fn index_size(stride: usize) -> Result<usize, String> {
    if matches!(stride, 2 | 4) { Ok(stride) } else { Err(format!("its indices have {stride} bytes")) }
}

/// Indices of two or four bytes.
fn narrow(indices: Vec<u32>, size: usize) -> Vec<u8> {
    indices.into_iter().flat_map(|index| index.to_le_bytes().into_iter().take(size)).collect()
}
