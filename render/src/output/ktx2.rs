//! KTX 2.0 in half floats (`VK_FORMAT_R16G16B16A16_SFLOAT`): Bevy's format for lightmaps, cube maps and irradiance
//! volumes.
//!
//! The file is a header of 80 bytes, the places of the mip levels, the data format descriptor, key and value pairs, and
//! the texels, smallest level first; nothing is compressed. A level holds its layers or faces (+X, -X, +Y, -Y, +Z, -Z)
//! one after the other, or its slices. Alpha is 1.
//!
//! Sources: "KTX File Format Specification", version 2.0; "Khronos Data Format Specification", version 1.3, section 5
//! (the basic descriptor block) and 10.2 (half floats). Both of the Khronos Group.

use std::path::Path;

use glam::Vec3;
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

/// A texture of one or several mip levels.
#[derive(Clone, Debug)]
pub struct Texture<'a> {
    /// What it is, with its extent in texels.
    pub shape: Shape,
    /// Texels of each level from the largest on, each level half as long along all axes as the one before: face by
    /// face, layer by layer or slice by slice, row by row from the top.
    pub levels: Vec<&'a [Vec3]>,
    /// Whether numbers may be negative; else what is becomes 0.
    pub is_signed: bool,
}

/// The kind of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A picture: width and height.
    Plane([u32; 2]),
    /// Several pictures of one size, an array of textures: width, height and their number.
    Layers([u32; 3]),
    /// Six square faces of this side.
    Cube(u32),
    /// Slices of a volume: width, height and depth.
    Volume([u32; 3]),
}

impl Shape {
    /// Texels in this mip level.
    fn texels(self, level: u32) -> u64 {
        let side = |side: u32| u64::from((side >> level).max(1));
        match self {
            Self::Plane([width, height]) => side(width) * side(height),
            Self::Layers([width, height, layers]) => side(width) * side(height) * u64::from(layers),
            Self::Cube(size) => 6 * side(size) * side(size),
            Self::Volume([width, height, depth]) => side(width) * side(height) * side(depth),
        }
    }

    /// Width, height, depth, layers and faces as the header has them: a depth of 0 for what is flat, and no layers for
    /// what is no array.
    fn extent(self) -> [u32; 5] {
        match self {
            Self::Plane([width, height]) => [width, height, 0, 0, 1],
            Self::Layers([width, height, layers]) => [width, height, 0, layers, 1],
            Self::Cube(size) => [size, size, 0, 0, 6],
            Self::Volume([width, height, depth]) => [width, height, depth, 0, 1],
        }
    }

    /// The orientation of texels: right, down, and for volumes inwards.
    fn orientation(self) -> &'static str {
        if matches!(self, Self::Volume(_)) { "rdi" } else { "rd" }
    }
}

/// The bytes of a KTX2 file of one picture; `path` is for messages.
///
/// # Errors
/// If the map has not as many texels as its size says.
pub fn encode_ktx2(path: &Path, map: &Map) -> Result<EncodedMap, OutputError> {
    let shape = Shape::Plane([map.width, map.height]);
    encode_ktx2_texture(path, &Texture { shape, levels: vec![map.texels], is_signed: false })
}

/// The bytes of a KTX2 file; `path` is for messages.
///
/// # Errors
/// If there is no level, or one has not as many texels as the shape says.
pub fn encode_ktx2_texture(path: &Path, texture: &Texture) -> Result<EncodedMap, OutputError> {
    for (level, texels) in (0..).zip(&texture.levels) {
        let expected = texture.shape.texels(level);
        if texels.is_empty() || texels.len() as u64 != expected {
            let problem = format!("level {level} has {} texels instead of {expected}", texels.len());
            return Err(OutputError::new(path, problem, "give it one colour for each texel, and at least one"));
        }
    }
    if texture.levels.is_empty() {
        return Err(OutputError::new(path, "the texture has no levels", "give it at least one"));
    }
    let levels = texture.levels.len() as u32;
    let (descriptor, pairs) = (words(&descriptor()), key_value_data(texture.shape.orientation()));
    let descriptor_at = HEADER + LEVEL_INDEX * levels;
    let pairs_at = descriptor_at + descriptor.len() as u32;
    let texels_at = (pairs_at + pairs.len() as u32).next_multiple_of(TEXEL);

    let [width, height, depth, layers, faces] = texture.shape.extent();
    let (type_size, supercompression) = (2, 0);
    let mut bytes = Vec::from(IDENTIFIER);
    bytes.extend(words(&[VK_FORMAT_R16G16B16A16_SFLOAT, type_size, width, height, depth]));
    bytes.extend(words(&[layers, faces, levels, supercompression]));
    bytes.extend(words(&[descriptor_at, descriptor.len() as u32, pairs_at, pairs.len() as u32]));
    let mut numbers = vec![0_u64; 2];
    let lengths = texture.levels.iter().map(|texels| u64::from(TEXEL) * texels.len() as u64);
    for (level, length) in lengths.clone().enumerate() {
        let smaller: u64 = lengths.clone().skip(level + 1).sum();
        numbers.extend([u64::from(texels_at) + smaller, length, length]);
    }
    numbers.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    bytes.extend(descriptor);
    bytes.extend(pairs);
    bytes.resize(texels_at as usize, 0);
    let mut clamped = 0;
    let most = f16::MAX.to_f32();
    let least = if texture.is_signed { -most } else { 0.0 };
    for level in texture.levels.iter().rev() {
        let map = Map { width: level.len() as u32, height: 1, texels: level };
        let (texels, changed) = map.within(least, most);
        clamped += changed;
        for texel in texels {
            bytes.extend(texel.extend(1.0).to_array().map(|value| f16::from_f32(value).to_le_bytes()).as_flattened());
        }
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
        // Position 0; the values for -1 and 1.
        (words[2], words[3]) = ((-1.0_f32).to_bits(), 1.0_f32.to_bits());
    }
    descriptor
}

