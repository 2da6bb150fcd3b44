//! Opacity micromaps: which cells of a triangle with an opacity texture are holes or whole everywhere, so that hits there need
//! no lookup of texture coordinates and texels (Gruen, Benthin and Woop 2020, "Sub-triangle opacity masks for faster ray tracing
//! of transparent objects").
//!
//! Each triangle is divided into congruent cells of two bits. Triangles of one material with the same texture coordinates, such
//! as leaf cards, share a micromap. A cell is known only if all texels agree that its points may mix, so hits are the same
//! as without.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::Vec2;
use rayon::prelude::*;

use super::surface::shading_records::TriangleRecord;
use crate::light::{Division, TrianglePart};
use crate::scene::{BrightnessTable, Material, Mesh, Texture, TextureMap};

/// The most cells along each edge of a triangle; fewer if there are many micromaps.
const FINEST: u32 = 64;
/// The most micromaps, and words of all together: 16 MiB.
const MOST: usize = 1 << 18;
const ALL_WORDS: usize = 1 << 21;
/// The values for triangles without holes, and for those without a micromap that may have some.
const WHOLE: u32 = u32::MAX;
const UNKNOWN: u32 = u32::MAX - 1;

/// The micromaps of a scene.
#[derive(Debug)]
pub(super) struct OpacityMicromaps {
    /// For each `prim_id` the number of its micromap, or one of the values above.
    numbers: Vec<u32>,
    /// Cells along each edge.
    side: u32,
    /// Two bits for each cell of each micromap: whether it is whole, and whether it is known.
    words: Vec<u64>,
}

/// Cells of a word.
const CELLS_OF_WORD: usize = 32;

impl Default for OpacityMicromaps {
    /// Of no triangles.
    fn default() -> Self {
        Self { numbers: Vec::new(), side: FINEST, words: Vec::new() }
    }
}

impl OpacityMicromaps {
    /// Of these triangles, of meshes whose first triangles have the indices `first_faces`.
    pub(super) fn new(
        (meshes, first_faces): (&[Mesh], &[u32]),
        (materials, textures): (&[Material], &[Texture]),
        records: &[TriangleRecord],
    ) -> Self {
        let tables: Vec<Option<Tables>> =
            materials.par_iter().map(|material| Tables::new(material, textures)).collect();
        // The triangles that show each.
        let mut numbers = Vec::with_capacity(records.len());
        let (mut known, mut shown) = (HashMap::new(), Vec::new());
        for (prim, record) in (0..).zip(records) {
            let (material, mesh) = (&materials[record.material as usize], &meshes[record.mesh as usize]);
            let has_colors = material.uses_vertex_colors && !mesh.colors.is_empty();
            let mut number = || {
                let tables = tables[record.material as usize].as_ref()?;
                let texcoords = mesh.texcoord_set(tables.map.set)?;
                let face = mesh.triangles[(prim - first_faces[record.mesh as usize]) as usize];
                let corners = face.map(|corner| texcoords[corner as usize]);
                let bits = corners.map(|corner| corner.to_array().map(f32::to_bits));
                match known.entry((record.material, bits)) {
                    Entry::Occupied(number) => Some(*number.get()),
                    Entry::Vacant(_) if shown.len() == MOST => None,
                    Entry::Vacant(place) => {
                        shown.push((tables, corners));
                        Some(*place.insert(shown.len() as u32 - 1))
                    }
                }
            };
            numbers.push(match (has_colors, material.has_holes()) {
                (true, _) => UNKNOWN,
                (_, false) => WHOLE,
                (_, true) => number().unwrap_or(UNKNOWN),
            });
        }
        let mut side = FINEST;
        while shown.len() * words_of_map(side) > ALL_WORDS {
            side /= 2;
        }
        let mut words = vec![0; shown.len() * words_of_map(side)];
        let maps = words.par_chunks_mut(words_of_map(side)).zip(&shown);
        maps.for_each(|(words, (tables, corners))| Micromap { words, side }.fill(tables, corners));
        Self { numbers, side, words }
    }

    /// The opacity at a point of triangle `prim_id`, if it is known.
    #[inline(always)]
    pub(super) fn at(&self, prim_id: u32, place: Vec2) -> Option<f32> {
        match self.numbers[prim_id as usize] {
            WHOLE => Some(1.0),
            UNKNOWN => None,
            number => {
                let cell = Division::Congruent { side: self.side }.cell_at(place) as usize;
                let word = self.words[number as usize * words_of_map(self.side) + cell / CELLS_OF_WORD];
                let bits = word >> (cell % CELLS_OF_WORD * 2);
                (bits & 0b10 != 0).then_some((bits & 0b01) as f32)
            }
        }
    }
}

fn words_of_map(side: u32) -> usize {
    (side * side) as usize / CELLS_OF_WORD
}

/// Where the opacity of a material's texture may be another than 0, and another than 1.
struct Tables<'a> {
    map: &'a TextureMap,
    not_hole: BrightnessTable,
    not_whole: BrightnessTable,
}

impl<'a> Tables<'a> {
    fn new(material: &'a Material, textures: &[Texture]) -> Option<Self> {
        let (map, _) = material.opacity.map.as_ref()?;
        let table = |value: usize| {
            textures[map.texture].brightness(map, |texel| f32::from(material.opacity.may_differ(texel)[value]))
        };
        Some(Self { map, not_hole: table(0), not_whole: table(1) })
    }

    /// What is known about all of a triangle with these texture coordinates: that it is whole, or a hole.
    fn is_whole(&self, texcoords: &[Vec2; 3]) -> Option<bool> {
        match self.not_hole.is_black(self.map, texcoords) {
            true => Some(false),
            false => self.not_whole.is_black(self.map, texcoords).then_some(true),
        }
    }
}

