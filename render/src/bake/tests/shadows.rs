//! Shadows of direct light.

use super::*;
use crate::scene::{PunctualLight, Sky, SkyPicture};

/// The sun stands over a floor, and a roof with a slanting edge covers a part of it.
#[test]
fn the_edge_of_a_shadow_is_as_soft_as_a_texel_is_wide() {
    let quad = |name: &str, corners: [Vec3; 4]| Mesh {
        name: name.to_owned(),
        positions: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let floor = quad("floor", [vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 0.0)]);
    let edge = |z: f32| 0.4 + 0.2 * z;
    let roof = quad(
        "roof",
        [vec3(-0.1, 0.5, 1.0), vec3(edge(1.0), 0.5, 1.0), vec3(edge(0.0), 0.5, 0.0), vec3(-0.1, 0.5, 0.0)],
    );
    let mut level = scene(vec![floor, roof], vec![glowing(0.0, 0.5)]);
    level.lights.push(PunctualLight::Directional {
        direction: Vec3::NEG_Y,
        irradiance: Vec3::splat(2.0),
        half_angle: 0.0,
    });
    let options = BakeOptions { mode: Mode::Direct, size: 64, ..BakeOptions::default() };
    let bake = baked(&level, &options);
    let world = World::new(level.clone()).unwrap();
    let atlas = &bake.atlas;
    let (mut soft, mut sum, mut area) = (0, 0.0, 0.0);
    for texel in Surfaces::new(&level, atlas).texels() {
        let middle = world.receiver(texel.point.prim_id, texel.point.barycentric).position;
        // Whole texels of the floor.
        if middle.y != 0.0 || texel.coverage < 0.999 {
            continue;
        }
        let found = bake.maps[texel.page as usize].layers[0].texels[texel.index as usize].x / 2.0;
        let points = (0..256).map(|i| [i % 16, i / 16].map(|i| (i as f32 + 0.5) / 16.0 - 0.5));
        let lit = points.filter(|[u, v]| {
            let point = middle + texel.tangents[0] * u + texel.tangents[1] * v;
            point.x > edge(point.z)
        });
        let expected = lit.count() as f32 / 256.0;
        assert!((found - expected).abs() < 0.3, "{found}, not {expected}, at {middle}");
        soft += u32::from((0.1..0.9).contains(&expected));
        sum += found - expected;
        area += 1.0;
    }
    assert!(soft > 20 && area > 1000.0, "{soft} of {area}");
    assert!((sum / area).abs() < 2e-3, "{}", sum / area);
}

/// A picture of a grey sky with a sun of one texel among 8192, which brings three quarters of the light. What an open
/// floor receives is a sum over texels.
#[test]
fn the_sun_of_a_picture_is_sampled_and_the_rest_gathered() {
    const WIDTH: u32 = 128;
    const HEIGHT: u32 = 64;
    let mut texels = vec![Vec3::ONE; (WIDTH * HEIGHT) as usize];
    texels[(12 * WIDTH + 40) as usize] = Vec3::new(6000.0, 5000.0, 4000.0);
    let picture = SkyPicture::new(WIDTH, HEIGHT, texels);
    let cosine = |row: u32| (PI * (row as f32 + 0.5) / HEIGHT as f32).cos();
    let sun = 5000.0 * picture.solid_angle(12) as f32 * cosine(12);
    let mut floor = hollow("floor", Vec3::ZERO, vec3(1.0, 1.0, 1.0), true);
    floor.triangles = floor.triangles[4..6].to_vec();
    let mut level = scene(vec![floor], vec![glowing(0.0, 0.5)]);
    level.sky = Sky { radiance: Vec3::ZERO, picture: Some(picture) };
    let of_mode = |mode, brute| lit(&baked(&level, &BakeOptions { mode, brute, size: 32, ..quick() }));
    for brute in [false, true] {
        let full = of_mode(Mode::Full, brute);
        assert!(full.len() > 500);
        for value in &full {
            assert!((value.y / (PI + sun) - 1.0).abs() < 0.01, "{value}, not {}", PI + sun);
        }
        let parts = of_mode(Mode::Direct, brute).into_iter().zip(of_mode(Mode::Indirect, brute));
        for ((direct, indirect), full) in parts.zip(full) {
            assert!(direct.y > 0.9 * sun && (direct + indirect - full).abs().max_element() < 1e-4 * full.max_element());
        }
    }
}
