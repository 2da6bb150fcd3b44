//! Pictures as files: OpenEXR, PNG, and the lightmap formats of engines.
//!
//! A picture is encoded in memory first and then written atomically, so that a file on disk is always complete.
//!
//! An OpenEXR file also holds the metadata, by pbrt's and the standard's names: `samplesPerPixel` (int),
//! `renderTimeSeconds` (float; 0 if the environment variable `SOURCE_DATE_EPOCH` is set, so that equal renders give
//! equal bytes), `worldToCamera` (m44f for row vectors, left-handed, z into the picture), `integrator` and `software`
//! (string), `seed` (decimal) and `sceneHash` (hexadecimal) as strings.

mod error;
mod exr;
pub(crate) mod false_color;
mod file;
mod hdr;
pub(crate) mod html;
mod ktx2;
mod map;
pub(crate) mod plot;
mod png;
mod tone;

use std::path::Path;

pub use self::error::OutputError;
pub use self::exr::read as read_exr;
pub use self::file::OutputFile;
pub use self::hdr::encode_hdr;
pub use self::ktx2::{Shape, Texture, encode_ktx2, encode_ktx2_texture};
pub use self::map::{EncodedMap, Map};
pub use self::png::encode_rgb8 as encode_png;
pub use self::tone::{ToneCurve, ToneMapping};
use crate::film::Picture;

/// The kinds of file a picture can be written to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR: all channels in full precision, and the metadata.
    Exr,
    /// PNG: the colours alone, through a [`ToneMapping`]; counts of the integrator `heat` in false colours with a
    /// legend.
    Png,
}

impl Format {
    /// The format of `path`'s extension, case-insensitive.
    ///
    /// # Errors
    /// If there is no extension or an unknown one.
    pub fn from_path(path: &Path) -> Result<Self, OutputError> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        match extension.to_ascii_lowercase().as_str() {
            "exr" => Ok(Self::Exr),
            "png" => Ok(Self::Png),
            _ => {
                let problem = match extension.as_ref() {
                    "" => "has no extension to tell the format from".to_owned(),
                    extension => format!("the format .{extension} cannot be written"),
                };
                Err(OutputError::new(path, problem, "end the name in .exr (all channels) or .png (to look at)"))
            }
        }
    }
}

/// Checks before a render that [`write()`] will find a format it knows and a place where it can write.
///
/// # Errors
/// The errors of [`Format::from_path`] and [`OutputFile::check`].
pub fn check(path: &Path) -> Result<(), OutputError> {
    Format::from_path(path)?;
    OutputFile::check(path)?;
    Ok(())
}

/// Writes `picture` in the format of the path's extension; `tone_mapping` matters to PNG alone.
///
/// # Errors
/// The errors of [`check`]; a picture whose channels do not fit its size or cannot be stored; what the operating system
/// reports. After any of them the file is as it was before.
pub fn write(path: &Path, picture: &Picture, tone_mapping: &ToneMapping) -> Result<(), OutputError> {
    let format = Format::from_path(path)?;
    check_shape(path, picture)?;
    let bytes = match format {
        Format::Exr => exr::encode(path, picture)?,
        Format::Png => png::encode(path, picture, tone_mapping)?,
    };
    OutputFile::check(path)?.write(&bytes)
}

/// The bytes of an OpenEXR file of `picture`; `path` is for messages.
///
/// # Errors
/// A picture whose channels do not fit its size or cannot be stored.
pub fn encode_exr(path: &Path, picture: &Picture) -> Result<Vec<u8>, OutputError> {
    check_shape(path, picture)?;
    exr::encode(path, picture)
}

/// Checks that the picture has pixels, and every channel one value for each.
fn check_shape(path: &Path, picture: &Picture) -> Result<(), OutputError> {
    let (width, height) = (picture.width, picture.height);
    if width == 0 || height == 0 {
        return Err(OutputError::new(
            path,
            format!("the picture has no pixels: it is {width} wide and {height} high"),
            "render a picture at least one pixel wide and high",
        ));
    }
    for channel in &picture.channels {
        let count = channel.values.len();
        if count as u64 != u64::from(width) * u64::from(height) {
            return Err(OutputError::new(
                path,
                format!("the channel {:?} has {count} values for {width} x {height} pixels", channel.name),
                "give every channel one value per pixel",
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::film::{Channel, Metadata};

    fn grey() -> Picture {
        let channels = ["R", "G", "B"].map(|name| Channel { name: name.to_owned(), values: vec![0.18; 6] });
        Picture { width: 3, height: 2, channels: channels.into(), metadata: Metadata::default() }
    }

    #[test]
    fn the_extension_chooses_the_format() {
        let folder = tempfile::tempdir().unwrap();
        for (name, magic) in [("a.exr", &[0x76, 0x2f, 0x31, 0x01][..]), ("a.PNG", b"\x89PNG\r\n\x1a\n")] {
            let path = folder.path().join(name);
            check(&path).unwrap();
            write(&path, &grey(), &ToneMapping::default()).unwrap();
            assert!(fs::read(&path).unwrap().starts_with(magic));
        }
    }

    #[test]
    fn other_extensions_are_errors_that_list_the_formats() {
        assert_eq!(
            check(Path::new("a.jpg")).unwrap_err().to_string(),
            "a.jpg: the format .jpg cannot be written\n  help: end the name in .exr (all channels) or .png (to look at)"
        );
        assert!(check(Path::new("picture")).unwrap_err().problem.contains("no extension"));
        assert!(write(Path::new("a.jpg"), &grey(), &ToneMapping::default()).is_err());
    }

    #[test]
    fn a_picture_that_cannot_be_encoded_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let (mut short, mut empty) = (grey(), grey());
        short.channels[1].values.pop();
        empty.width = 0;
        for name in ["a.exr", "a.png"] {
            let path = folder.path().join(name);
            fs::write(&path, "old").unwrap();
            let problem = |picture| write(&path, picture, &ToneMapping::default()).unwrap_err().problem;
            assert_eq!(problem(&short), "the channel \"G\" has 5 values for 3 x 2 pixels");
            assert_eq!(problem(&empty), "the picture has no pixels: it is 0 wide and 2 high");
            assert_eq!(fs::read(&path).unwrap(), b"old");
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }
}
