//! KTX2 files with textures of Basis Universal (ETC1S and UASTC, of `KHR_texture_basisu`), which the crate basisu
//! decodes: the largest level, as 8 bits, or as floats if it is UASTC HDR.
//!
//! Deviations: colours are sRGB or linear as the material's input says, whatever the file says; other kinds of blocks
//! (BC7, ASTC) and texels that are not compressed are not read.

use basisu::{DecodeFlags, Error, SourceFormat, TargetFormat, Transcoder};
use half::f16;

use super::error::TextureError;
use super::{Texels, Texture};

/// Where the header has `vkFormat`, the size of the picture, and the size of its first level when Zstandard has
/// unpacked it.
const FORMAT: usize = 12;
const SIZE: [usize; 2] = [20, 24];
const UNPACKED: usize = 96;

/// `vkFormat` of ETC1S and UASTC (`VK_FORMAT_UNDEFINED`), and of UASTC HDR (`VK_FORMAT_ASTC_4x4_SFLOAT_BLOCK`).
const UNDEFINED: u32 = 0;
const HDR: u32 = 1_000_066_000;

/// Bytes of a block, which has 4 x 4 texels or more.
const BLOCK_BYTES: u64 = 16;

/// The picture in a KTX2 file.
pub(super) fn decode(bytes: &[u8]) -> Result<Texture, TextureError> {
    let damaged = || TextureError::wrong("it is damaged: its header is cut short".to_owned(), "export it again");
    let [width, height] = SIZE.map(|at| word(bytes, at));
    let (width, height) = (width.ok_or_else(damaged)?, height.ok_or_else(damaged)?);
    let texel_bytes = match word(bytes, FORMAT) {
        Some(UNDEFINED) => 4,
        Some(HDR) => 12,
        _ => return Err(unknown("it is a KTX2 file without Basis Universal".to_owned())),
    };
    TextureError::check_size(width, height, u64::from(width) * u64::from(height) * texel_bytes)?;
    // The crate believes this number, and asks for as much memory.
    let blocks = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4));
    let unpacked = bytes.get(UNPACKED..UNPACKED + 8).and_then(|it| it.try_into().ok()).map(u64::from_le_bytes);
    if unpacked.ok_or_else(damaged)? > blocks * BLOCK_BYTES {
        return Err(TextureError::wrong(
            "it is damaged: its first level is larger than its picture".to_owned(),
            "export it again",
        ));
    }
    let file = Transcoder::new(bytes).map_err(because)?;
    if file.layer_count() > 1 || file.face_count() > 1 {
        let problem = format!("it has {} layers and {} faces", file.layer_count().max(1), file.face_count());
        return Err(TextureError::wrong(problem, "save it as one picture"));
    }
    let decoded = |target| file.transcode(0, target, DecodeFlags::NONE).map_err(because);
    let (channels, texels) = match file.source_format() {
        SourceFormat::UastcHdr4x4 => {
            let halves: Vec<u16> = bytemuck::pod_collect_to_vec(&decoded(TargetFormat::RgbHalf)?);
            (3, Texels::finite(halves.into_iter().map(|bits| f16::from_bits(bits).to_f32())))
        }
        SourceFormat::Etc1s | SourceFormat::UastcLdr => {
            let texels = decoded(TargetFormat::Rgba32)?;
            match file.has_alpha() {
                true => (4, Texels::U8(texels)),
                false => {
                    (3, Texels::U8(texels.chunks_exact(4).flat_map(|texel| [texel[0], texel[1], texel[2]]).collect()))
                }
            }
        }
        other => return Err(unknown(format!("it is a KTX2 file with {other:?}, which is not read"))),
    };
    Ok(Texture::from_texels(width, height, channels, texels))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes)
}

fn unknown(problem: String) -> TextureError {
    TextureError { problem, remedy: "save it with ETC1S or UASTC, or as PNG", is_unknown_kind: true }
}

