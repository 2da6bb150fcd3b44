//! Diffuse surfaces whose light is known from what they see.

use super::*;

#[test]
fn a_lamp_over_a_floor_lights_it_by_cosine_and_distance() {
    let intensity = Vec3::new(9.0, 6.0, 3.0);
    let lamp = PunctualLight::Point { position: Vec3::new(0.0, 0.0, 2.0), intensity, radius: 0.0 };
    let reflectance = Vec3::new(0.5, 0.25, 1.0);
    for distance in [0.0, 1.0, 3.0] {
        let at = Vec3::new(distance, 0.0, 0.0);
        let scene = Scene {
            meshes: vec![mesh(&floor(10.0), 0)],
            materials: vec![material(reflectance, Vec3::ZERO)],
            lights: vec![lamp.clone()],
            camera: peephole(at + Vec3::new(0.5, 0.7, 3.0), at),
            ..Scene::default()
        };
        let squared = 4.0 + distance * distance;
        let expected = reflectance * intensity * (2.0 / squared.sqrt() / squared / std::f32::consts::PI);
        let direct = Integrator::Direct(DirectOptions::default());
        let gathered = Integrator::MonteCarlo(MonteCarloOptions { bounces: 2, ..MonteCarloOptions::default() });
        let paths = ALL_LIGHTS.map(|lights| path(lights, Stop::default()));
        for integrator in [direct, gathered].into_iter().chain(paths) {
            let what = format!("{integrator:?} at {distance}");
            all_are(&render(&scene, &settings(integrator, 4)), expected, 1e-3, &what);
        }
    }
}

#[test]
fn an_open_floor_sends_back_its_share_of_the_sky() {
    let (reflectance, sky) = (Vec3::new(0.5, 0.25, 0.9), Vec3::new(1.0, 2.0, 4.0));
    let mut scene = Scene {
        meshes: vec![mesh(&floor(1.0), 0)],
        materials: vec![material(reflectance, Vec3::ZERO)],
        camera: peephole(Vec3::new(0.3, 0.2, 1.0), Vec3::new(0.25, 0.1, 0.0)),
        ..Scene::default()
    };
    scene.sky.radiance = sky;
    let direct = Integrator::Direct(DirectOptions::default());
    let gathered = Integrator::MonteCarlo(MonteCarloOptions::default());
    let paths = ALL_LIGHTS.map(|lights| path(lights, Stop::default()));
    for integrator in [direct, gathered].into_iter().chain(paths) {
        let what = format!("{integrator:?}");
        // Both of Mis's techniques have the same density here: each finds half of the light, in every sample.
        all_are(&render(&scene, &settings(integrator, 4)), reflectance * sky, 1e-5, &what);
    }
    scene.camera = peephole(Vec3::Z, Vec3::Z * 2.0);
    all_are(&render(&scene, &settings(Integrator::Flat, 1)), sky, 0.0, "sky");
    scene.camera = peephole(Vec3::Z, Vec3::ZERO);
    all_are(&render(&scene, &settings(Integrator::Flat, 1)), reflectance, 1e-6, "floor");
}

#[test]
fn openness_beside_a_wall_and_under_a_ceiling() {
    let scene = |walls: &[[[Vec3; 3]; 2]]| Scene {
        meshes: vec![mesh(&[&[floor(1.0)], walls].concat().concat(), 0)],
        materials: vec![Material::default()],
        camera: peephole(Vec3::new(0.3, 0.2, 0.5), Vec3::ZERO),
        ..Scene::default()
    };
    let check = |scene: &Scene, options: AoOptions, expected: f64| {
        let estimate = Estimate::of(&pixels(&render(scene, &settings(Integrator::Ao(options.clone()), 64))));
        let off = (estimate.mean.x - expected).abs();
        assert!(off < 0.003 && off <= 4.0 * estimate.error.x + 1e-5, "{options:?}: {estimate:?}, not {expected}");
    };
    // A wall as high as it is far away, and much wider: 1 - (1 - cos 45°) / 2 of the cosine is left.
    let wall = quad([(-1e4, 0.0), (1e4, 0.0), (1e4, 1.0), (-1e4, 1.0)].map(|(y, z)| Vec3::new(1.0, y, z)));
    for sampling in ALL_SAMPLINGS {
        let options = AoOptions { sampling, rays: 64, ..AoOptions::default() };
        check(&scene(&[]), options.clone(), 1.0);
        check(&scene(&[wall]), options, 0.5 + 0.5 * 0.5f64.sqrt());
    }
    // A ceiling at half of the greatest distance: rays of cos θ < 1/2 end before it, which are 1/4 by the cosine; the
    // others have the length 1 / cos θ of 2: 2 ∫ μ / 2μ dμ from 1/2 to 1.
    let ceiling = storey(1000.0, 1.0);
    let options = AoOptions { max_distance: Some(2.0), rays: 64, ..AoOptions::default() };
    check(&scene(&[ceiling]), options.clone(), 0.25);
    check(&scene(&[ceiling]), AoOptions { weighting: AoWeighting::HitLength, ..options.clone() }, 0.75);
    check(&scene(&[]), AoOptions { weighting: AoWeighting::HitLength, ..options }, 1.0);
}
