//! The sources of a glTF file's bytes: the chunks of a GLB container, files beside it, and data URIs.

use std::borrow::Cow;
use std::path::Path;

use ::gltf::json::{Buffer, Root};
use base64::Engine;
use base64::alphabet;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::meshopt;
use crate::scene::{Files, Place, SceneError};

/// Many exporters leave out base64's padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The chunks of a GLB container.
pub(crate) struct Chunks<'a> {
    pub(crate) json: &'a [u8],
    pub(crate) binary: Option<&'a [u8]>,
    /// All other chunks, each with its length and type.
    pub(crate) others: Vec<&'a [u8]>,
}

/// Splits a GLB container: magic, version and length, then chunks of length, type and data (glTF 2.0, section 4.4).
pub(super) fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<Chunks<'a>, SceneError> {
    let error = |problem: String| {
        SceneError::new(path, Place::Part("GLB container".to_owned()), problem, "copy or export the model again")
    };
    let word = |at: usize| {
        let word = bytes.get(at..at + 4).and_then(|word| <[u8; 4]>::try_from(word).ok());
        word.ok_or_else(|| error(format!("the file is cut short: it ends after {} bytes", bytes.len())))
    };
    let version = u32::from_le_bytes(word(4)?);
    if version != 2 {
        return Err(error(format!("its version is {version}, which is not 2")));
    }
    let length = u32::from_le_bytes(word(8)?) as usize;
    if length > bytes.len() {
        return Err(error(format!("the file is cut short: it announces {length} bytes and has {}", bytes.len())));
    }
    let mut chunks = Chunks { json: &[], binary: None, others: Vec::new() };
    let mut start = 12;
    while start < length {
        let (size, kind) = (u32::from_le_bytes(word(start)?) as usize, word(start + 4)?);
        let data = start + 8;
        let chunk = bytes[..length].get(data..data + size);
        let chunk = chunk.ok_or_else(|| error(format!("the chunk at byte {start} goes beyond the end of the file")))?;
        match (&kind, start) {
            (b"JSON", 12) => chunks.json = chunk,
            (_, 12) => return Err(error("its first chunk is not JSON".to_owned())),
            (b"BIN\0", _) if chunks.binary.is_none() => chunks.binary = Some(chunk),
            _ => chunks.others.push(&bytes[start..data + size]),
        }
        start = data + size;
    }
    if chunks.json.is_empty() { Err(error("it has no JSON chunk".to_owned())) } else { Ok(chunks) }
}

/// Loads all buffers; `binary` is the container's, if any.
pub(super) fn buffers<'a>(
    files: &dyn Files,
    path: &Path,
    root: &Root,
    binary: Option<&'a [u8]>,
) -> Result<Vec<Cow<'a, [u8]>>, SceneError> {
    let buffers = root.buffers.iter().enumerate();
    buffers.map(|(index, buffer)| load(files, path, buffer, index, binary.filter(|_| index == 0))).collect()
}

fn load<'a>(
    files: &dyn Files,
    path: &Path,
    buffer: &Buffer,
    index: usize,
    binary: Option<&'a [u8]>,
) -> Result<Cow<'a, [u8]>, SceneError> {
    let place = format!("buffer {index}");
    let error = |problem: &str, remedy: &str| SceneError::new(path, Place::Part(place.clone()), problem, remedy);
    let data = match (buffer.uri.as_deref(), binary) {
        (None, Some(binary)) => Cow::Borrowed(binary),
        (None, None) if meshopt::is_fallback(buffer) => return Ok(Cow::Borrowed(&[])),
        (None, None) => return Err(error("it has no data", "give it a `uri`, or use a GLB file with a binary chunk")),
        (Some(uri), _) => Cow::Owned(fetch(files, path, uri, &place)?),
    };
    let announced = buffer.byte_length.0;
    if (data.len() as u64) < announced {
        let problem = format!("it has {} bytes, and should have {announced}", data.len());
        return Err(error(&problem, "copy or export the model again, with the files beside it"));
    }
    Ok(data)
}

/// The bytes that `uri` stands for: its own, or those of a file beside the model at `path`. `place` is what names it.
pub(super) fn fetch(files: &dyn Files, path: &Path, uri: &str, place: &str) -> Result<Vec<u8>, SceneError> {
    let error = |problem: &str, remedy: &str| SceneError::new(path, Place::Part(place.to_owned()), problem, remedy);
    match uri.strip_prefix("data:") {
        Some(data) => {
            let data = data.split_once(',').filter(|(kind, _)| kind.ends_with(";base64")).map(|(_, data)| data);
            let data = data.ok_or_else(|| error("its data URI is not base64", "write `data:;base64,` and the data"))?;
            BASE64.decode(data).map_err(|cause| {
                error(&format!("its base64 is wrong: {}", lower_first(&cause.to_string())), "export the model again")
            })
        }
        None => {
            let name = relative(uri).ok_or_else(|| {
                error(&format!("`{uri}` is not a relative path"), "put the file beside the model and name it")
            })?;
            let file = path.parent().unwrap_or(Path::new("")).join(name);
            files.read(&file).map(Cow::into_owned).map_err(|cause| SceneError::unreadable(&file, &cause))
        }
    }
}

/// The relative path that `uri` stands for, or `None` for an address, an absolute path and wrong percent-encoding.
fn relative(uri: &str) -> Option<String> {
    let scheme = uri.split(['/', '?', '#']).next().is_some_and(|start| start.contains(':'));
    if scheme || uri.is_empty() {
        return None;
    }
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        rest = after;
        if first == b'%' {
            let (code, after) = rest.split_at_checked(2)?;
            let digit = |byte: u8| char::from(byte).to_digit(16);
            bytes.push((16 * digit(code[0])? + digit(code[1])?) as u8);
            rest = after;
        } else {
            bytes.push(first);
        }
    }
    let name = String::from_utf8(bytes).ok()?;
    (!name.starts_with(['/', '\\']) && !name.contains('\0')).then_some(name)
}

fn lower_first(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_lowercase().chain(letters).collect()).unwrap_or_default()
}