/// The micromap of a triangle while it is made.
struct Micromap<'a> {
    words: &'a mut [u64],
    side: u32,
}

impl Micromap<'_> {
    /// Sets all cells of a triangle with these texture coordinates that are known.
    fn fill(&mut self, tables: &Tables, &[a, b, c]: &[Vec2; 3]) {
        let texcoord = |place: Vec2| a + (b - a) * place.x + (c - a) * place.y;
        let known = |part: &TrianglePart| tables.is_whole(&part.places.map(texcoord));
        self.fill_part((&TrianglePart::whole(0), self.side), None, &known);
    }

    /// Sets those of a part with so many cells along each edge, of which this may be known already.
    fn fill_part(
        &mut self,
        (part, side): (&TrianglePart, u32),
        is_whole: Option<bool>,
        known: &impl Fn(&TrianglePart) -> Option<bool>,
    ) {
        let is_whole = is_whole.or_else(|| known(part));
        if side > 1 {
            return part.quarters().iter().for_each(|quarter| self.fill_part((quarter, side / 2), is_whole, known));
        }
        if let Some(is_whole) = is_whole {
            let cell = Division::Congruent { side: self.side }.cell_at(part.middle()) as usize;
            self.words[cell / CELLS_OF_WORD] |= (0b10 | u64::from(is_whole)) << (cell % CELLS_OF_WORD * 2);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use halfdome_kernel::sampling::Stream;

    use super::*;
    use crate::scene::{CameraPose, Channel, Opacity, Scene, TextureFilter, Wrap};
    use crate::world::World;

    const SIDE: u32 = 64;

    /// Two triangles that show two by two pictures of a disc, of which the rim is partly opaque; a third has vertex colours.
    fn world(opacity: &Opacity) -> World {
        let texel = |index: u32| {
            let at = Vec2::new((index % SIDE) as f32, (index / SIDE) as f32) - 0.5 * SIDE as f32;
            [255, 255, 255, (255.0 * (0.3 * (20.0 - at.length())).clamp(0.0, 1.0)) as u8]
        };
        let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        let square = Mesh {
            positions: corners.map(|corner| corner.extend(0.0)).to_vec(),
            texcoords: corners.map(|corner| 2.0 * corner - 0.3).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        let colored = Mesh { colors: vec![glam::Vec4::ONE; 4], triangles: vec![[0, 1, 2]], ..square.clone() };
        let material = Material { opacity: opacity.clone(), uses_vertex_colors: true, ..Material::default() };
        let camera = CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 };
        let plain = Mesh { material: 1, ..square.clone() };
        World::new(Scene {
            meshes: vec![square, colored, plain],
            materials: vec![material, Material::default()],
            textures: vec![Texture::new(SIDE, SIDE, (0..SIDE * SIDE).map(texel).collect())],
            camera: Some(camera),
            ..Scene::default()
        })
        .unwrap()
    }

    #[test]
    fn what_is_known_is_what_a_lookup_finds() {
        for (filter, wrap, cutoff, value) in [
            (TextureFilter::Bilinear, Wrap::Repeat, Some(0.5), 1.0),
            (TextureFilter::Bilinear, Wrap::Mirror, Some(0.2), 0.9),
            (TextureFilter::Nearest, Wrap::Clamp, Some(0.5), 1.0),
            (TextureFilter::Bilinear, Wrap::Repeat, None, 1.0),
            (TextureFilter::Bilinear, Wrap::Repeat, None, 0.7),
        ] {
            let map = TextureMap { filter, wrap: [wrap; 2], ..TextureMap::default() };
            let world = world(&Opacity { value, map: Some((map, Channel::A)), cutoff });
            let micromaps = &world.opacity_micromaps;
            let mut known = [0; 2];
            for i in 0..20_000 {
                let [x, y] = Stream::new(1, i, 0).uniform2(0).to_array();
                let place = if x + y > 1.0 { Vec2::new(1.0 - x, 1.0 - y) } else { Vec2::new(x, y) };
                let Some(opacity) = micromaps.at(i % 2, place) else { continue };
                assert_eq!(opacity, world.looked_up_opacity(i % 2, place.to_array()), "{filter:?} {wrap:?} {cutoff:?}");
                known[opacity as usize] += 1;
            }
            // Of the value 0.7 nothing is whole.
            let whole = if value == 0.7 { 0 } else { 500 };
            assert!(known[0] > 8000 && known[1] >= whole, "{known:?}: {filter:?} {wrap:?} {cutoff:?} {value}");
            let place = Vec2::splat(0.1);
            assert_eq!((micromaps.at(2, place), micromaps.at(3, place)), (None, Some(1.0)));
        }
    }

    #[test]
    fn triangles_share_micromaps() {
        let map = TextureMap::default();
        let world = world(&Opacity { map: Some((map, Channel::A)), cutoff: Some(0.5), ..Opacity::default() });
        let micromaps = &world.opacity_micromaps;
        assert_eq!(micromaps.numbers, [0, 1, UNKNOWN, WHOLE, WHOLE]);
        assert_eq!((micromaps.side, micromaps.words.len()), (FINEST, 2 * words_of_map(FINEST)));
        let leaves = Mesh { triangles: vec![[0, 1, 2]; 5], ..world.meshes[0].clone() };
        let records = vec![world.triangle_records[0]; 5];
        let shared = OpacityMicromaps::new((&[leaves], &[0]), (&world.materials, &world.textures), &records);
        assert_eq!((shared.numbers, shared.words.len()), (vec![0; 5], words_of_map(FINEST)));
    }
}