/// Where the first texel is, and who wrote the file; keys in the order of their bytes.
fn key_value_data(orientation: &str) -> Vec<u8> {
    let writer = concat!("halfdome ", env!("CARGO_PKG_VERSION"));
    let mut bytes = Vec::new();
    for (key, value) in [("KTXorientation", orientation), ("KTXwriter", writer)] {
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

    /// The first channel of a level's texels.
    fn reds(data: &[u8]) -> Vec<f32> {
        data.chunks_exact(8).map(|texel| f16::from_le_bytes([texel[0], texel[1]]).to_f32()).collect()
    }

    #[test]
    fn another_reader_finds_faces_levels_and_slices() {
        let texels: Vec<Vec3> = (0..96).map(|i| Vec3::splat(i as f32)).collect();
        let encode = |shape, levels: &[&[Vec3]]| {
            encode_ktx2_texture(Path::new("a.ktx2"), &Texture { shape, levels: levels.to_vec(), is_signed: false })
        };
        let cube = encode(Shape::Cube(4), &[&texels, &texels[..24], &texels[..6]]).unwrap().bytes;
        let reader = Reader::new(&cube).unwrap();
        let header = reader.header();
        assert_eq!((header.pixel_width, header.pixel_height, header.pixel_depth), (4, 4, 0));
        assert_eq!((header.layer_count, header.face_count, header.level_count), (0, 6, 3));
        let found: Vec<_> = reader.levels().map(|level| reds(level.data)).collect();
        let expected = [96, 24, 6].map(|count| (0..count).map(|i| i as f32).collect::<Vec<_>>());
        assert_eq!(found, expected);
        let volume = encode(Shape::Volume([2, 6, 8]), &[&texels]).unwrap().bytes;
        let reader = Reader::new(&volume).unwrap();
        let header = reader.header();
        assert_eq!((header.pixel_width, header.pixel_height, header.pixel_depth), (2, 6, 8));
        assert_eq!((header.face_count, header.level_count), (1, 1));
        assert_eq!(reader.key_value_data().next(), Some(("KTXorientation", b"rdi\0".as_slice())));
        assert_eq!(reds(reader.levels().next().unwrap().data), expected[0]);
        assert_eq!(
            encode(Shape::Cube(4), &[&texels[..95]]).unwrap_err().problem,
            "level 0 has 95 texels instead of 96"
        );
        assert_eq!(
            encode(Shape::Cube(4), &[&texels, &texels[..6]]).unwrap_err().problem,
            "level 1 has 6 texels instead of 24"
        );
        assert_eq!(encode(Shape::Cube(4), &[]).unwrap_err().problem, "the texture has no levels");
    }

    #[test]
    fn another_reader_finds_layers_and_signs() {
        let texels: Vec<Vec3> = (0..30).map(|i| Vec3::splat(15.0 - i as f32)).collect();
        let texture = Texture { shape: Shape::Layers([5, 2, 3]), levels: vec![&texels], is_signed: true };
        let file = encode_ktx2_texture(Path::new("a.ktx2"), &texture).unwrap();
        assert_eq!(file.clamped, 0);
        let reader = Reader::new(&file.bytes).unwrap();
        let header = reader.header();
        assert_eq!((header.pixel_width, header.pixel_height, header.pixel_depth), (5, 2, 0));
        assert_eq!((header.layer_count, header.face_count, header.level_count), (3, 1, 1));
        assert_eq!(reds(reader.levels().next().unwrap().data), texels.iter().map(|texel| texel.x).collect::<Vec<_>>());
        let unsigned = encode_ktx2_texture(Path::new("a.ktx2"), &Texture { is_signed: false, ..texture }).unwrap();
        assert_eq!(unsigned.clamped, 14);
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
