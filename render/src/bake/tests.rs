//! Bakes of small levels whose light is known.

use std::f32::consts::PI;

use glam::{DVec3, Vec3, vec3};

use super::finish::filter::footprint;
use super::*;
use crate::scene::{Material, Mesh, cornell_box};
use crate::settings::GatherLayout;
use crate::watch::NeverStops;
use crate::world::LightQuery;

mod accuracy;
mod layout;
mod outside;
mod seams;
mod shadows;
mod warnings;
mod watching;

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
    Material { emission: Vec3::splat(emission), ..Material::matte(Vec3::splat(diffuse)) }
}

fn baked(scene: &Scene, options: &BakeOptions) -> Bake {
    let atlas = Atlas::new(scene, options).unwrap();
    let world = World::for_light_query(scene.clone(), LightQuery::Surfaces).unwrap();
    bake(scene, &world, atlas, options, &Checkpoint::new(0), &NeverStops).unwrap()
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
        texels.filter(|(_, source)| **source == TexelSource::Light).map(|(value, _)| *value).collect()
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
    let room = hollow("room", Vec3::ZERO, vec3(1.0, 1.2, 0.8), true);
    let furnace = scene(vec![room], vec![glowing(0.5, 0.5)]);
    use GatherLayout::{Hemicube, Stratified};
    use Sampling::{Bicubic, Bilinear};
    for (sampling, brute, layout) in [
        (Bilinear, false, Stratified),
        (Bicubic, false, Hemicube),
        (Bicubic, true, Stratified),
        (Bilinear, true, Hemicube),
    ] {
        let mut options = BakeOptions { sampling, brute, spp: 256, ..quick() };
        (options.cache.rays, options.cache.layout) = (1024, layout);
        let bake = baked(&furnace, &options);
        let values = lit(&bake);
        assert!(values.len() > 2000);
        let squares: f32 = values.iter().map(|value| (value.x / PI - 1.0).powi(2)).sum();
        let error = (squares / values.len() as f32).sqrt();
        assert!(error < 0.015, "{error}");
        // Each texel has noise of its own, or shares that of records with others.
        let (estimate, most) = (bake.error().root_mean_square, if brute { 1.5 } else { 4.0 });
        assert!(estimate > 0.5 * error && estimate < most * error, "{error} is estimated as {estimate}, {layout:?}");
        let (step, pairs) = greatest_step(&furnace, &bake, sampling, true);
        assert!(step < 0.005 && pairs > 500, "{sampling:?}, {layout:?}: {step}");
    }
}