fn because(error: Error) -> TextureError {
    match error {
        Error::VideoRequiresState => TextureError::wrong("it is a video".to_owned(), "save one picture of it"),
        Error::Truncated => TextureError::wrong("it is damaged: it is cut short".to_owned(), "export it again"),
        _ => TextureError::wrong("it is damaged: it is not what its header says".to_owned(), "export it again"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Written by Binomial's encoder, version 2.5: blocks of one colour each, as `color` has them.
    const UASTC: &[u8] = include_bytes!("ktx2/uastc.ktx2");
    const ZSTD: &[u8] = include_bytes!("ktx2/zstd.ktx2");
    const ETC1S: &[u8] = include_bytes!("ktx2/etc1s.ktx2");
    const OPAQUE: &[u8] = include_bytes!("ktx2/opaque.ktx2");
    const FLOATS: &[u8] = include_bytes!("ktx2/hdr.ktx2");

    /// Of a texel in a picture of 18 x 10.
    fn color(index: usize) -> [usize; 4] {
        let (column, row) = (index % 18 / 4, index / 18 / 4);
        [20 + 50 * column, 230 - 80 * row, 40 + 20 * column + 30 * row, 255 - 25 * column - 20 * row]
    }

    fn check(bytes: &[u8], channels: usize, error: u8) {
        let texture = super::super::decode(bytes, None).unwrap();
        assert_eq!((texture.size(), texture.channels(), texture.bits()), ((18, 10), channels, 8));
        for (index, texel) in texture.texel_bytes().chunks(channels).enumerate() {
            for (&found, expected) in texel.iter().zip(color(index)) {
                assert!(usize::from(found).abs_diff(expected) <= error.into(), "texel {index}: {texel:?}");
            }
        }
    }

    #[test]
    fn all_kinds_have_the_texels_that_were_written() {
        check(UASTC, 4, 0);
        check(ZSTD, 4, 0);
        // Its colours have 5 bits.
        check(ETC1S, 4, 4);
        check(OPAQUE, 3, 4);
        let texture = decode(FLOATS).unwrap();
        assert_eq!((texture.size(), texture.channels(), texture.bits()), ((6, 6), 3, 32));
        assert!(
            texture
                .texel_bytes()
                .chunks(12)
                .all(|texel| bytemuck::pod_read_unaligned::<[f32; 3]>(texel) == [4., 2., 1.])
        );
    }

    #[test]
    fn damage_is_an_error_and_asks_for_no_memory() {
        for file in [UASTC, ZSTD, ETC1S, FLOATS] {
            for end in 12..file.len() {
                // The smaller levels come first.
                assert!(decode(&file[..end]).is_err(), "{end}");
            }
            for at in 0..file.len() {
                for value in [0, 1, 0x7f, 0x80, 0xff, !file[at]] {
                    let mut changed = file.to_vec();
                    changed[at] = value;
                    if let Ok(texture) = decode(&changed) {
                        assert!(texture.bytes() < 1 << 23, "byte {at}");
                    }
                }
            }
        }
    }

    #[test]
    fn errors_say_what_is_wrong() {
        let problem = |at: usize, value: u32| {
            let mut changed = UASTC.to_vec();
            changed[at..at + 4].copy_from_slice(&value.to_le_bytes());
            decode(&changed).unwrap_err()
        };
        assert_eq!(problem(SIZE[0], 0).problem, "it has 0 x 10 pixels");
        assert_eq!(problem(SIZE[1], 70_000).problem, "its 18 x 70000 pixels take 0.0 GiB");
        // BC7.
        let other = problem(FORMAT, 145);
        assert!(other.is_unknown_kind && other.problem.contains("without Basis Universal"), "{other:?}");
        assert_eq!(problem(UNPACKED, u32::MAX).problem, "it is damaged: its first level is larger than its picture");
        // A cube map, an array, a volume.
        for (at, count) in [(36, 6), (32, 2), (28, 2)] {
            assert!(!problem(at, count).is_unknown_kind);
        }
    }
}
