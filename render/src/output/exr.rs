//! OpenEXR: every channel of a picture in 32-bit floats, compressed without loss by ZIP in blocks of 16 lines.
//!
//! Equal pictures give equal bytes: blocks are compressed on all threads, but stand in the file in the order of lines.
//!
//! Source: "OpenEXR File Layout" of the OpenEXR documentation, version 3.

mod attributes;

use std::fs;
use std::io::Cursor;
use std::path::Path;

use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    AnyChannel, AnyChannels, ChannelDescription, Encoding, Error, FlatSamples, Image, Layer, MetaData,
    ReadChannels as _, ReadLayers as _, SmallVec, Text, Vec2, WritableImage as _,
};

use super::OutputError;
use crate::film::{Channel, Picture};

/// The longest name of a channel that the format can hold.
const MAX_NAME: usize = 255;

/// The greatest number of values in a file that [`read`] accepts: 8 GiB, or 8 channels of 16384 x 16384 pixels. It
/// keeps a broken header from asking for more memory than there is.
const MAX_VALUES: u128 = 1 << 31;

/// The bytes of an OpenEXR file; `path` is for messages. The picture has one value per channel and pixel.
pub(super) fn encode(path: &Path, picture: &Picture) -> Result<Vec<u8>, OutputError> {
    let size = Vec2(picture.width as usize, picture.height as usize);
    let mut channels = SmallVec::new();
    for (index, Channel { name, values }) in picture.channels.iter().enumerate() {
        if picture.channels[..index].iter().any(|other| other.name == *name) {
            let problem = format!("two channels of the picture are called {name:?}");
            return Err(OutputError::new(path, problem, "give every channel a name of its own"));
        }
        let name = text(path, name)?;
        channels.push(AnyChannel::new(name, FlatSamples::F32(values.clone())));
    }
    if channels.is_empty() {
        return Err(OutputError::new(path, "the picture has no channels", "give it the channels R, G and B"));
    }

    let attributes = attributes::from_metadata(path, &picture.metadata)?;
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let mut image = Image::from_layer(layer);
    // Rec. 709's primaries and D65, which are sRGB's.
    image.attributes.chromaticities = Some(Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.30, 0.60),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    });

    let mut bytes = Vec::new();
    image.write().to_buffered(Cursor::new(&mut bytes)).map_err(|error| {
        OutputError::new(path, format!("OpenEXR cannot hold the picture: {error}"), "render a smaller picture")
    })?;
    attributes::sort(&mut bytes);
    Ok(bytes)
}

/// A name as the format stores it.
fn text(path: &Path, name: &str) -> Result<Text, OutputError> {
    let printable = name.bytes().all(|byte| (b' '..=b'~').contains(&byte));
    match Text::new_or_none(name) {
        Some(text) if printable && !name.is_empty() && name.len() <= MAX_NAME => Ok(text),
        _ => Err(OutputError::new(
            path,
            format!("OpenEXR cannot hold the name {name:?}"),
            format!("give a name of 1 to {MAX_NAME} ASCII characters"),
        )),
    }
}

