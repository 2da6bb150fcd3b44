//! Bakes of small levels whose light is known.

use std::f32::consts::PI;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DVec3, Quat, Vec3, vec3};

use super::filter::footprint;
use super::*;
use crate::scene::{Material, Mesh, cornell_box};

/// Never stops.
struct Patient;

impl Watch for Patient {
    fn advance(&self, _: u64, _: u64) {}

    fn stop(&self) -> bool {
        false
    }
}

/// A box of quads; fronts look inwards or outwards.
fn hollow(name: &str, low: Vec3, high: Vec3, inwards: bool) -> Mesh {
    let mut mesh = Mesh { name: name.to_owned(), ..Mesh::default() };
    for axis in 0..3 {
        for side in [low, high] {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let first = mesh.positions.len() as u32;
            for (a, b) in [(low, low), (high, low), (high, high), (low, high)] {
                let mut corner = Vec3::ZERO;
                (corner[axis], corner[u], corner[v]) = (side[axis], a[u], b[v]);
                mesh.positions.push(corner);
            }
            // Counter-clockwise about the axis: outwards on the high side.
            let outwards = side == high;
            let turn = |[a, b, c]: [u32; 3]| if outwards == inwards { [a, c, b] } else { [a, b, c] };
            mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|triangle| turn(triangle.map(|i: u32| first + i))));
        }
    }
    mesh
}

fn scene(meshes: Vec<Mesh>, materials: Vec<Material>) -> Scene {
    let mut scene = Scene { meshes, materials, ..Scene::default() };
    scene.camera = cornell_box().camera;
    scene
}

fn glowing(emission: f32, diffuse: f32) -> Material {
    Material { emission: Vec3::splat(emission), diffuse: Vec3::splat(diffuse), ..Material::default() }
}

fn baked(scene: &Scene, options: &BakeOptions) -> Bake {
    let atlas = Atlas::new(scene, options).unwrap();
    let world = World::new(scene.clone()).unwrap();
    bake(scene, &world, atlas, options, &Journal::new(0), &Patient).unwrap()
}

/// Options for levels of a few thousand texels.
fn quick() -> BakeOptions {
    let mut options = BakeOptions { size: 64, spp: 64, ..BakeOptions::default() };
    options.cache.rays = 512;
    options
}

/// The light of all texels with light of their own, page by page.
fn lit(bake: &Bake) -> Vec<Vec3> {
    let of_map = |map: &Map| -> Vec<Vec3> {
        let texels = map.layers[0].texels.iter().zip(&map.sources);
        texels.filter(|(_, source)| **source == Source::Light).map(|(value, _)| *value).collect()
    };
    bake.maps.iter().flat_map(of_map).collect()
}

/// The greatest relative step between samples on both sides of the cuts through smooth surfaces, and the number of
/// pairs; with creases those of all edges.
fn greatest_step(scene: &Scene, bake: &Bake, sampling: Sampling, with_creases: bool) -> (f64, usize) {
    let atlas = &bake.atlas;
    let (mut greatest, mut pairs) = (0.0f64, 0);
    for cut in cuts(atlas, scene.meshes.len(), &shared_edges(scene)) {
        if !cut.is_smooth && !with_creases {
            continue;
        }
        // Not where the solver looked.
        for places in [0.05, 0.8].into_iter().flat_map(|offset| cut.places(offset).collect::<Vec<_>>()) {
            let [a, b] = [0, 1].map(|i| {
                let page = cut.sides[i].page;
                let texels = &bake.maps[page].layers[0].texels;
                let footprint = footprint(sampling, atlas.pages[page], places[i]);
                footprint.iter().map(|&(i, weight)| weight * texels[i as usize].as_dvec3()).sum::<DVec3>()
            });
            let mean = 0.5 * (a + b).element_sum();
            greatest = greatest.max((a - b).element_sum().abs() / mean);
            pairs += 1;
        }
    }
    (greatest, pairs)
}

#[test]
fn a_furnace_has_its_light_and_no_steps() {
    let mut room = hollow("room", Vec3::ZERO, vec3(1.0, 1.2, 0.8), true);
    // Another map for each wall, so that edges are cut in every way.
    room.lightmap_texcoords.clear();
    let furnace = scene(vec![room], vec![glowing(0.5, 0.5)]);
    for (sampling, brute) in [(Sampling::Bilinear, false), (Sampling::Bicubic, true)] {
        let mut options = BakeOptions { sampling, brute, spp: 256, ..quick() };
        options.cache.rays = 1024;
        let bake = baked(&furnace, &options);
        let values = lit(&bake);
        assert!(values.len() > 2000);
        let squares: f32 = values.iter().map(|value| (value.x / PI - 1.0).powi(2)).sum();
        let error = (squares / values.len() as f32).sqrt();
        let worst = values.iter().map(|value| (value.x / PI - 1.0).abs()).fold(0.0, f32::max);
        let steps = greatest_step(&furnace, &bake, sampling, true);
        println!("{sampling:?} brute {brute}: error {error} worst {worst} steps {steps:?} {:?}", bake.statistics);
    }
}

