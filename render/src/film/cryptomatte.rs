//! Cryptomatte: names as hashes, and how much of a pixel each covers.
//!
//! A sample counts for the name that its camera ray hits, with the magnitude of its filter weight, as coverage is never
//! negative; what hits nothing counts for no name. So the coverages of a pixel sum to the part of it that shows
//! surfaces. A film keeps the weights of all names of a pixel as exact integers, so that parts of a picture add up to
//! the bit; only a picture is limited to so many levels.
//!
//! Sources: Friedman and Jones, "Fully Automatic ID Mattes with Support for Motion Blur and Transparency" (2015);
//! "Cryptomatte Specification", version 1.2.0; Appleby's MurmurHash3_x86_32.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::sum::Sum;
use super::{Channel, Film};

/// In place of a name where there is none.
pub(crate) const NO_NAME: u32 = 0;

/// The names of one layer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MatteLayer {
    /// The layer's own name, for example `CryptoObject`.
    pub layer: String,
    /// How many of its names a pixel of the picture has at most.
    pub levels: u32,
    /// All names, sorted, each once.
    pub names: Vec<String>,
}

/// The coverage of a pixel: names by their ids, sorted, and the weights of their samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Coverage(pub(super) Vec<(u32, Sum)>);

/// The id of a name: the bits of a float, never of one that is infinite, not a number, subnormal or zero.
pub(crate) fn id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    let exponent = hash >> 23 & 0xff;
    if exponent == 0 || exponent == 0xff { hash ^ 1 << 23 } else { hash }
}

/// MurmurHash3_x86_32 with the seed 0.
fn murmur3(bytes: &[u8]) -> u32 {
    let scramble = |word: u32| word.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (words, rest) = bytes.as_chunks::<4>();
    let mut hash = 0_u32;
    for word in words {
        hash = (hash ^ scramble(u32::from_le_bytes(*word))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64);
    }
    let rest = rest.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte));
    hash ^= scramble(rest) ^ bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

impl MatteLayer {
    /// The layer of these names.
    pub(crate) fn new(layer: &str, levels: u32, names: impl Iterator<Item = String>) -> Self {
        let names: std::collections::BTreeSet<String> = names.collect();
        Self { layer: layer.to_owned(), levels, names: names.into_iter().collect() }
    }

    /// The attributes by which readers find the layer.
    pub(super) fn attributes(&self) -> [(String, String); 4] {
        let key = format!("{:08x}", murmur3(self.layer.as_bytes()));
        let key = |name: &str| format!("cryptomatte/{}/{name}", &key[..7]);
        let manifest: BTreeMap<&String, String> =
            self.names.iter().map(|name| (name, format!("{:08x}", id(name)))).collect();
        let manifest = serde_json::to_string(&manifest).unwrap_or_default();
        [
            (key("name"), self.layer.clone()),
            (key("hash"), "MurmurHash3_32".to_owned()),
            (key("conversion"), "uint32_to_float32".to_owned()),
            (key("manifest"), ascii(&manifest)),
        ]
    }
}

/// JSON whose characters beyond ASCII are escaped, as attributes of OpenEXR have no encoding.
fn ascii(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    let mut units = [0; 2];
    for character in json.chars() {
        if character.is_ascii() {
            out.push(character);
        } else {
            character.encode_utf16(&mut units).iter().for_each(|unit| out += &format!("\\u{unit:04x}"));
        }
    }
    out
}

impl Coverage {
    /// Adds a sample that shows this name.
    pub(super) fn add(&mut self, id: u32, weight: f32) {
        self.of(id).add(f64::from(weight.abs()));
    }

    /// Adds all that another has.
    pub(super) fn merge(&mut self, other: &Self) {
        other.0.iter().for_each(|&(id, weight)| self.of(id).merge(weight));
    }

