//! Loads a model file of any known format, with the checks common to all formats.
//!
//! The extension names the format; the file's first bytes must agree with it.

use std::path::Path;

use halfdome_kernel::MAX_COORDINATE;

use super::{gltf, obj, pbrt, ply};
use crate::scene::files::Recorded;
use crate::scene::{Disk, Files, LoadOptions, Place, Scene, SceneError};

/// The greatest length of a file in bytes. No format spends less than a byte on an index or a vertex, so a file of this
/// length has fewer of them than a `u32` counts.
const MAX_LENGTH: u64 = u32::MAX as u64;

/// Some editors on Windows begin UTF-8 text with it.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// First bytes that give away what a file is. Text that matches none is of unknown kind.
const SIGNATURES: [(&[u8], &str); 16] = [
    (b"glTF", "binary glTF (GLB)"),
    (b"ply\n", "a PLY model"),
    (b"ply\r", "a PLY model"),
    (b"{", "JSON text"),
    (b"<", "HTML or XML text"),
    (b"\x89PNG", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"GIF8", "a GIF image"),
    (b"\x76\x2f\x31\x01", "an OpenEXR image"),
    (b"%PDF", "a PDF document"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"\x28\xb5\x2f\xfd", "a zstd archive"),
    (b"BLENDER", "a Blender project"),
    (b"Kaydara FBX", "an FBX model"),
    (b"solid ", "an STL model"),
];

/// Extensions of what programs write that make models, and is not read.
const OTHERS: [(&str, &str); 15] = [
    ("3ds", "a 3D Studio model"),
    ("abc", "an Alembic scene"),
    ("blend", "a Blender project"),
    ("c4d", "a Cinema 4D project"),
    ("dae", "a COLLADA model"),
    ("fbx", "an FBX model"),
    ("ma", "a Maya project"),
    ("max", "a 3ds Max project"),
    ("mb", "a Maya project"),
    ("skp", "a SketchUp model"),
    ("stl", "an STL model"),
    ("usd", "a USD scene"),
    ("usda", "a USD scene"),
    ("usdc", "a USD scene"),
    ("usdz", "a USD scene"),
];

/// A model format that [`load`] reads.
#[derive(Clone, Copy)]
enum Format {
    Obj,
    Ply,
    Gltf,
    Glb,
    Pbrt,
}

/// Reads the model at `path`: Wavefront OBJ with its MTL files (`.obj`), PLY (`.ply`), glTF 2.0 (`.gltf`, `.glb`),
/// or pbrt-v4 (`.pbrt`).
///
/// Missing or unsupported content, such as textures, gives a line in [`Scene::warnings`]. Degenerate triangles stay in
/// the meshes.
///
/// # Errors
///
/// A [`SceneError`] if the extension is another one, if the file or one that it needs cannot be read, if it breaks the
/// rules of its format, has no triangles, or has a coordinate beyond [`MAX_COORDINATE`].
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    load_with(path, &LoadOptions::default())
}

/// Reads the model at `path` as [`load`] does, in the way that `options` say.
///
/// # Errors
/// The errors of [`load`], and if the model has no animation with a name of the moment's.
pub fn load_with(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let whole = |problem: &str, remedy: &str| SceneError::new(path, Place::File, problem, remedy);
    let metadata = std::fs::metadata(path).map_err(|error| SceneError::unreadable(path, &error))?;
    if metadata.is_dir() {
        return Err(whole("this is a folder", "name a model file in it"));
    }
    let format = Format::of(path)?;
    if metadata.len() > MAX_LENGTH {
        return Err(whole("this file is larger than 4 GiB", "split the model into smaller files"));
    }
    read(&Disk, path, format, options)
}

/// Reads the model at `path` as [`load`] does, from `files`.
///
/// # Errors
/// The errors of [`load`].
pub fn load_from(files: &dyn Files, path: &Path) -> Result<Scene, SceneError> {
    read(files, path, Format::of(path)?, &LoadOptions::default())
}

fn read(files: &dyn Files, path: &Path, format: Format, options: &LoadOptions) -> Result<Scene, SceneError> {
    let files = Recorded::new(files);
    let bytes = files.read(path).map_err(|error| SceneError::unreadable(path, &error))?;
    let mut scene = parse(&files, path, format, &bytes, options)?;
    drop(bytes);
    scene.files = files.into_paths();
    Ok(scene)
}