/// Half of a ring with a square section, its walls in `segments` flat pieces; light comes from one end.
fn corridor(segments: u32) -> Scene {
    let turned = |step: u32, radius: f32, height: f32| {
        let angle = PI * step as f32 / segments as f32;
        Quat::from_rotation_y(angle) * vec3(radius, height, 0.0)
    };
    let section = [(2.0, 0.0), (3.0, 0.0), (3.0, 1.0), (2.0, 1.0)];
    let mut walls = Mesh { name: "walls".to_owned(), ..Mesh::default() };
    for side in 0..4 {
        let (a, b) = (section[side], section[(side + 1) % 4]);
        let first = walls.positions.len() as u32;
        for step in 0..=segments {
            walls.positions.extend([turned(step, a.0, a.1), turned(step, b.0, b.1)]);
        }
        for step in 0..segments {
            let i = first + 2 * step;
            walls.triangles.extend([[i, i + 1, i + 3], [i, i + 3, i + 2]]);
        }
    }
    let end = |step: u32, name: &str, material: usize| {
        let positions = section.map(|(radius, height)| turned(step, radius, height)).to_vec();
        Mesh { name: name.to_owned(), positions, triangles: vec![[0, 1, 2], [0, 2, 3]], material, ..Mesh::default() }
    };
    let mut scene =
        scene(vec![walls, end(0, "lamp", 1), end(segments, "end", 0)], vec![glowing(0.0, 0.7), glowing(1.0, 0.0)]);
    scene.materials[1].emits_both_sides = true;
    // All fronts look inwards: towards the ring that runs through the middle.
    for mesh in &mut scene.meshes {
        for i in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(i);
            let middle = (a + b + c) / 3.0;
            let inside = (middle * vec3(1.0, 0.0, 1.0)).normalize() * 2.5 + Vec3::Y * 0.5;
            let inside = match mesh.name.as_str() {
                "lamp" => inside + Vec3::NEG_Z * 0.1,
                "end" => inside + Vec3::NEG_Z * 0.1,
                _ => inside,
            };
            if (b - a).cross(c - a).dot(inside - middle) < 0.0 {
                mesh.triangles[i].swap(1, 2);
            }
        }
    }
    scene
}

#[test]
fn a_curved_corridor_has_no_steps() {
    let corridor = corridor(24);
    for sampling in Sampling::ALL {
        let bake = baked(&corridor, &BakeOptions { sampling, ..quick() });
        assert!(lit(&bake).iter().all(|value| value.is_finite() && value.min_element() >= 0.0));
        for by in Sampling::ALL {
            let steps = greatest_step(&corridor, &bake, by, false);
            println!("{sampling:?} sampled {by:?}: {steps:?} {:?}", bake.statistics);
        }
    }
}

#[test]
fn a_sealed_box_is_dark_inside() {
    let wall = 1e-3;
    let inside = hollow("inside", Vec3::ZERO, Vec3::ONE, true);
    let outside = hollow("outside", Vec3::splat(-wall), Vec3::splat(1.0 + wall), false);
    let mut sealed = scene(vec![inside, outside], vec![glowing(0.0, 0.8)]);
    sealed.sky.radiance = Vec3::splat(1e4);
    for options in [
        quick(),
        BakeOptions { brute: true, sampling: Sampling::Bicubic, denoise: true, ..quick() },
        BakeOptions { directional: Directional::Hl2, ..quick() },
    ] {
        let bake = baked(&sealed, &options);
        let mesh_of = |chart: u32| bake.atlas.parts[bake.atlas.charts[chart as usize].part].mesh;
        let (mut dark, mut bright) = (0, 0);
        for map in &bake.maps {
            for layer in &map.layers {
                for (value, &owner) in layer.texels.iter().zip(&map.owners).filter(|(_, owner)| **owner != NO_CHART) {
                    if mesh_of(owner) == 0 {
                        assert_eq!(*value, Vec3::ZERO);
                        dark += 1;
                    } else {
                        assert!(value.x > 0.0);
                        bright += 1;
                    }
                }
            }
        }
        assert!(dark > 1000 && bright > 1000);
    }
}

/// The root mean square and the 99th percentile of relative differences of texels, against the mean of the reference.
fn errors(found: &[Vec3], reference: &[Vec3]) -> (f32, f32) {
    assert_eq!(found.len(), reference.len());
    let mean = reference.iter().map(|value| value.element_sum()).sum::<f32>() / reference.len() as f32;
    let mut relative: Vec<f32> = found
        .iter()
        .zip(reference)
        .map(|(found, reference)| (*found - *reference).element_sum().abs() / reference.element_sum().max(0.1 * mean))
        .collect();
    let squares: f32 = relative.iter().map(|error| error * error).sum();
    relative.sort_by(f32::total_cmp);
    ((squares / relative.len() as f32).sqrt(), relative[relative.len() * 99 / 100])
}

#[test]
fn a_cache_tells_what_gathers_do() {
    let scene = cornell_box();
    let mut options = BakeOptions { size: 128, spp: 16, ..BakeOptions::default() };
    options.cache.rays = 2048;
    let full = baked(&scene, &BakeOptions { brute: true, ..options.clone() });
    for error in [0.2, 0.3, 0.45, 0.6, 0.8, 1.0] {
        options.cache.error = error;
        let cached = baked(&scene, &options);
        let share = cached.statistics.gathers as f64 / full.statistics.gathers as f64;
        println!("{error}: {share} {:?} {:?}", errors(&lit(&cached), &lit(&full)), cached.statistics);
    }
}