/// Reads a picture: all channels of the first part with pixels in its largest resolution, in the order of the file,
/// which is by name. Half floats and integers become 32-bit floats; a data window smaller than the display window is
/// the whole picture. Metadata that the file lacks are as in `Metadata::default()`.
///
/// # Errors
/// If the file cannot be read, is not an OpenEXR file or is damaged; if it has subsampled or deep channels or more
/// than 2³¹ values; if an attribute that holds metadata is of the wrong type.
pub fn read(path: &Path) -> Result<Picture, OutputError> {
    let bytes = fs::read(path).map_err(|error| OutputError::unreadable(path, &error))?;
    let damaged = |error: Error| match error {
        Error::Io(error) => OutputError::unreadable(path, &error),
        error => {
            let problem = format!("is not a complete OpenEXR file: {error}");
            OutputError::new(path, problem, "check that it is an OpenEXR image, and copy it again")
        }
    };

    let headers = MetaData::read_from_buffered(bytes.as_slice(), false).map_err(damaged)?.headers;
    for header in &headers {
        let subsampled = |channel: &ChannelDescription| channel.sampling != Vec2(1, 1);
        if header.deep || header.channels.list.iter().any(subsampled) {
            let problem = "has deep or subsampled channels";
            return Err(OutputError::new(path, problem, "convert it to plain channels of full resolution"));
        }
        let Vec2(width, height) = header.layer_size;
        if (width as u128) * (height as u128) * (header.channels.list.len() as u128) > MAX_VALUES {
            let problem = format!("is too large: {} channels of {width} x {height}", header.channels.list.len());
            return Err(OutputError::new(path, problem, format!("give a picture of at most {MAX_VALUES} values")));
        }
    }

    let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let layer = reader.all_attributes().from_buffered(Cursor::new(&bytes)).map_err(damaged)?.layer_data;
    let channels = layer.channel_data.list.into_iter().map(|channel| Channel {
        name: channel.name.to_string(),
        values: match channel.sample_data {
            FlatSamples::F32(values) => values,
            samples => samples.values_as_f32().collect(),
        },
    });
    let Vec2(width, height) = layer.size;
    Ok(Picture {
        width: width as u32,
        height: height as u32,
        channels: channels.collect(),
        metadata: attributes::to_metadata(path, &layer.attributes)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Metadata;
    use crate::output::{ToneMapping, write};

    const NAMES: [&str; 9] = ["R", "G", "B", "Albedo.R", "N.X", "Ns.X", "P.X", "Variance.R", "u"];

    /// A picture whose every value is its own.
    fn picture(width: u32, height: u32) -> Picture {
        let channels = NAMES.iter().enumerate().map(|(i, name)| Channel {
            name: (*name).to_owned(),
            values: (0..width * height).map(|pixel| i as f32 + pixel as f32 / 1024.0 - 3.0).collect(),
        });
        let metadata = Metadata {
            samples_per_pixel: 64,
            render_time_seconds: 1.25,
            world_to_camera: Some(core::array::from_fn(|i| core::array::from_fn(|j| (1 + 4 * i + j) as f32))),
            seed: u64::MAX,
            scene_hash: 0x0123_4567_89ab_cdef,
            integrator: "path".to_owned(),
            attributes: [("cryptomatte/0123456/name".to_owned(), "a \u{e9}".escape_unicode().to_string())].into(),
        };
        Picture { width, height, channels: channels.collect(), metadata }
    }

    fn encoded(picture: &Picture) -> Vec<u8> {
        encode(Path::new("a.exr"), picture).unwrap()
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        for (width, height) in [(1, 1), (3, 2), (1, 17), (33, 50)] {
            let mut written = picture(width, height);
            write(&path, &written, &ToneMapping::default()).unwrap();
            let read = read(&path).unwrap();
            written.channels.sort_by(|a, b| a.name.cmp(&b.name));
            assert_eq!(read, written);
        }
    }

    #[test]
    fn every_float_keeps_its_bits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let values = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, f32::MIN_POSITIVE / 2.0, f32::MAX];
        let mut picture = picture(3, 2);
        picture.channels = vec![Channel { name: "P.X".to_owned(), values: values.to_vec() }];
        write(&path, &picture, &ToneMapping::default()).unwrap();
        let read = read(&path).unwrap();
        assert_eq!(read.channels[0].values.iter().map(|v| v.to_bits()).collect::<Vec<_>>(), values.map(f32::to_bits));
    }

    #[test]
    fn equal_pictures_give_equal_bytes() {
        // Enough blocks for their compression to finish out of order.
        let picture = picture(64, 500);
        let bytes = encoded(&picture);
        for _ in 0..8 {
            assert!(encoded(&picture) == bytes);
        }
        let mut later = picture.clone();
        later.metadata.render_time_seconds += 1.0;
        let differences = encoded(&later).iter().zip(&bytes).filter(|(a, b)| a != b).count();
        assert!((1..=4).contains(&differences), "only the float of the time differs");
    }

    #[test]
    fn the_header_is_what_the_standard_asks_for() {
        let headers = MetaData::read_from_buffered(encoded(&picture(3, 2)).as_slice(), true).unwrap().headers;
        let [header] = headers.as_slice() else { panic!("one part") };
        assert_eq!(header.compression, exr::prelude::Compression::ZIP16);
        assert_eq!(header.channels.list.len(), NAMES.len());
        assert!(header.channels.list.iter().all(|c| c.sample_type == exr::prelude::SampleType::F32));
        assert_eq!(header.shared_attributes.chromaticities.unwrap().white, Vec2(0.3127, 0.329));
        let software = header.own_attributes.software_name.as_ref().unwrap().to_string();
        assert_eq!(software, format!("halfdome {}", env!("CARGO_PKG_VERSION")));
        let hash = header.own_attributes.other.get(b"sceneHash".as_slice()).unwrap();
        assert_eq!(hash.to_text().unwrap().to_string(), "0123456789abcdef");
        let seed = header.own_attributes.other.get(b"seed".as_slice()).unwrap();
        assert_eq!(seed.to_text().unwrap().to_string(), "18446744073709551615");
    }

    #[test]
    fn other_sample_types_become_floats() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let half = AnyChannel::new("R", FlatSamples::F16(vec![exr::prelude::f16::from_f32(0.5); 2]));
        let integer = AnyChannel::new("id", FlatSamples::U32(vec![7; 2]));
        let channels = AnyChannels::sort([half, integer].into_iter().collect());
        Image::from_channels((2, 1), channels).write().to_file(&path).unwrap();
        let picture = read(&path).unwrap();
        assert_eq!(picture.channel("R").unwrap().values, [0.5; 2]);
        assert_eq!(picture.channel("id").unwrap().values, [7.0; 2]);
        assert_eq!(picture.metadata, Metadata::default());
    }

    #[test]
    fn pictures_that_cannot_be_stored_are_errors() {
        let problem = |change: fn(&mut Picture)| {
            let mut picture = picture(3, 2);
            change(&mut picture);
            encode(Path::new("a.exr"), &picture).unwrap_err().problem
        };
        assert_eq!(problem(|p| p.channels[1].name = "R".into()), "two channels of the picture are called \"R\"");
        for name in ["", "π", "a\0b"] {
            let mut picture = picture(3, 2);
            picture.channels[0].name = name.to_owned();
            let error = encode(Path::new("a.exr"), &picture).unwrap_err();
            assert_eq!(error.problem, format!("OpenEXR cannot hold the name {name:?}"));
        }
        assert_eq!(problem(|p| p.channels.clear()), "the picture has no channels");
        assert!(problem(|p| p.metadata.samples_per_pixel = u32::MAX).contains("4294967295 samples per pixel"));
        assert!(problem(|p| p.metadata.integrator = "\n".into()).contains("cannot hold the name"));
    }

    #[test]
    fn files_that_cannot_be_read_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        assert_eq!(
            read(&path).unwrap_err().to_string(),
            format!("{}: no such file\n  help: check the path", path.display())
        );
        assert_eq!(read(folder.path()).unwrap_err().problem, "is a folder");
        let bytes = encoded(&picture(33, 50));
        for length in [0, 3, 8, 100, bytes.len() / 2, bytes.len() - 1] {
            fs::write(&path, &bytes[..length]).unwrap();
            let error = read(&path).unwrap_err();
            assert!(error.problem.starts_with("is not a complete OpenEXR file: "), "{length}: {error}");
        }
    }

    #[test]
    fn no_damaged_byte_makes_the_reader_panic() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let bytes = encoded(&picture(2, 20));
        let mut refused = 0;
        for i in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[i] ^= 0xff;
            fs::write(&path, &damaged).unwrap();
            refused += u32::from(read(&path).is_err());
        }
        assert!(refused > 200, "damage is noticed: {refused}");
    }

    #[test]
    fn a_header_that_asks_for_too_much_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut bytes = encoded(&picture(3, 2));
        // The window's right edge, its third 32-bit number, moves from 2 to 2²⁸.
        let name = b"dataWindow\0box2i\0";
        let start = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4;
        assert_eq!(bytes[start + 8..][..4], 2_i32.to_le_bytes());
        bytes[start + 8..][..4].copy_from_slice(&(1_i32 << 28).to_le_bytes());
        fs::write(&path, &bytes).unwrap();
        let problem = read(&path).unwrap_err().problem;
        assert_eq!(problem, "is too large: 9 channels of 268435457 x 2");
    }
}
