//! Light of emissive textures, whose lit parts are lights of their own: against squares in their places that emit evenly.

use glam::{Affine2, Vec2, Vec3};
use halfdome::scene::{Material, Mesh, Scene, Texture, TextureFilter, TextureMap, Wrap};
use halfdome::settings::Settings;
use halfdome_tests::render::{Estimate, material, mesh, quad, seeds};

use crate::panes_everywhere::integrators;
use crate::{means, plane, settings};

/// Texels along each edge, and squares along each edge of the panel, which shows the texture more than once.
const TEXELS: usize = 32;
const TIMES: usize = 3;
const SQUARES: usize = TIMES * TEXELS;
/// What is lit of the texture: from one texel to before another.
const LIT: [[usize; 4]; 3] = [[3, 5, 13, 12], [20, 20, 24, 30], [28, 0, 32, 4]];
const EMISSION: Vec3 = Vec3::new(40.0, 20.0, 10.0);

fn is_lit(column: usize, row: usize) -> bool {
    LIT.iter().any(|&[left, top, right, bottom]| (left..right).contains(&column) && (top..bottom).contains(&row))
}

/// The point of the panel that is so far across and down, as parts of its edges. The panel faces down.
fn point(place: Vec2) -> Vec3 {
    Vec3::new(3.0 * place.x - 1.0, 1.0, 2.0 * place.y - 0.5)
}

/// A part of the panel, from one corner to the other.
fn part(low: Vec2, high: Vec2) -> [[Vec3; 3]; 2] {
    let [a, b, c, d] = [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)].map(point);
    [[a, b, c], [a, c, d]]
}

/// A plane below a panel with a texture.
fn textured(wrap: Wrap) -> Scene {
    let mut scene = plane();
    let texel = |i: usize| if is_lit(i % TEXELS, i / TEXELS) { [255; 4] } else { [0, 0, 0, 255] };
    scene.textures = vec![Texture::new(TEXELS as u32, TEXELS as u32, (0..TEXELS * TEXELS).map(texel).collect())];
    let map = TextureMap {
        transform: Affine2::from_scale(Vec2::splat(TIMES as f32)),
        wrap: [wrap; 2],
        filter: TextureFilter::Nearest,
        ..TextureMap::default()
    };
    scene.materials.push(Material { emission_map: Some(map), ..material(Vec3::ZERO, EMISSION) });
    let panel = mesh(&part(Vec2::ZERO, Vec2::ONE), 1);
    let texcoords = panel.positions.iter().map(|at| Vec2::new((at.x + 1.0) / 3.0, (at.z + 0.5) / 2.0)).collect();
    scene.meshes.push(Mesh { texcoords, ..panel });
    scene
}

/// The same of squares.
fn squares(wrap: Wrap) -> Scene {
    let mut scene = plane();
    scene.materials.push(material(Vec3::ZERO, EMISSION));
    let texel = |place: usize| match wrap {
        Wrap::Repeat => place % TEXELS,
        Wrap::Mirror => (place % (2 * TEXELS)).min(2 * TEXELS - 1 - place % (2 * TEXELS)),
        Wrap::Clamp => place.min(TEXELS - 1),
    };
    let at = |place: usize| Vec2::new((place % SQUARES) as f32, (place / SQUARES) as f32);
    let lit = (0..SQUARES * SQUARES).filter(|place| is_lit(texel(place % SQUARES), texel(place / SQUARES)));
    let lit = lit.flat_map(|place| part(at(place) / SQUARES as f32, (at(place) + 1.0) / SQUARES as f32));
    scene.meshes.push(mesh(&lit.collect::<Vec<_>>(), 1));
    scene
}

#[test]
fn lit_parts_of_textures_light_as_squares_do() {
    for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
        let [textured, squares] = [textured(wrap), squares(wrap)];
        for (name, integrator) in integrators() {
            let [found, expected] = [&textured, &squares].map(|scene| Estimate::of(&means(scene, &integrator, 16)));
            let z = found.z(&expected, 2e-3).max_element();
            let off = ((found.mean - expected.mean) / expected.mean).abs().max_element();
            assert!(z < 4.5 && off < 0.02, "{name}, {wrap:?}: {found:?}, not {expected:?}; z {z}, off {off}");
        }
    }
}

/// An eighth of the panel is lit: as one light it would have eight times the variance.
#[test]
fn light_samples_go_to_the_lit_parts() {
    let [(_, direct), ..] = integrators();
    let scene = textured(Wrap::Repeat);
    let seeds = seeds(&scene, &Settings { spp: 1, integrator: direct, ..settings() }, 512);
    let variance = |pixel: usize| {
        let values = || seeds.iter().map(|pixels| pixels[pixel].y);
        let mean = values().sum::<f64>() / seeds.len() as f64;
        values().map(|value| (value / mean - 1.0).powi(2)).sum::<f64>() / seeds.len() as f64
    };
    let pixels = seeds[0].len();
    let variance = (0..pixels).map(variance).sum::<f64>() / pixels as f64;
    assert!(variance < 2.0, "{variance}");
}

/// Parts that are large and near are sampled by solid angle: a wall of which the left half glows.
#[test]
fn large_parts_light_what_is_near_as_a_square_does() {
    let wall = |right: f32| {
        let [left, right] = [-1.0, right];
        let corners = [[left, 0.0], [right, 0.0], [right, 0.6], [left, 0.6]].map(|[x, y]| Vec3::new(x, y, 0.7));
        mesh(&quad(corners), 1)
    };
    let mut textured = plane();
    let texel = |i: usize| if i % 4 < 2 { [255; 4] } else { [0, 0, 0, 255] };
    textured.textures = vec![Texture::new(4, 4, (0..16).map(texel).collect())];
    let map = TextureMap { filter: TextureFilter::Nearest, ..TextureMap::default() };
    let mut square = plane();
    square.materials.push(material(Vec3::ZERO, EMISSION));
    textured.materials.push(Material { emission_map: Some(map), ..material(Vec3::ZERO, EMISSION) });
    square.meshes.push(wall(0.0));
    let whole = wall(1.0);
    let texcoords = whole.positions.iter().map(|at| Vec2::new(0.5 * (at.x + 1.0), at.y)).collect();
    textured.meshes.push(Mesh { texcoords, ..whole });
    for (name, integrator) in integrators() {
        let [found, expected] = [&textured, &square].map(|scene| Estimate::of(&means(scene, &integrator, 32)));
        let z = found.z(&expected, 1e-3).max_element();
        let off = ((found.mean - expected.mean) / expected.mean).abs().max_element();
        assert!(z < 4.5 && off < 0.01, "{name}: {found:?}, not {expected:?}; z {z}, off {off}");
    }
}