#[test]
fn a_sealed_box_is_dark_inside() {
    let wall = 1e-3;
    let inside = hollow("inside", Vec3::ZERO, Vec3::ONE, true);
    let outside = hollow("outside", Vec3::splat(-wall), Vec3::splat(1.0 + wall), false);
    let mut sealed = scene(vec![inside, outside], vec![glowing(0.0, 0.8)]);
    sealed.sky.radiance = Vec3::splat(1e4);
    let mut hemicube = quick();
    hemicube.cache.layout = GatherLayout::Hemicube;
    let [mut brute, mut brute_hemicube] = [quick(), hemicube.clone()].map(|it| BakeOptions { brute: true, ..it });
    (brute.cache.rays, brute_hemicube.cache.rays) = (128, 128);
    for options in [
        quick(),
        brute_hemicube,
        hemicube,
        BakeOptions { sampling: Sampling::Bicubic, denoise: true, ..brute },
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

#[test]
fn parts_of_light_add_up_and_moments_agree_with_irradiance() {
    // A floor and a lamp that do not touch, so that there are no seams.
    let mut floor = hollow("floor", Vec3::ZERO, Vec3::ONE, true);
    floor.triangles = floor.triangles[4..6].to_vec();
    let mut wall = hollow("wall", vec3(0.1, 0.1, 0.1), vec3(0.9, 0.9, 0.9), true);
    wall.triangles = wall.triangles[0..2].to_vec();
    let mut lamp = hollow("lamp", vec3(0.4, 0.5, 0.4), vec3(0.7, 0.8, 0.6), true);
    (lamp.triangles, lamp.material) = (lamp.triangles[6..8].to_vec(), 1);
    let scene = scene(vec![floor, wall, lamp], vec![glowing(0.0, 0.5), glowing(5.0, 0.2)]);
    let bake = |mode, directional| baked(&scene, &BakeOptions { mode, directional, size: 32, brute: true, ..quick() });
    let [full, direct, indirect] =
        [Mode::Full, Mode::Direct, Mode::Indirect].map(|mode| lit(&bake(mode, Directional::None)));
    for ((full, direct), indirect) in full.iter().zip(direct).zip(indirect) {
        assert!((*full - direct - indirect).abs().max_element() <= 1e-5 * full.max_element().max(1e-3));
    }
    // The normals add up to √3 of the surface's, so that they see together what it sees, and more from the sides.
    let directional = bake(Mode::Full, Directional::Hl2);
    let layers = &directional.maps[0].layers;
    let names: Vec<&str> = layers.iter().map(|layer| layer.name).collect();
    assert_eq!(names, ["", "hl2.0", "hl2.1", "hl2.2"]);
    let (mut sum, mut expected) = (0.0, 0.0);
    for (i, _) in directional.maps[0].sources.iter().enumerate().filter(|(_, source)| **source == TexelSource::Light) {
        expected += layers[0].texels[i].y;
        sum += layers[1..].iter().map(|layer| layer.texels[i].y).sum::<f32>() / 3f32.sqrt();
    }
    assert!((1.0..1.6).contains(&(sum / expected)), "{}", sum / expected);
}

#[test]
fn ambient_occlusion_of_an_open_floor_and_of_a_corner() {
    let room = scene(vec![hollow("room", Vec3::ZERO, Vec3::ONE, true)], vec![glowing(0.0, 0.5)]);
    let options = BakeOptions { mode: Mode::Ao, size: 96, spp: 256, ..BakeOptions::default() };
    assert!(lit(&baked(&room, &options)).iter().all(|open| *open == Vec3::ZERO), "closed");
    let near = baked(&room, &BakeOptions { ao_distance: Some(0.2), ..options });
    let open = lit(&near);
    let most = open.iter().map(|open| open.x).fold(0.0, f32::max);
    let least = open.iter().map(|open| open.x).fold(1.0, f32::min);
    // In an edge half is open, in a corner a quarter.
    assert!(most == 1.0 && (0.2..0.4).contains(&least), "{least} to {most}");
}

/// The irradiance under a disc is `π L r² / (r² + h²)`, and a lamp gets no texels.
#[test]
fn lamps_of_a_scene_file_light_maps_and_are_on_none() {
    let text = "[scene]\nfile = \"room.obj\"\n[[light]]\ntype = \"disc\"\nposition = [0, 1, 0]\n\
        direction = [0, -1, 0]\nradius = 0.5\nradiance = 3";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("room.obj"), "").unwrap();
    let file = crate::scene::SceneFile::parse(&folder.path().join("room.toml"), text).unwrap();
    let floor = Mesh {
        positions: [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]].map(|[x, z]| vec3(x, 0.0, z)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let mut room = scene(vec![floor], vec![glowing(0.0, 0.5)]);
    file.overrides.apply(&mut room).unwrap();
    let bake = baked(&room, &quick());
    assert_eq!(bake.atlas.parts.iter().map(|part| part.mesh).collect::<Vec<_>>(), [0]);
    let most = lit(&bake).iter().map(|light| light.x).fold(0.0, f32::max);
    let expected = PI * 3.0 * 0.25 / 1.25;
    assert!((most / expected - 1.0).abs() < 0.02, "{most}, not {expected}");
}

#[test]
fn own_coordinates_are_kept_repacked_or_replaced() {
    let floor = |x: f32, uv: [f32; 2]| Mesh {
        positions: vec![vec3(x, 0.0, 0.0), vec3(x, 0.0, 1.0), vec3(x + 1.0, 0.0, 1.0), vec3(x + 1.0, 0.0, 0.0)],
        lightmap_texcoords: [[0.1, 0.1], [0.1, 0.4], [0.4, 0.4], [0.4, 0.1]]
            .map(|[u, v]| glam::vec2(u + uv[0], v + uv[1]))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let layouts = |scene: &Scene, options: &BakeOptions| {
        let atlas = Atlas::new(scene, options).unwrap();
        assert!(atlas.check(scene, options).passes());
        let layouts: Vec<atlas::Layout> = atlas.parts.iter().map(|part| part.layout).collect();
        (layouts, atlas)
    };
    use atlas::Layout::{Kept, Repacked, Unwrapped};
    let options = quick();
    let level = |meshes| scene(meshes, vec![glowing(0.0, 0.5)]);
    let good = level(vec![floor(0.0, [0.0, 0.0]), floor(2.0, [0.5, 0.5])]);
    let (found, atlas) = layouts(&good, &options);
    assert_eq!((found, atlas.warnings.len()), (vec![Kept, Kept], 0));
    assert_eq!(atlas.parts[1].vertices[0].uv, glam::vec2(0.6, 0.6));
    // Two meshes with one place.
    let shared = level(vec![floor(0.0, [0.0, 0.0]), floor(2.0, [0.2, 0.2])]);
    let (found, atlas) = layouts(&shared, &options);
    assert_eq!((found, atlas.warnings.len()), (vec![Repacked, Repacked], 1));
    // Folded over itself, out of the page, a line, not a number.
    let mut folded = floor(2.0, [0.5, 0.5]);
    folded.lightmap_texcoords[3] = folded.lightmap_texcoords[1];
    let mut outside = floor(2.0, [0.5, 0.5]);
    outside.lightmap_texcoords[2].x = 1.2;
    let mut line = floor(2.0, [0.5, 0.5]);
    line.lightmap_texcoords.iter_mut().for_each(|uv| uv.x = 0.5);
    let mut broken = floor(2.0, [0.5, 0.5]);
    broken.lightmap_texcoords[0].y = f32::NAN;
    for (mesh, fault) in
        [(folded, "overlap in"), (outside, "not between 0 and 1"), (line, "no area"), (broken, "not finite")]
    {
        let bad = level(vec![floor(0.0, [0.0, 0.0]), mesh]);
        let (found, atlas) = layouts(&bad, &options);
        assert_eq!(found, [Kept, Unwrapped], "{fault}");
        assert!(atlas.warnings[0].contains(fault), "{fault}: {:?}", atlas.warnings);
        let keep = BakeOptions { coordinates: Coordinates::Keep, ..options.clone() };
        assert!(Atlas::new(&bad, &keep).unwrap_err().problem.contains(fault));
    }
    let new = BakeOptions { coordinates: Coordinates::New, ..options };
    assert_eq!(layouts(&good, &new).0, [Unwrapped, Unwrapped]);
}

#[test]
fn pages_are_as_many_as_the_density_takes() {
    let rooms: Vec<Mesh> = (0..4u8)
        .map(|i| hollow("room", Vec3::X * 2.0 * f32::from(i), Vec3::ONE + Vec3::X * 2.0 * f32::from(i), true))
        .collect();
    let level = scene(rooms, vec![glowing(0.0, 0.5)]);
    let options = |density: f32, size| BakeOptions { density: Some(density), size, ..BakeOptions::default() };
    let at = |density: f32, size| Atlas::new(&level, &options(density, size));
    for (density, size) in [(16.0, 64), (16.0, 256), (60.0, 64)] {
        let atlas = at(density, size).unwrap();
        let texels: f32 = atlas.charts.iter().map(|chart| chart.texels).sum();
        let expected = 4.0 * 6.0 * density * density;
        assert!((texels / expected - 1.0).abs() < 0.1, "{density} in {size}: {texels}, not {expected}");
        let check = atlas.check(&level, &options(density, size));
        assert!(check.passes() && check.crowded == 0, "{density} in {size}: {} texels are crowded", check.crowded);
        assert!(atlas.pages.len() as f32 >= expected / (size * size) as f32);
        assert_eq!(atlas.pages.len() == 1, size == 256);
        // A room has one page where it fits on one.
        assert_eq!(atlas.parts.len() == 4, density == 16.0);
    }
    assert!(at(100.0, 64).unwrap_err().problem.contains("and a page has 64x64"));
    assert!(at(0.0, 64).is_err() && at(f32::NAN, 64).is_err());
}
