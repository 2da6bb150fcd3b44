//! KTX 2.0 with one image in half floats (`VK_FORMAT_R16G16B16A16_SFLOAT`): what Bevy wants of a lightmap.
//!
//! The file is a header of 80 bytes, the place of the only mip level, the data format descriptor, key and value pairs,
//! and the texels; nothing is compressed. Alpha is 1.
//!
//! Sources: "KTX File Format Specification", version 2.0; "Khronos Data Format Specification", version 1.3, section 5
//! (the basic descriptor block) and 10.2 (half floats). Both of the Khronos Group.

use std::path::Path;

use half::f16;

use super::{EncodedMap, Map, OutputError};

const IDENTIFIER: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";
const VK_FORMAT_R16G16B16A16_SFLOAT: u32 = 97;
/// Bytes of the header with its index.
const HEADER: u32 = 80;
/// Bytes of a level's place: offset, length, and length before compression.
const LEVEL_INDEX: u32 = 24;
/// Bytes of a texel, to a multiple of which texels are aligned.
const TEXEL: u32 = 8;

/// The bytes of a KTX2 file; `path` is for messages.
///
/// # Errors
/// If the map has not as many texels as its size says.
pub fn encode_ktx2(path: &Path, map: &Map) -> Result<EncodedMap, OutputError> {
    map.check(path)?;
    let (texels, clamped) = map.within(f16::MAX.to_f32());
    let (descriptor, pairs) = (words(&descriptor()), key_value_data());
    let descriptor_at = HEADER + LEVEL_INDEX;
    let pairs_at = descriptor_at + descriptor.len() as u32;
    let texels_at = (pairs_at + pairs.len() as u32).next_multiple_of(TEXEL);
    let texels_length = u64::from(TEXEL) * map.texels.len() as u64;

    let mut bytes = Vec::with_capacity(texels_at as usize + texels_length as usize);
    bytes.extend(IDENTIFIER);
    let (type_size, depth, layers, faces, levels, supercompression) = (2, 0, 0, 1, 1, 0);
    bytes.extend(words(&[VK_FORMAT_R16G16B16A16_SFLOAT, type_size, map.width, map.height, depth]));
    bytes.extend(words(&[layers, faces, levels, supercompression]));
    bytes.extend(words(&[descriptor_at, descriptor.len() as u32, pairs_at, pairs.len() as u32]));
    let global_data = [0_u64; 2];
    for number in global_data.into_iter().chain([texels_at.into(), texels_length, texels_length]) {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(descriptor);
    bytes.extend(pairs);
    bytes.resize(texels_at as usize, 0);
    for texel in texels {
        bytes.extend(texel.extend(1.0).to_array().map(|value| f16::from_f32(value).to_le_bytes()).as_flattened());
    }
    Ok(EncodedMap { bytes, clamped })
}

/// The basic data format descriptor: linear Rec. 709 colours, four signed floats of 16 bits a texel.
fn descriptor() -> [u32; 23] {
    const SAMPLES: u32 = 4;
    const BLOCK: u32 = 24 + 16 * SAMPLES;
    const VERSION: u32 = 2;
    const RGBSDA: u32 = 1;
    const BT709: u32 = 1;
    const LINEAR: u32 = 1;
    /// Qualifiers of a channel's type.
    const FLOAT_SIGNED: u32 = 0xc0;
    const CHANNELS: [u32; SAMPLES as usize] = [0, 1, 2, 15];
    let mut descriptor = [0; 23];
    // Its own length, then the block: vendor and type (0), version and size, model, dimensions (0), bytes in plane 0.
    descriptor[..6].copy_from_slice(&[
        BLOCK + 4,
        0,
        BLOCK << 16 | VERSION,
        LINEAR << 16 | BT709 << 8 | RGBSDA,
        0,
        TEXEL,
    ]);
    for (sample, (words, channel)) in (0..).zip(descriptor[7..].chunks_exact_mut(4).zip(CHANNELS)) {
        let (offset, length_less_one) = (16 * sample, 15);
        words[0] = (FLOAT_SIGNED | channel) << 24 | length_less_one << 16 | offset;
        // Position 0; what stands for -1 and 1.
        (words[2], words[3]) = ((-1.0_f32).to_bits(), 1.0_f32.to_bits());
    }
    descriptor
}

/// Where the first texel is, and who wrote the file; keys in the order of their bytes.
fn key_value_data() -> Vec<u8> {
    let writer = concat!("halfdome ", env!("CARGO_PKG_VERSION"));
    let mut bytes = Vec::new();
    for (key, value) in [("KTXorientation", "rd"), ("KTXwriter", writer)] {
        let pair = [key.as_bytes(), b"\0", value.as_bytes(), b"\0"].concat();
        bytes.extend((pair.len() as u32).to_le_bytes());
        bytes.extend(pair);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use ktx2::dfd::{Basic, Block};
    use ktx2::{ColorModel, ColorPrimaries, Format, Reader, TransferFunction};

    use super::*;

    fn encode(width: u32, height: u32, texels: &[Vec3]) -> EncodedMap {
        encode_ktx2(Path::new("a.ktx2"), &Map { width, height, texels }).unwrap()
    }

    #[test]
    fn another_reader_finds_the_same_texels() {
        let texels: Vec<Vec3> = (0..15).map(|i| Vec3::new(i as f32, 0.25, 1024.0 - i as f32)).collect();
        let file = encode(5, 3, &texels);
        assert_eq!(file.clamped, 0);
        let reader = Reader::new(&file.bytes).unwrap();
        let header = reader.header();
        assert_eq!(header.format, Some(Format::R16G16B16A16_SFLOAT));
        assert_eq!((header.pixel_width, header.pixel_height, header.pixel_depth), (5, 3, 0));
        assert_eq!((header.layer_count, header.face_count, header.level_count, header.type_size), (0, 1, 1, 2));
        assert_eq!(header.supercompression_scheme, None);
        let levels: Vec<_> = reader.levels().collect();
        assert_eq!(levels.len(), 1);
        let halves = levels[0].data.chunks_exact(2).map(|bytes| f16::from_le_bytes([bytes[0], bytes[1]]).to_f32());
        let expected = texels.iter().flat_map(|texel| texel.extend(1.0).to_array());
        assert!(halves.eq(expected), "these numbers are exact in half floats");
        let start = levels[0].data.as_ptr() as usize - file.bytes.as_ptr() as usize;
        assert_eq!((start % 8, start + levels[0].data.len()), (0, file.bytes.len()));
        let pairs: Vec<_> = reader.key_value_data().collect();
        assert_eq!(pairs[0], ("KTXorientation", b"rd\0".as_slice()));
        assert_eq!(pairs[1].0, "KTXwriter");
        assert_eq!(pairs.len(), 2);
    }

    #[test]
    fn the_descriptor_is_that_of_the_format() {
        let file = encode(1, 1, &[Vec3::ONE]);
        let (descriptor, type_size) = Basic::from_format(Format::R16G16B16A16_SFLOAT).unwrap();
        let reader = Reader::new(&file.bytes).unwrap();
        assert_eq!(reader.dfd_blocks(), [Block::Basic(descriptor)]);
        assert_eq!(reader.header().type_size, type_size);
        assert_eq!(reader.color_model(), Some(ColorModel::RGBSDA));
        assert_eq!(reader.color_primaries(), Some(ColorPrimaries::BT709));
        assert_eq!(reader.transfer_function(), Some(TransferFunction::Linear));
        assert_eq!(reader.is_alpha_premultiplied(), Some(false));
    }

    #[test]
    fn what_half_floats_cannot_hold_is_clamped() {
        let file = encode(2, 1, &[Vec3::new(65504.0, 65536.0, -1.0), Vec3::splat(65504.0)]);
        assert_eq!(file.clamped, 1);
        let reader = Reader::new(&file.bytes).unwrap();
        let data = reader.levels().next().unwrap().data;
        let halves: Vec<f16> = data.chunks_exact(2).map(|bytes| f16::from_le_bytes([bytes[0], bytes[1]])).collect();
        assert_eq!(halves[..4], [f16::MAX, f16::MAX, f16::ZERO, f16::ONE]);
    }
}
