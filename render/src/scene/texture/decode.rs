//! Texture files: PNG, JPEG, WebP, OpenEXR, Radiance HDR, KTX2 and TGA, recognised by their first bytes, TGA by its
//! name.
//!
//! Deviations: numbers of an EXR or HDR picture that are not finite become 0; an EXR's layers beyond the first one with
//! colours are not read. A JPEG's or PNG's colour profile is ignored: colours are sRGB.

use std::io::Cursor;
use std::path::Path;

use image::{ColorType, DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use super::error::{MAX_BYTES, TextureError};
use super::{Texels, Texture};

/// The first bytes of all KTX2 files.
const KTX2: &[u8] = b"\xABKTX 20\xBB\r\n\x1A\n";

/// The picture in `bytes`. `name` is the file's, where it has one.
pub(crate) fn decode(bytes: &[u8], name: Option<&Path>) -> Result<Texture, TextureError> {
    if bytes.starts_with(KTX2) {
        #[cfg(feature = "ktx2")]
        return super::ktx2::decode(bytes);
        #[cfg(not(feature = "ktx2"))]
        return Err(unknown("it is KTX2, which this program was built without".to_owned()));
    }
    let format = format_of(bytes, name)?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.no_limits();
    let mut decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    TextureError::check_size(width, height, decoder.total_bytes())?;
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(MAX_BYTES);
    decoder.set_limits(limits).map_err(damaged)?;
    let channels = usize::from(decoder.color_type().channel_count());
    let image = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    Ok(store(image, channels))
}

fn format_of(bytes: &[u8], name: Option<&Path>) -> Result<ImageFormat, TextureError> {
    let extension = name.and_then(Path::extension).map(|it| it.to_string_lossy().to_ascii_lowercase());
    if extension.as_deref() == Some("tga") {
        return Ok(ImageFormat::Tga);
    }
    const KNOWN: [ImageFormat; 5] =
        [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP, ImageFormat::OpenExr, ImageFormat::Hdr];
    match image::guess_format(bytes) {
        Ok(format) if KNOWN.contains(&format) => Ok(format),
        Ok(format) => Err(unknown(format!("it is {format:?}, which is not read"))),
        Err(_) if bytes.is_empty() => Err(TextureError::wrong("it is empty".to_owned(), "export it again")),
        Err(_) => Err(unknown("it is of a kind that is not read".to_owned())),
    }
}

fn unknown(problem: String) -> TextureError {
    const REMEDY: &str = match cfg!(feature = "ktx2") {
        true => "save it as PNG, JPEG, WebP, EXR, HDR, KTX2 or TGA",
        false => "save it as PNG, JPEG, WebP, EXR, HDR or TGA",
    };
    TextureError { problem, remedy: REMEDY, is_unknown_kind: true }
}

fn damaged(error: ImageError) -> TextureError {
    match error {
        ImageError::Limits(_) => TextureError::wrong(format!("it needs too much memory: {error}"), "make it smaller"),
        error => TextureError::wrong(format!("it is damaged: {error}"), "export it again"),
    }
}

/// The texels as the file has them.
fn store(image: DynamicImage, channels: usize) -> Texture {
    let (width, height) = (image.width(), image.height());
    let (channels, texels) = match image.color() {
        ColorType::L8 => (1, Texels::U8(image.into_luma8().into_raw())),
        ColorType::La8 => (2, Texels::U8(image.into_luma_alpha8().into_raw())),
        ColorType::Rgb8 => (3, Texels::U8(image.into_rgb8().into_raw())),
        ColorType::Rgba8 => (4, Texels::U8(image.into_rgba8().into_raw())),
        ColorType::L16 => (1, Texels::U16(image.into_luma16().into_raw())),
        ColorType::La16 => (2, Texels::U16(image.into_luma_alpha16().into_raw())),
        ColorType::Rgb16 => (3, Texels::U16(image.into_rgb16().into_raw())),
        ColorType::Rgba16 => (4, Texels::U16(image.into_rgba16().into_raw())),
        ColorType::Rgb32F => (3, Texels::finite(image.into_rgb32f().into_raw())),
        _ if channels == 3 => (3, Texels::finite(image.into_rgb32f().into_raw())),
        _ => (4, Texels::finite(image.into_rgba32f().into_raw())),
    };
    Texture::from_texels(width, height, channels, texels)
}

#[cfg(test)]
mod tests {
    use glam::Vec4;
    use image::ImageBuffer;

    use super::super::ColorSpace;
    use super::*;

    fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn rgb() -> DynamicImage {
        DynamicImage::ImageRgb8(ImageBuffer::from_raw(2, 1, vec![255, 0, 51, 0, 102, 255]).unwrap())
    }

    #[test]
    fn every_kind_is_read_and_stays_as_small_as_it_is() {
        for (format, name) in [(ImageFormat::Png, None), (ImageFormat::WebP, None), (ImageFormat::Tga, Some("a.TGA"))] {
            let texture = decode(&encoded(&rgb(), format), name.map(Path::new)).unwrap();
            assert_eq!((texture.size(), texture.channels(), texture.bits()), ((2, 1), 3, 8), "{format:?}");
            assert_eq!(texture.texel_bytes(), rgb().as_bytes(), "{format:?}");
        }
        let jpeg = decode(&encoded(&rgb(), ImageFormat::Jpeg), None).unwrap();
        assert_eq!((jpeg.channels(), jpeg.bytes()), (3, 6));
        let grey = DynamicImage::ImageLuma16(ImageBuffer::from_raw(1, 1, vec![0x8000]).unwrap());
        let grey = decode(&encoded(&grey, ImageFormat::Png), None).unwrap();
        assert_eq!((grey.channels(), grey.bits()), (1, 16));
        let float = DynamicImage::ImageRgb32F(ImageBuffer::from_raw(1, 1, vec![4.0, 0.5, f32::NAN]).unwrap());
        let exr = decode(&encoded(&float, ImageFormat::OpenExr), None).unwrap();
        assert_eq!((exr.channels(), exr.bits()), (3, 32));
        assert_eq!(exr.mean_in(ColorSpace::Srgb), Vec4::new(4.0, 0.5, 0.0, 1.0));
        let bright = DynamicImage::ImageRgb32F(ImageBuffer::from_raw(1, 1, vec![4.0, 0.5, 0.25]).unwrap());
        let hdr = decode(&encoded(&bright, ImageFormat::Hdr), None).unwrap();
        assert!((hdr.mean() - Vec4::new(4.0, 0.5, 0.25, 1.0)).abs().max_element() < 0.02, "{}", hdr.mean());
    }

    #[test]
    fn what_is_cut_short_or_too_large_or_empty_is_refused() {
        let png = encoded(&rgb(), ImageFormat::Png);
        let problem = |bytes: &[u8]| decode(bytes, None).unwrap_err();
        for end in [20, 40, png.len() - 20] {
            assert!(problem(&png[..end]).problem.contains("damaged"), "{end}");
        }
        assert_eq!(problem(&[]).problem, "it is empty");
        let unknown = problem(b"GIF89a");
        assert!(unknown.is_unknown_kind && unknown.problem.contains("Gif"), "{unknown:?}");
        assert!(problem(b"some text").is_unknown_kind);
        // The size of a PNG stands in its bytes 16 to 23, and their checksum in 29 to 32.
        let sized = |width: u32, height: u32| {
            let mut bytes = png.clone();
            bytes[16..20].copy_from_slice(&width.to_be_bytes());
            bytes[20..24].copy_from_slice(&height.to_be_bytes());
            let crc = bytes[12..29].iter().fold(u32::MAX, |crc, &byte| {
                (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 * (crc & 1)))
            });
            bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
            bytes
        };
        let huge = problem(&sized(60_000, 60_000));
        assert!(huge.problem.contains("60000 x 60000 pixels take"), "{huge:?}");
        assert!(problem(&sized(70_000, 1)).problem.contains("70000 x 1"));
        assert!(!problem(&sized(0, 1)).is_unknown_kind);
    }
}
