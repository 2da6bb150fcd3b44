//! Where triangles with emissive textures emit: how each is divided into cells, and how bright these are.
//!
//! A wall of lit and dark windows, a screen or a sign emits from a part of its area, and most triangles of a model with one
//! emissive texture do not emit at all. So cells are lights of their own, and what is black is none. This affects noise
//! alone, except where light samples are the only estimate: a cell is black if all texels are that its points may mix.

use std::collections::BTreeMap;

use glam::{Vec2, Vec4};
use rayon::prelude::*;

use super::surface::shading_records::TriangleRecord;
use crate::light::{Division, EmissiveParts, TrianglePart, luminance_weight};
use crate::scene::{BrightnessTable, Material, Mesh, Texture, TextureMap};

/// The least number of texels along a cell's edge.
const LEAST_TEXELS: f32 = 2.0;
/// Cells of all triangles, at most, beside one for each, and the most along a triangle's edge.
const CELLS: u64 = 65_536;
const MAX_SIDE: f32 = 64.0;
/// Where the mean of four squared radiances is no more than this multiple of the squared mean, cells are one light.
const UNEVEN: f32 = 1.1;

/// The emissive textures of a scene, and the triangles that show them.
pub(super) struct EmissionCells<'a> {
    meshes: &'a [Mesh],
    first_faces: &'a [u32],
    materials: &'a [Material],
    records: &'a [TriangleRecord],
    /// How bright the texture of each emissive material is, with its factor.
    tables: BTreeMap<u32, BrightnessTable>,
    /// The number of texels along a cell's edge.
    texels: f32,
}

impl<'a> EmissionCells<'a> {
    /// Of these triangles, which stand still, and of meshes whose first triangles have the indices `first_faces`.
    pub(super) fn new(
        (meshes, first_faces): (&'a [Mesh], &'a [u32]),
        (materials, textures): (&'a [Material], &'a [Texture]),
        records: &'a [TriangleRecord],
    ) -> Self {
        let table = |(number, material): (usize, &Material)| {
            let map = material.emission_map.as_ref()?;
            let brightness = |texel: Vec4| luminance_weight(material.emission * texel.truncate());
            Some((number as u32, textures[map.texture].brightness(map, brightness)))
        };
        let tables = materials.par_iter().enumerate().filter_map(table).collect();
        let mut cells = Self { meshes, first_faces, materials, records, tables, texels: LEAST_TEXELS };
        if !cells.tables.is_empty() {
            let textures = (0..records.len()).into_par_iter().filter_map(|prim| cells.texture(prim));
            let extents: Vec<f32> = textures.map(|(table, map, corners)| table.extent(map, &corners)).collect();
            let count = |texels: f32| extents.iter().map(|&extent| u64::from(side(extent, texels).pow(2))).sum::<u64>();
            while count(cells.texels) > CELLS + extents.len() as u64 {
                cells.texels *= std::f32::consts::SQRT_2;
            }
        }
        cells
    }

    /// The emissive texture of a triangle, and the texture coordinates of its corners.
    fn texture(&self, prim: usize) -> Option<(&BrightnessTable, &'a TextureMap, [Vec2; 3])> {
        let TriangleRecord { mesh: number, material, .. } = *self.records.get(prim)?;
        let table = self.tables.get(&material)?;
        let (map, mesh) = (self.materials[material as usize].emission_map.as_ref()?, &self.meshes[number as usize]);
        let texcoords = mesh.texcoord_set(map.set)?;
        let face = mesh.triangles[prim - self.first_faces[number as usize] as usize];
        Some((table, map, face.map(|corner| texcoords[corner as usize])))
    }

    /// The parts of a triangle that emit; `None` if it has no emissive texture, or moves.
    pub(super) fn emissive_parts(&self, prim: usize) -> Option<EmissiveParts> {
        let (table, map, [a, b, c]) = self.texture(prim)?;
        let side = side(table.extent(map, &[a, b, c]), self.texels);
        let texcoord = |place: Vec2| a + (b - a) * place.x + (c - a) * place.y;
        let radiance = |part: &TrianglePart| table.mean(map, &part.places.map(texcoord));
        let (whole, mut parts) = (TrianglePart::whole(prim as u32), Vec::new());
        if let Some(even) = divide(&whole, side.ilog2(), &radiance, &mut parts) {
            parts.push((whole, even));
        }
        Some(EmissiveParts { division: Division::Congruent { side }, parts })
    }
}

