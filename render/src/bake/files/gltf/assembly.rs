//! Assembles a file: its JSON, old and new binary data, and other chunks of a container.

use std::collections::BTreeMap;

use super::data::Data;
use super::text;
use crate::scene::SceneError;
use crate::scene::formats::gltf::Document;
use crate::scene::formats::gltf::container::Chunks;

/// The place of new binary data.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Home {
    /// Behind the container's chunk, which is buffer 0, or is made.
    Chunk,
    /// Into one more buffer of a container.
    BufferOfContainer,
    /// Into one more buffer of a JSON file.
    Buffer,
}

impl Home {
    pub(super) fn of(document: &Document, chunks: &Chunks, is_container: bool) -> Self {
        let buffers = &document.root.buffers;
        let in_chunk = chunks.binary.is_some() && buffers.first().is_some_and(|buffer| buffer.uri.is_none());
        match is_container {
            true if in_chunk || buffers.is_empty() => Self::Chunk,
            true => Self::BufferOfContainer,
            false => Self::Buffer,
        }
    }

    pub(super) fn data(self, document: &Document, chunks: &Chunks) -> Data {
        match self {
            Self::Chunk => Data::new(document, 0, chunks.binary.map_or(0, <[u8]>::len).next_multiple_of(4)),
            _ => Data::new(document, document.root.buffers.len(), 0),
        }
    }

    /// The file with this JSON and all data.
    pub(super) fn assemble(
        self,
        document: &Document,
        chunks: &Chunks,
        root: String,
        data: &Data,
    ) -> Result<Vec<u8>, SceneError> {
        let (more, length) = data.finish();
        let mut binary = chunks.binary.map(<[u8]>::to_vec);
        let mut root = root;
        if !data.is_empty() {
            let (mut changed, mut new) = (BTreeMap::new(), Vec::new());
            if self == Self::Chunk {
                let buffers = text::elements(text::member(&root, "buffers").unwrap_or("[]"));
                match buffers.first() {
                    Some(old) => drop(changed.insert(0, text::set(old, "byteLength", &length.to_string()))),
                    None => new.push(format!("{{\"byteLength\":{length}}}")),
                }
                let bytes = binary.get_or_insert_default();
                bytes.resize(length - more.len(), 0);
                bytes.extend(more);
            } else {
                new.push(data.as_data_uri());
            }
            root = text::change_member(&root, "buffers", &changed, &new);
        }
        if self == Self::Buffer {
            return Ok(root.into_bytes());
        }
        container(root, binary, &chunks.others).ok_or_else(|| {
            let remedy = "leave the pages beside the file, or split the model";
            document.error("GLB container", "it would be larger than 4 GiB", remedy)
        })
    }
}

/// A GLB container (glTF 2.0, section 4.4); `None` if it would be too large for its lengths of 32 bits.
pub(super) fn container(root: String, binary: Option<Vec<u8>>, others: &[&[u8]]) -> Option<Vec<u8>> {
    let chunk = |kind: &[u8; 4], mut data: Vec<u8>, padding: u8| {
        data.resize(data.len().next_multiple_of(4), padding);
        Some([&u32::try_from(data.len()).ok()?.to_le_bytes(), kind.as_slice(), &data].concat())
    };
    let mut chunks = chunk(b"JSON", root.into_bytes(), b' ')?;
    if let Some(binary) = binary {
        chunks.extend(chunk(b"BIN\0", binary, 0)?);
    }
    others.iter().for_each(|other| chunks.extend(*other));
    let length = u32::try_from(12 + chunks.len()).ok()?;
    Some([b"glTF".as_slice(), &2_u32.to_le_bytes(), &length.to_le_bytes(), &chunks].concat())
}
