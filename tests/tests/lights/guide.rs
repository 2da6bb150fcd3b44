//! A room that is lit through a gap: guided paths find it more often, with the same light on average.

use glam::{DVec3, Vec3};
use halfdome::material::Inputs;
use halfdome::scene::{CameraPose, Material, Scene};
use halfdome::settings::{Integrator, PathOptions, Settings};
use halfdome_tests::render::{Estimate, material, mesh, pixels, quad, render, seeds};

const SIZE: u32 = 16;

/// A room of 4 by 3 by 4 metres with a gap of 30 cm in its ceiling, below a large lamp, and a shelf of another material.
fn room(shelf: Material) -> Scene {
    let at = |x: f32, y: f32, z: f32| Vec3::new(4.0 * x, 3.0 * y, 4.0 * z);
    let corners = [0.0, 1.0].map(|x| [0.0, 1.0].map(|y| [0.0, 1.0].map(|z| at(x, y, z))));
    let [[[a, b], [c, d]], [[e, f], [g, h]]] = corners;
    let walls = [[a, e, f, b], [a, b, d, c], [e, g, h, f], [a, c, g, e], [b, f, h, d]].map(quad).concat();
    let ceiling = |[left, near]: [f32; 2], [right, far]: [f32; 2]| {
        let at = |x: f32, z: f32| Vec3::new(x, 3.0, z);
        quad([at(left, near), at(right, near), at(right, far), at(left, far)])
    };
    let around = [ceiling([0.0, 0.0], [3.2, 4.0]), ceiling([3.5, 0.0], [4.0, 4.0])];
    let board = [[1.0, 1.0], [3.0, 1.0], [3.0, 2.5], [1.0, 2.5]].map(|[x, z]| Vec3::new(x, 0.8, z));
    let lamp = ceiling([-6.0, -6.0], [10.0, 10.0]).map(|triangle| triangle.map(|corner| corner + Vec3::Y));
    let (shown, white) = (mesh(&quad(board), 1), mesh(&around.concat(), 0));
    Scene {
        meshes: vec![mesh(&walls, 0), white, shown, mesh(&lamp, 2)],
        materials: vec![
            material(Vec3::new(0.7, 0.6, 0.5), Vec3::ZERO),
            shelf,
            material(Vec3::ZERO, Vec3::new(2.0, 3.0, 4.0)),
        ],
        camera: Some(CameraPose {
            eye: Vec3::new(0.3, 1.6, 0.4),
            target: Vec3::new(2.5, 0.8, 2.0),
            up: Vec3::Y,
            vfov: 70.0,
        }),
        ..Scene::default()
    }
}

fn settings(guide: Option<u32>, seed: u64) -> Settings {
    let integrator = Integrator::Path(PathOptions { guide, ..PathOptions::default() });
    Settings { width: SIZE, height: SIZE, spp: 32, seed, integrator, ..Settings::default() }
}

/// Of each quarter of the picture its mean, and of all pixels the sum of variances.
fn statistics(scene: &Scene, guide: Option<u32>) -> (Vec<Estimate>, f64) {
    let renders = seeds(scene, &settings(guide, 0), 8);
    let side = SIZE as usize;
    let quarter = |pixels: &[DVec3], number: usize| {
        let is_there = |i: usize| (i % side / (side / 2)) + 2 * (i / side / (side / 2)) == number;
        let there = (0..pixels.len()).filter(|&i| is_there(i)).map(|i| pixels[i]);
        there.sum::<DVec3>() / (pixels.len() / 4) as f64
    };
    let means =
        (0..4).map(|number| Estimate::of(&renders.iter().map(|pixels| quarter(pixels, number)).collect::<Vec<_>>()));
    let variance = |i: usize| {
        let estimate = Estimate::of(&renders.iter().map(|pixels| pixels[i]).collect::<Vec<_>>());
        (estimate.error * estimate.error).element_sum()
    };
    (means.collect(), (0..side * side).map(variance).sum())
}

#[test]
fn guided_paths_find_the_same_light_with_less_noise() {
    let glossy = Inputs { base_color: Vec3::splat(0.4), specular_weight: 1.0, ..Inputs::DEFAULT };
    let metal = Inputs { base_color: Vec3::splat(0.8), base_metalness: 1.0, specular_roughness: 0.3, ..glossy };
    let mirror = Inputs { specular_roughness: 0.0, ..metal };
    let sheet = Inputs { diffuse_transmission_weight: 0.5, diffuse_transmission_color: Vec3::ONE, ..glossy };
    let coated = Inputs { coat_weight: 1.0, coat_roughness: 0.1, ..glossy };
    for (name, inputs) in
        [("glossy", glossy), ("metal", metal), ("mirror", mirror), ("sheet", sheet), ("coated", coated)]
    {
        let scene = room(Material { inputs, ..Material::default() });
        let (plain, variance) = statistics(&scene, None);
        let (guided, guided_variance) = statistics(&scene, Some(1 << 17));
        for (plain, guided) in plain.iter().zip(&guided) {
            let z = plain.z(guided, 1e-3).max_element();
            assert!(z < 4.5, "{name}: {plain:?} and {guided:?}, z {z}");
        }
        let gain = variance / guided_variance;
        assert!(gain > 1.1, "{name}: the variance is {gain} times lower");
    }
}

#[test]
fn guided_pictures_do_not_depend_on_threads() {
    let scene = room(Material::matte(Vec3::splat(0.5)));
    let picture = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| pixels(&render(&scene, &settings(Some(1 << 14), 3))))
    };
    let one = picture(1);
    assert!(one == picture(2) && one == picture(7));
    assert!(one != pixels(&render(&scene, &settings(None, 3))), "nothing is guided");
}