    fn of(&mut self, id: u32) -> &mut Sum {
        let place = self.0.binary_search_by_key(&id, |&(id, _)| id).unwrap_or_else(|place| {
            self.0.insert(place, (id, Sum::default()));
            place
        });
        &mut self.0[place].1
    }

    /// The names and the part of the pixel that each covers, the greatest part first.
    fn ranked(&self) -> Vec<(u32, f64)> {
        let mut names: Vec<(u32, Sum)> = self.0.iter().copied().filter(|&(_, weight)| weight.0 > 0).collect();
        let mut total = Sum::default();
        names.iter().for_each(|&(_, weight)| total.merge(weight));
        names.retain(|&(id, _)| id != NO_NAME);
        names.sort_by(|(a, weight), (b, other)| other.0.cmp(&weight.0).then(a.cmp(b)));
        names.into_iter().map(|(id, weight)| (id, weight.value() / total.value())).collect()
    }
}

impl Film {
    /// The channels of all Cryptomatte layers: two names a layer of four channels, by their rank.
    pub(super) fn matte_channels(&self) -> Vec<Channel> {
        let (width, height) = (self.header.width as usize, self.header.height as usize);
        let mut channels = Vec::new();
        for (number, layer) in self.header.cryptomatte.iter().enumerate() {
            let first = channels.len();
            for pair in 0..layer.levels.div_ceil(2) {
                let channel =
                    |c| Channel { name: format!("{}{pair:02}.{c}", layer.layer), values: vec![0.0; width * height] };
                channels.extend(["R", "G", "B", "A"].map(channel));
            }
            for tile in &self.tiles {
                for ((x, y), coverage) in tile.pixels().zip(&tile.mattes[number]) {
                    let names = coverage.ranked().into_iter().take(layer.levels as usize);
                    for (pair, (id, part)) in channels[first..].as_chunks_mut::<2>().0.iter_mut().zip(names) {
                        let pixel = y as usize * width + x as usize;
                        (pair[0].values[pixel], pair[1].values[pixel]) = (f32::from_bits(id), part as f32);
                    }
                }
            }
        }
        channels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_others() {
        // Of the specification's manifest, and of MurmurHash3's own users (seed 0).
        for (name, hash) in
            [("", 0), ("hello", 0x248b_fa47), ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723)]
        {
            assert_eq!(murmur3(name.as_bytes()), hash, "{name}");
        }
    }

    #[test]
    fn ids_are_usual_floats() {
        // "" has the hash 0.
        assert_eq!(id(""), 1 << 23);
        for number in 0..100_000 {
            assert!(f32::from_bits(id(&format!("object {number}"))).is_normal());
        }
    }

    #[test]
    fn manifests_are_json_in_ascii() {
        let layer = MatteLayer::new("CryptoObject", 6, ["tür \"1\"", "b", "b", "🚪"].map(str::to_owned).into_iter());
        let [name, .., (key, manifest)] = layer.attributes();
        assert_eq!((name.1.as_str(), key.starts_with("cryptomatte/")), ("CryptoObject", true));
        assert!(manifest.is_ascii() && manifest.contains("\\u00fc"), "{manifest}");
        let read: BTreeMap<String, String> = serde_json::from_str(&manifest).unwrap();
        let expected = ["tür \"1\"", "b", "🚪"].map(|name| (name.to_owned(), format!("{:08x}", id(name))));
        assert_eq!(read, expected.into_iter().collect());
    }

    #[test]
    fn names_are_ranked_by_what_they_cover() {
        let mut coverage = Coverage::default();
        for (id, weight) in [(7, 1.0), (NO_NAME, 2.0), (3, -4.0), (9, 1.0)] {
            coverage.add(id, weight);
        }
        assert_eq!(coverage.ranked(), [(3, 0.5), (7, 0.125), (9, 0.125)]);
        let mut twice = coverage.clone();
        twice.merge(&coverage);
        assert_eq!(twice.ranked(), coverage.ranked());
    }
}
