//! Direct light on a plane against closed forms: lights without a surface, the sky, and Lambert's polygon formula.

mod guide;
mod lit_parts;
mod long;
mod openings;
mod panes;
mod panes_everywhere;
mod picture_sun;
mod profiles;
mod secondary;
mod sizes;
mod tables;
mod textured;

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use halfdome::scene::{CameraPose, LightOverrides, Overrides, PunctualLight, Scene, Sky, SkyPicture, SpotEdge};
use halfdome::settings::{Integrator, Settings};
use halfdome_tests::render::{Estimate, material, mean, mesh, pixels, quad, render, seeds, view};

const REFLECTANCE: Vec3 = Vec3::new(0.25, 0.5, 0.9);
const SIZE: (u32, u32) = (8, 6);

/// A horizontal square of this half side at a height, with its front up.
fn square(half: f32, y: f32) -> [[Vec3; 3]; 2] {
    let at = |x: f32, z: f32| Vec3::new(x * half, y, z * half);
    quad([at(-1.0, 1.0), at(1.0, 1.0), at(1.0, -1.0), at(-1.0, -1.0)])
}

/// The plane y = 0, from above at a slant; all of the picture shows it.
fn plane() -> Scene {
    let camera =
        CameraPose { eye: Vec3::new(0.5, 1.0, 4.0), target: Vec3::new(0.0, 0.0, 1.0), up: Vec3::Y, vfov: 20.0 };
    Scene {
        meshes: vec![mesh(&square(20.0, 0.0), 0)],
        materials: vec![material(REFLECTANCE, Vec3::ZERO)],
        camera: Some(camera),
        ..Scene::default()
    }
}

fn settings() -> Settings {
    Settings { width: SIZE.0, height: SIZE.1, spp: 64, ..Settings::default() }
}

/// The means of pictures of so many seeds.
fn means(scene: &Scene, integrator: &Integrator, count: u64) -> Vec<DVec3> {
    let renders = seeds(scene, &Settings { integrator: integrator.clone(), ..settings() }, count);
    renders.iter().map(|pixels| mean(pixels)).collect()
}

/// The means over pixels of `radiance` at the height `y`, where the camera sees it.
fn expected(scene: &Scene, y: f64, radiance: impl Fn(DVec3) -> DVec3) -> Vec<DVec3> {
    const STEPS: u32 = 24;
    let camera = scene.camera.unwrap();
    let eye = camera.eye.as_dvec3();
    let at = |x: f64, row: f64| {
        let direction = view(&camera, SIZE, x, row);
        radiance(eye + direction * ((y - eye.y) / direction.y))
    };
    let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(STEPS);
    let pixel = |x: u32, row: u32| {
        let points =
            (0..STEPS * STEPS).map(|i| at(f64::from(x) + middle(i % STEPS), f64::from(row) + middle(i / STEPS)));
        points.sum::<DVec3>() / f64::from(STEPS * STEPS)
    };
    (0..SIZE.1).flat_map(|row| (0..SIZE.0).map(move |x| (x, row))).map(|(x, row)| pixel(x, row)).collect()
}

/// Renders with many seeds; every pixel's mean is `expected`.
fn check(scene: &Scene, expected: &[DVec3], closeness: f64) {
    check_settings(scene, &settings(), expected, closeness);
}

fn check_settings(scene: &Scene, settings: &Settings, expected: &[DVec3], closeness: f64) {
    let renders = seeds(scene, settings, 48);
    for (i, &expected) in expected.iter().enumerate() {
        let values: Vec<DVec3> = renders.iter().map(|pixels| pixels[i]).collect();
        let estimate = Estimate::of(&values);
        // The quadrature that gives the expected value is good to a thousandth.
        let z = estimate.z(&expected.into(), 1e-3).max_element();
        let off = (estimate.mean - expected).abs().max_element() / expected.max_element();
        assert!(z < 4.5 && off < closeness, "pixel {i}: {estimate:?}, not {expected}; z {z}");
    }
}

