//! Radiance pictures (`.hdr`): three mantissas of 8 bits that share an exponent (Ward 1991, "Real Pixels").
//!
//! Deviation: mantissas are rounded to the nearest, not down, for today's readers take them as they are, where
//! Radiance's own adds a half. So the error is at most 1/256 of a texel's greatest channel.

use std::path::Path;

use glam::Vec3;
use image::Rgb;
use image::codecs::hdr::HdrEncoder;

use super::{EncodedMap, Map, OutputError};

/// The greatest number that is written; the format has room for a little more.
const MAX: f32 = 8.0e37;
/// Darker values are black.
const MIN: f32 = 1.0e-36;

/// The bytes of a Radiance picture; `path` is for messages.
///
/// # Errors
/// If the map has not as many texels as its size says.
pub fn encode_hdr(path: &Path, map: &Map) -> Result<EncodedMap, OutputError> {
    map.check(path)?;
    let (texels, clamped) = map.within(0.0, MAX);
    let texels: Vec<Rgb<f32>> = texels.map(|texel| Rgb(rounded(texel).to_array())).collect();
    let mut bytes = Vec::new();
    HdrEncoder::new(&mut bytes).encode(&texels, map.width as usize, map.height as usize).map_err(|error| {
        OutputError::new(path, format!("a Radiance picture cannot hold the map: {error}"), "write it to an .exr file")
    })?;
    Ok(EncodedMap { bytes, clamped })
}

/// The nearest colour that the format can hold.
fn rounded(texel: Vec3) -> Vec3 {
    let greatest = texel.max_element();
    if greatest < MIN {
        return Vec3::ZERO;
    }
    // 1/128 of the greatest power of two that is no more than the greatest channel: its mantissa is in 128..=255.
    let step = |greatest: f32| f32::from_bits((greatest.to_bits() & 0x7f80_0000) - (7 << 23));
    let fine = step(greatest);
    // Rounding up may need one more bit.
    let step = step((greatest / fine).round() * fine);
    (texel / step).round() * step
}

#[cfg(test)]
mod tests {
    use image::DynamicImage;
    use image::codecs::hdr::HdrDecoder;

    use super::*;

    fn decoded(bytes: &[u8]) -> Vec<Vec3> {
        let DynamicImage::ImageRgb32F(image) = DynamicImage::from_decoder(HdrDecoder::new(bytes).unwrap()).unwrap()
        else {
            panic!("three floats");
        };
        image.pixels().map(|pixel| Vec3::from(pixel.0)).collect()
    }

    #[test]
    fn colours_come_back_as_near_as_the_format_allows() {
        // Over many powers of two, and their neighbours.
        let texels: Vec<Vec3> = (-110..120)
            .flat_map(|exponent| {
                let power = f32::powi(2.0, exponent);
                [power.next_down(), power, 1.3 * power, 1.993 * power, 1.9999 * power]
                    .map(|greatest| Vec3::new(0.3 * greatest, greatest, 0.001 * greatest))
            })
            .collect();
        // Narrow pictures are flat, wider ones have runs.
        for width in [5, 50] {
            let map = Map { width, height: texels.len() as u32 / width, texels: &texels };
            let file = encode_hdr(Path::new("a.hdr"), &map).unwrap();
            assert_eq!(file.clamped, 0);
            for (found, texel) in decoded(&file.bytes).iter().zip(&texels) {
                let error = (*found - texel).abs().max_element() / texel.y;
                assert!(error <= 1.0 / 256.0, "{texel} became {found}");
            }
        }
    }

    #[test]
    fn a_map_that_is_written_twice_does_not_change() {
        let texels: Vec<Vec3> = (1..=100).map(|i| Vec3::new(1.0, 1.0 / i as f32, 0.37 * i as f32)).collect();
        let encode =
            |texels: &[Vec3]| encode_hdr(Path::new("a.hdr"), &Map { width: 10, height: 10, texels }).unwrap().bytes;
        let once = encode(&texels);
        assert_eq!(encode(&decoded(&once)), once);
    }

    #[test]
    fn the_brightest_the_darkest_and_what_is_neither() {
        let texels = [Vec3::splat(f32::MAX), Vec3::splat(1e-40), Vec3::new(-1.0, f32::NAN, 2.0), Vec3::ZERO];
        let file = encode_hdr(Path::new("a.hdr"), &Map { width: 4, height: 1, texels: &texels }).unwrap();
        assert_eq!(file.clamped, 2);
        let found = decoded(&file.bytes);
        assert!((found[0] / MAX - 1.0).abs().max_element() < 1.0 / 256.0, "{}", found[0]);
        assert_eq!(found[1..], [Vec3::ZERO, Vec3::new(0.0, 0.0, 2.0), Vec3::ZERO]);
    }
}