/// Reads the model in `bytes`, which `path` holds.
fn parse(
    files: &dyn Files,
    path: &Path,
    format: Format,
    bytes: &[u8],
    options: &LoadOptions,
) -> Result<Scene, SceneError> {
    let whole = |problem: &str, remedy: &str| SceneError::new(path, Place::File, problem, remedy);
    let text = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    if text.iter().all(u8::is_ascii_whitespace) {
        return Err(whole("the file is empty", "export the model again"));
    }
    format.check_content(path, text)?;
    if let Some(name) = options.camera.filter(|_| !matches!(format, Format::Gltf | Format::Glb)) {
        let problem = format!("`model_camera` is {name:?}, but this format has no named cameras");
        return Err(whole(&problem, "leave `model_camera` out, or export the model as glTF"));
    }
    let scene = match format {
        Format::Obj => obj::read(files, path, text, options.watch),
        Format::Ply => ply::read(path, text, options.watch),
        Format::Gltf => gltf::read_json(files, path, text, options),
        Format::Glb => gltf::read_binary(files, path, text, options),
        Format::Pbrt => pbrt::read(files, path, text, options.sharing),
    }?;
    if scene.triangle_count() == 0 {
        return Err(whole("the model has no triangles", "export it with its surfaces, as triangles or polygons"));
    }
    check_extent(path, &scene)?;
    Ok(scene)
}

impl Format {
    fn of(path: &Path) -> Result<Self, SceneError> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("obj") => Ok(Self::Obj),
            Some("ply") => Ok(Self::Ply),
            Some("gltf") => Ok(Self::Gltf),
            Some("glb") => Ok(Self::Glb),
            Some("pbrt") => Ok(Self::Pbrt),
            other => {
                let known = other.and_then(|other| OTHERS.iter().find(|(extension, _)| *extension == other));
                let problem = match (other, known) {
                    (Some(other), Some((_, what))) => format!("this is {what} (`.{other}`), which cannot be read"),
                    (Some(other), None) => format!("`.{other}` is not a model format that can be read"),
                    (None, _) => "the name has no extension that would tell the format".to_owned(),
                };
                let remedy = match known {
                    Some(_) => "export it as glTF (.glb), which keeps most, or name a .gltf, .obj, .pbrt or .ply file",
                    None => "name a .glb, .gltf, .obj, .pbrt or .ply file",
                };
                Err(SceneError::new(path, Place::File, problem, remedy))
            }
        }
    }

    /// Refuses a file that is plainly something else than its extension says.
    fn check_content(self, path: &Path, bytes: &[u8]) -> Result<(), SceneError> {
        let start = &bytes[bytes.iter().position(|byte| !byte.is_ascii_whitespace()).unwrap_or(0)..];
        let found = SIGNATURES.iter().find(|(signature, _)| start.starts_with(signature));
        let (expected, signature): (&str, Option<&[u8]>) = match self {
            Self::Obj => ("an OBJ model", None),
            Self::Ply => ("a PLY model", Some(b"ply")),
            Self::Gltf => ("glTF, which is JSON text", Some(b"{")),
            Self::Glb => ("binary glTF (GLB)", Some(b"glTF")),
            Self::Pbrt => ("a pbrt scene", None),
        };
        let problem = match (found, signature) {
            (_, Some(signature)) if start.starts_with(signature) => return Ok(()),
            (None, None) => return Ok(()),
            (Some((_, what)), _) => format!("this is {what}, not {expected}"),
            (None, Some(signature)) => {
                format!("this is not {expected}: it does not begin with `{}`", String::from_utf8_lossy(signature))
            }
        };
        Err(SceneError::new(
            path,
            Place::File,
            problem,
            "give the file the extension of what it is, or name another file",
        ))
    }
}

fn check_extent(path: &Path, scene: &Scene) -> Result<(), SceneError> {
    for (index, mesh) in scene.meshes.iter().enumerate() {
        if let Some(position) = mesh.positions.iter().find(|position| position.abs().max_element() > MAX_COORDINATE) {
            let name = if mesh.name.is_empty() { String::new() } else { format!(" ({:?})", mesh.name) };
            return Err(SceneError::new(
                path,
                Place::Part(format!("mesh {index}{name}")),
                format!("the position ({:?}, {:?}, {:?}) is too far away", position.x, position.y, position.z),
                format!("keep coordinates between -{MAX_COORDINATE:e} and {MAX_COORDINATE:e}"),
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