/// Radiance that the plane reflects of an irradiance.
fn reflected(irradiance: DVec3) -> DVec3 {
    REFLECTANCE.as_dvec3() / PI * irradiance
}

const INTENSITY: Vec3 = Vec3::new(10.0, 20.0, 30.0);
const POSITION: Vec3 = Vec3::new(0.4, 1.5, 0.8);

#[test]
fn a_point_light_falls_off_by_the_inverse_square_and_the_cosine() {
    let mut scene = plane();
    scene.lights = vec![PunctualLight::Point { position: POSITION, intensity: INTENSITY, radius: 0.0 }];
    let irradiance = |point: DVec3| {
        let to_light = POSITION.as_dvec3() - point;
        INTENSITY.as_dvec3() * to_light.y / to_light.length().powi(3)
    };
    check(&scene, &expected(&scene, 0.0, |point| reflected(irradiance(point))), 0.002);
}

#[test]
fn a_light_below_the_plane_or_behind_a_screen_lights_nothing() {
    let mut scene = plane();
    scene.lights = vec![
        PunctualLight::Point { position: -POSITION, intensity: INTENSITY, radius: 0.0 },
        PunctualLight::Directional { direction: Vec3::Y, irradiance: Vec3::ONE, half_angle: 0.0 },
    ];
    assert!(pixels(&render(&scene, &settings())).iter().all(|&pixel| pixel == DVec3::ZERO));
    scene.lights = vec![
        PunctualLight::Point { position: Vec3::Y * 3.0, intensity: INTENSITY, radius: 0.0 },
        PunctualLight::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::ONE, half_angle: 0.0 },
    ];
    assert!(pixels(&render(&scene, &settings())).iter().all(|&pixel| pixel.min_element() > 0.0));
    // Black, so that it does not reflect what the plane sends up.
    scene.materials.push(material(Vec3::ZERO, Vec3::ZERO));
    scene.meshes.push(mesh(&square(20.0, 2.0), 1));
    assert!(pixels(&render(&scene, &settings())).iter().all(|&pixel| pixel == DVec3::ZERO));
}

#[test]
fn a_directional_light_gives_its_irradiance_times_the_cosine() {
    let mut scene = plane();
    let direction = Vec3::new(3.0, -4.0, 0.0) / 5.0;
    scene.lights = vec![PunctualLight::Directional { direction, irradiance: INTENSITY, half_angle: 0.0 }];
    let radiance = reflected(INTENSITY.as_dvec3() * 0.8);
    for pixel in pixels(&render(&scene, &settings())) {
        assert!((pixel - radiance).abs().max_element() < 1e-6 * radiance.max_element(), "{pixel}, not {radiance}");
    }
}

/// Full within the inner cone, zero outside the outer one, and between them the square of a ramp in the cosine, as
/// `KHR_lights_punctual` has it, or a smoothstep, as Blender has it.
#[test]
fn a_spot_light_fades_between_its_cones() {
    check_spot(SpotEdge::Square, |ramp| ramp * ramp);
    check_spot(SpotEdge::Smooth, |ramp| ramp * ramp * (3.0 - 2.0 * ramp));
}

fn check_spot(edge: SpotEdge, part: impl Fn(f64) -> f64) {
    let mut scene = plane();
    let direction = Vec3::new(-0.3, -1.0, 0.2).normalize();
    let (inner, outer) = (0.3f32.cos(), 0.9f32.cos());
    scene.lights = vec![PunctualLight::Spot {
        position: POSITION,
        direction,
        intensity: INTENSITY,
        radius: 0.0,
        cos_inner: inner,
        cos_outer: outer,
        edge,
    }];
    let irradiance = |point: DVec3| {
        let to_light = POSITION.as_dvec3() - point;
        let cosine = -to_light.normalize().dot(direction.as_dvec3());
        let ramp = ((cosine - f64::from(outer)) / f64::from(inner - outer)).clamp(0.0, 1.0);
        INTENSITY.as_dvec3() * (to_light.y / to_light.length().powi(3) * part(ramp))
    };
    let expected = expected(&scene, 0.0, |point| reflected(irradiance(point)));
    let dark = expected.iter().filter(|pixel| **pixel == DVec3::ZERO).count();
    let full = expected.iter().filter(|pixel| pixel.max_element() > 1.0).count();
    assert!(dark > 3 && full > 3, "the picture shows cone and darkness: {dark} {full}");
    let lit: Vec<_> = pixels(&render(&scene, &settings()));
    for (pixel, expected) in lit.iter().zip(&expected) {
        // The film's samples differ from the quadrature where the light fades.
        let off = (pixel - expected).abs().max_element();
        assert!(off <= 0.02 * expected.max_element() + 2e-3, "{pixel}, not {expected}");
    }
    assert!(lit.iter().filter(|pixel| **pixel == DVec3::ZERO).count() == dark);
}