/// The number of cells along the edges of a triangle whose texture has so many texels along the longest of them: a power of
/// two.
fn side(extent: f32, texels: f32) -> u32 {
    ((extent / texels).clamp(1.0, MAX_SIDE).ceil() as u32).next_power_of_two()
}

/// The mean radiance of a part if it emits evenly. Otherwise gives those of its parts that do; the smallest are divided so many
/// times.
fn divide(
    part: &TrianglePart,
    times: u32,
    radiance: &impl Fn(&TrianglePart) -> f32,
    parts: &mut Vec<(TrianglePart, f32)>,
) -> Option<f32> {
    if times == 0 {
        return Some(radiance(part));
    }
    let quarters = part.quarters();
    let known = quarters.map(|quarter| divide(&quarter, times - 1, radiance, parts));
    if let [Some(a), Some(b), Some(c), Some(d)] = known {
        let mean = 0.25 * (a + b + c + d);
        if 0.25 * (a * a + b * b + c * c + d * d) <= UNEVEN * mean * mean {
            return Some(mean);
        }
    }
    let even = quarters.into_iter().zip(known).filter_map(|(quarter, radiance)| Some((quarter, radiance?)));
    parts.extend(even.filter(|(_, radiance)| *radiance > 0.0));
    None
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use crate::light::Light;
    use crate::scene::{CameraPose, Material, Mesh, Scene, Texture, TextureMap};
    use crate::world::World;

    /// Two squares of a square metre: one shows all of a texture, of which a sixteenth is lit, the other a black part.
    fn world(texel: impl Fn(u32, u32) -> [u8; 4]) -> World {
        const SIDE: u32 = 64;
        let square = |x: f32, texcoords: [Vec2; 4]| Mesh {
            positions: [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(y, z)| Vec3::new(x, y, z)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            texcoords: texcoords.to_vec(),
            ..Mesh::default()
        };
        let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        let material =
            Material { emission: Vec3::ONE, emission_map: Some(TextureMap::default()), ..Material::matte(Vec3::ZERO) };
        let camera = CameraPose { eye: Vec3::new(3.0, 0.5, 0.5), target: Vec3::ZERO, up: Vec3::Z, vfov: 60.0 };
        let texels = (0..SIDE * SIDE).map(|index| texel(index % SIDE, index / SIDE));
        World::new(Scene {
            meshes: vec![square(0.0, corners), square(1.0, corners.map(|corner| 0.7 + 0.2 * corner))],
            materials: vec![material],
            textures: vec![Texture::new(SIDE, SIDE, texels.collect())],
            camera: Some(camera),
            ..Scene::default()
        })
        .unwrap()
    }

    fn parts(world: &World) -> Vec<u32> {
        let part = |light: &Light| match light {
            Light::Triangle(part) => Some(part.prim_id),
            _ => None,
        };
        world.lights.lights().iter().filter_map(part).collect()
    }

    #[test]
    fn only_what_is_lit_is_a_light() {
        let world = world(|x, y| if x < 16 && y < 16 { [255; 4] } else { [0, 0, 0, 255] });
        let parts = parts(&world);
        assert!(parts.iter().all(|prim_id| *prim_id < 2), "{parts:?}");
        // Large ones in the lit part, and small ones at its border.
        let of = |prim_id: u32| parts.iter().filter(|part| **part == prim_id).count();
        // All of the same size would be 256 each.
        assert!((32..192).contains(&of(0)) && (32..192).contains(&of(1)), "{} and {}", of(0), of(1));
        let at = |x: f32, y: f32| world.lights.emitter_at(0, Vec2::new(x, y));
        // The triangle's second corner is that of the texture at the right, and its third the lower right one.
        assert_eq!((at(0.9, 0.05), at(0.0, 0.9)), (None, None));
        assert!(at(0.1, 0.05).is_some());
    }

    #[test]
    fn what_emits_evenly_is_not_divided() {
        let speckled = world(|x, y| if (x + y) % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] });
        assert_eq!(parts(&speckled), [0, 1, 2, 3]);
        let black = world(|_, _| [0, 0, 0, 255]);
        assert!(parts(&black).is_empty());
    }
}
