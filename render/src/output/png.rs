//! PNG for display: 8 bits per channel, sRGB, marked as such by an `sRGB` chunk; with alpha if the picture has it.

use std::path::Path;

use png::{BitDepth, ColorType, Encoder, EncodingError, SrgbRenderingIntent};

use super::{OutputError, ToneMapping, false_color};
use crate::film::Picture;

/// The bytes of a PNG of the channels `R`, `G` and `B`; `path` is for messages.
pub(super) fn encode(path: &Path, picture: &Picture, tone_mapping: &ToneMapping) -> Result<Vec<u8>, OutputError> {
    let [red, green, blue] = match ["R", "G", "B"].map(|name| picture.channel(name)) {
        [Some(red), Some(green), Some(blue)] => [&red.values, &green.values, &blue.values],
        _ => {
            let problem = "the picture lacks one of the channels R, G and B";
            return Err(OutputError::new(path, problem, "write it to an .exr file, which takes any channels"));
        }
    };
    let pixels = red.iter().zip(green).zip(blue);
    if picture.metadata.integrator == "heat" {
        let (height, codes) = false_color::encode(red, picture.width);
        return encode_rgb8(path, picture.width, height, &codes);
    }
    let colors = pixels.map(|((&r, &g), &b)| [r, g, b]);
    let (color, codes): (_, Vec<u8>) = match picture.channel("A") {
        None => (ColorType::Rgb, colors.flat_map(|color| tone_mapping.to_srgb8(color)).collect()),
        Some(alpha) => {
            // Colours are multiplied by alpha, and PNG's are not.
            let pixel = |(color, &alpha): ([f32; 3], &f32)| {
                let whole = if alpha > 0.0 { color.map(|value| value / alpha) } else { [0.0; 3] };
                let [r, g, b] = tone_mapping.to_srgb8(whole);
                [r, g, b, (255.0 * alpha + 0.5) as u8]
            };
            (ColorType::Rgba, colors.zip(&alpha.values).flat_map(pixel).collect())
        }
    };
    encode_codes(path, (picture.width, picture.height), color, &codes)
}

/// The bytes of a PNG whose pixels have these sRGB codes, three each, row by row from the top; `path` is for messages.
///
/// # Errors
/// If the picture has no pixels, or not as many codes as its size says.
pub fn encode_rgb8(path: &Path, width: u32, height: u32, codes: &[u8]) -> Result<Vec<u8>, OutputError> {
    encode_codes(path, (width, height), ColorType::Rgb, codes)
}

fn encode_codes(path: &Path, size: (u32, u32), color: ColorType, codes: &[u8]) -> Result<Vec<u8>, OutputError> {
    compress(size, color, codes).map_err(|error| {
        OutputError::new(path, format!("PNG cannot hold the picture: {error}"), "write it to an .exr file")
    })
}

fn compress((width, height): (u32, u32), color: ColorType, codes: &[u8]) -> Result<Vec<u8>, EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(codes)?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Channel, Metadata};
    use crate::output::ToneCurve;

    fn picture(rgb: &[[f32; 3]], width: u32) -> Picture {
        let channels = ["R", "G", "B"].into_iter().enumerate();
        let channel = |(i, name): (usize, &str)| Channel {
            name: name.to_owned(),
            values: rgb.iter().map(|pixel| pixel[i]).collect(),
        };
        let height = rgb.len() as u32 / width;
        Picture { width, height, channels: channels.map(channel).collect(), metadata: Metadata::default() }
    }

    #[test]
    fn pixels_decode_to_their_codes_row_by_row() {
        let rgb = [
            [0.18, 1.0, 0.0],
            [0.5, 0.25, 0.125],
            [f32::NAN, f32::INFINITY, -1.0],
            [1.0; 3],
            [0.0; 3],
            [2.0, 0.0, 0.18],
        ];
        let bytes = encode(Path::new("a.png"), &picture(&rgb, 3), &ToneMapping::default()).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        assert_eq!(reader.info().srgb, Some(SrgbRenderingIntent::Perceptual));
        let mut codes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut codes).unwrap();
        assert_eq!((info.width, info.height, info.color_type), (3, 2, ColorType::Rgb));
        assert_eq!(
            codes,
            [118, 255, 0, 188, 137, 99, 0, 255, 0, 255, 255, 255, 0, 0, 0, 255, 0, 118],
            "the sRGB codes of 0.5, 0.25 and 0.125 are 188, 137 and 99"
        );
    }

    #[test]
    fn exposure_and_curve_are_applied() {
        let mapping = ToneMapping { exposure: 1.0, curve: ToneCurve::Reinhard };
        let bytes = encode(Path::new("a.png"), &picture(&[[0.5; 3]], 1), &mapping).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut codes = vec![0; 3];
        reader.next_frame(&mut codes).unwrap();
        assert_eq!(codes, [188; 3], "0.5 brightened to 1 and halved to 0.5");
    }

    #[test]
    fn colours_are_divided_by_alpha() {
        let mut half = picture(&[[0.25; 3], [0.0; 3], [0.5; 3]], 3);
        half.channels.push(Channel { name: "A".to_owned(), values: vec![0.5, 0.0, 1.0] });
        let bytes = encode(Path::new("a.png"), &half, &ToneMapping::default()).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut codes = vec![0; reader.output_buffer_size().unwrap()];
        assert_eq!(reader.next_frame(&mut codes).unwrap().color_type, ColorType::Rgba);
        assert_eq!(codes, [188, 188, 188, 128, 0, 0, 0, 0, 188, 188, 188, 255]);
    }

    #[test]
    fn a_picture_without_colours_is_an_error() {
        let mut grey = picture(&[[1.0; 3]], 1);
        grey.channels.pop();
        let error = encode(Path::new("a.png"), &grey, &ToneMapping::default()).unwrap_err();
        assert!(error.problem.contains("lacks one of the channels R, G and B"));
    }
}