#[test]
fn several_lights_add_up() {
    let mut scene = plane();
    let positions = [POSITION, Vec3::new(-1.0, 0.7, 1.5), Vec3::new(2.0, 3.0, -1.0)];
    let intensities = [INTENSITY, Vec3::new(1.0, 0.1, 0.0), Vec3::new(0.0, 0.0, 50.0)];
    scene.lights = core::iter::zip(positions, intensities)
        .map(|(position, intensity)| PunctualLight::Point { position, intensity, radius: 0.0 })
        .collect();
    scene.lights.push(PunctualLight::Directional {
        direction: Vec3::NEG_Y,
        irradiance: Vec3::new(2.0, 1.0, 0.5),
        half_angle: 0.0,
    });
    let irradiance = |point: DVec3| {
        let of = |(position, intensity): (Vec3, Vec3)| {
            let to_light = position.as_dvec3() - point;
            intensity.as_dvec3() * to_light.y / to_light.length().powi(3)
        };
        core::iter::zip(positions, intensities).map(of).sum::<DVec3>() + DVec3::new(2.0, 1.0, 0.5)
    };
    check(&scene, &expected(&scene, 0.0, |point| reflected(irradiance(point))), 0.1);
}

#[test]
fn under_a_constant_sky_a_plane_has_its_reflectance_times_the_sky() {
    let mut scene = plane();
    scene.sky = Sky::constant(Vec3::new(0.5, 1.0, 3.0));
    let radiance = (REFLECTANCE * scene.sky.radiance).as_dvec3();
    for pixel in pixels(&render(&scene, &settings())) {
        assert!((pixel - radiance).abs().max_element() < 1e-6, "{pixel}, not {radiance}");
    }
    scene.camera.as_mut().unwrap().target = Vec3::new(0.0, 9.0, 0.0);
    for pixel in pixels(&render(&scene, &settings())) {
        assert_eq!(pixel, scene.sky.radiance.as_dvec3());
    }
}

/// A picture of a constant sky is sampled otherwise than the sky itself, and lights alike; so does one in which all
/// light comes from a cap of 45 degrees about the zenith, whose irradiance would be `π L sin² 45°` if its border were
/// sharp.
#[test]
fn a_picture_lights_as_its_sky_does() {
    let radiance = Vec3::new(0.5, 1.0, 3.0);
    let cap: Vec<Vec3> = (0..32 * 16).map(|texel| if texel < 32 * 4 { 2.0 * radiance } else { Vec3::ZERO }).collect();
    // Between the middles of the rows beside it light falls from 1 to a half and to 0, evenly by solid angle.
    let border = |row: f64| (PI * row / 16.0).cos();
    let middles = [3.0, 4.0].map(|row| 0.5 * (border(row) + border(row + 1.0)));
    let product = |[c, d]: [f64; 2], [v, w]: [f64; 2]| (c - d) * (2.0 * (c * v + d * w) + c * w + d * v) / 6.0;
    let whole = 0.5 * (1.0 - middles[0] * middles[0]);
    let halves = product([middles[0], border(4.0)], [1.0, 0.5]) + product([border(4.0), middles[1]], [0.5, 0.0]);
    for (picture, constant, part) in [
        (SkyPicture::new(4, 2, vec![radiance; 8]), Vec3::ZERO, 1.0),
        (SkyPicture::new(3, 5, vec![0.75 * radiance; 15]).turned(40.0), 0.25 * radiance, 1.0),
        (SkyPicture::new(32, 16, cap), Vec3::ZERO, 4.0 * (whole + halves)),
    ] {
        let reflected = vec![(REFLECTANCE * radiance).as_dvec3() * part; (SIZE.0 * SIZE.1) as usize];
        let mut scene = plane();
        scene.sky = Sky { radiance: constant, picture: Some(picture) };
        check(&scene, &reflected, 0.1);
    }
}

/// Irradiance at a point with the normal `n` from a polygon of radiance one that faces it, wholly above the horizon:
/// half the sum over edges of the angle that the edge subtends, times the cosine between `n` and the normal of the
/// edge's triangle with the point (Lambert, "Photometria", 1760).
fn form_factor(point: DVec3, n: DVec3, polygon: &[DVec3]) -> f64 {
    let edges = (0..polygon.len()).map(|i| [polygon[i] - point, polygon[(i + 1) % polygon.len()] - point]);
    let sum: f64 = edges.map(|[a, b]| a.angle_between(b) * a.cross(b).normalize().dot(n)).sum();
    sum.abs() / 2.0
}

/// A lamp above the plane that faces down, and its corners.
fn lamp(scene: &mut Scene) -> Vec<DVec3> {
    let [a, b, c, d] = [[-0.5, 1.2, 0.1], [0.6, 1.2, 0.1], [0.6, 1.2, 1.0], [-0.5, 1.2, 1.0]].map(Vec3::from);
    scene.materials.push(material(Vec3::ZERO, EMISSION));
    scene.meshes.push(mesh(&quad([a, b, c, d]), 1));
    [a, b, c, d].map(|p| p.as_dvec3()).to_vec()
}

const EMISSION: Vec3 = Vec3::new(3.0, 2.0, 1.0);

#[test]
fn a_lamp_lights_the_plane_by_lamberts_formula() {
    let mut scene = plane();
    let corners = lamp(&mut scene);
    let radiance = |point| reflected(EMISSION.as_dvec3() * form_factor(point, DVec3::Y, &corners));
    check(&scene, &expected(&scene, 0.0, radiance), 0.03);
}

fn emission(emits_both_sides: Option<bool>) -> Overrides {
    Overrides { light: LightOverrides { emits_both_sides, ..Default::default() }, ..Default::default() }
}

#[test]
fn the_back_of_a_lamp_is_dark_unless_both_sides_emit() {
    // A ceiling above the lamp that alone can see its back, and a camera between lamp and ceiling.
    let mut scene = plane();
    let corners = lamp(&mut scene);
    let ceiling = square(20.0, 2.0).map(|[a, b, c]| [a, c, b]);
    scene.meshes = vec![mesh(&ceiling, 0), scene.meshes.pop().unwrap()];
    let camera =
        CameraPose { eye: Vec3::new(0.0, 1.5, 3.0), target: Vec3::new(0.0, 2.0, 1.0), up: Vec3::Y, vfov: 12.0 };
    scene.camera = Some(camera);
    assert!(pixels(&render(&scene, &settings())).iter().all(|&pixel| pixel == DVec3::ZERO));

    emission(Some(true)).apply(&mut scene).unwrap();
    assert_eq!(scene.camera, Some(camera));
    let radiance = |point| reflected(EMISSION.as_dvec3() * form_factor(point, DVec3::NEG_Y, &corners));
    check(&scene, &expected(&scene, 2.0, radiance), 0.03);

    // Seen from above, the lamp itself.
    scene.meshes.remove(0);
    scene.camera =
        Some(CameraPose { eye: Vec3::new(0.0, 2.0, 0.5), target: Vec3::new(0.0, 0.0, 0.5), up: Vec3::X, vfov: 10.0 });
    for (both, seen) in [(true, EMISSION), (false, Vec3::ZERO)] {
        emission(Some(both)).apply(&mut scene).unwrap();
        assert!(pixels(&render(&scene, &settings())).iter().all(|&pixel| pixel == seen.as_dvec3()), "{both}");
    }
}
