//! Lights with a size: spheres that shine, spots too, and suns with a disc.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec3, Vec3};
use halfdome::irradiance::{Part, Request, Sensor, by_paths};
use halfdome::scene::{CameraPose, PunctualLight, Scene, SpotEdge};
use halfdome::world::World;
use halfdome_tests::render::{NeverStops, material, mesh, quad};

const INTENSITY: f32 = 8.0;

/// Irradiance at a sensor at the origin with this normal, below a black screen whose edge is the line x = 0, z = 1, or
/// none.
fn irradiance(light: PunctualLight, normal: Vec3, screen: bool) -> f64 {
    let far = if screen { 1.0 } else { -1.0 };
    let corners = [[0.0, -9.0], [9.0, -9.0], [9.0, 9.0], [0.0, 9.0]].map(|[x, y]| Vec3::new(x, y, far));
    let scene = Scene {
        meshes: vec![mesh(&quad(corners), 0)],
        materials: vec![material(Vec3::ZERO, Vec3::ZERO)],
        lights: vec![light],
        camera: Some(CameraPose { eye: Vec3::X, target: Vec3::ZERO, up: Vec3::Z, vfov: 40.0 }),
        ..Scene::default()
    };
    let world = World::new(scene).unwrap();
    let sensors = [Sensor { position: Vec3::ZERO, normal: normal.normalize() }];
    let request = Request { spp: 1 << 14, seed: 3, part: Part::Total };
    f64::from(by_paths(&world, &sensors, &request, &NeverStops).values[0].x)
}

fn sphere(position: Vec3, radius: f32) -> PunctualLight {
    PunctualLight::Point { position, intensity: Vec3::splat(INTENSITY), radius }
}

pub(super) fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found}, not {expected}");
}

/// `π L sin² θ_max cos θ`, which is that of a delta light of the same intensity.
#[test]
fn spheres_above_the_horizon_light_as_points_do() {
    let place = Vec3::new(0.5, 0.2, 2.0);
    for normal in [Vec3::Z, Vec3::new(1.0, -0.5, 1.0)] {
        let cosine = f64::from(normal.normalize().dot(place.normalize()));
        let expected = f64::from(INTENSITY) * cosine / f64::from(place.length_squared());
        for radius in [0.0, 1e-7, 1e-3, 0.1, 0.9] {
            close(irradiance(sphere(place, radius), normal, false), expected, 1e-3, &format!("radius {radius}"));
        }
    }
}

#[test]
fn within_a_sphere_light_comes_from_everywhere() {
    let expected = f64::from(INTENSITY) / 4.0;
    close(irradiance(sphere(Vec3::new(0.3, 0.4, 1.0), 2.0), Vec3::X, false), expected, 3e-3, "inside");
}

/// The horizon, or the edge of a screen, through the middle of a disc leaves half of it.
#[test]
fn halves_are_halves() {
    let above = Vec3::Z * 3.0;
    let whole = f64::from(INTENSITY) / 9.0;
    close(irradiance(sphere(above, 0.5), Vec3::Z, true), 0.5 * whole, 3e-3, "half of a sphere behind a screen");
    assert_eq!(irradiance(sphere(Vec3::new(0.5, 0.0, 3.0), 0.0), Vec3::Z, true), 0.0, "a delta light behind it");
    let half_angle = 0.3;
    let sun = PunctualLight::Directional { direction: Vec3::NEG_Z, irradiance: Vec3::splat(5.0), half_angle };
    close(irradiance(sun.clone(), Vec3::Z, false), 5.0, 1e-3, "a sun");
    close(irradiance(sun.clone(), Vec3::new(0.5, 0.0, 1.0), false), 5.0 / 1.25f64.sqrt(), 1e-3, "a sun at a slant");
    close(irradiance(sun.clone(), Vec3::Z, true), 2.5, 3e-3, "half of a sun");
    // A disc that is cut by the horizon: 2 L ∫ sin θ cos²… in closed form is (α - sin α cos α) L.
    let (sin, cos) = f64::from(half_angle).sin_cos();
    let expected = 5.0 / (std::f64::consts::PI * sin * sin) * (f64::from(half_angle) - sin * cos);
    close(irradiance(sun, Vec3::X, false), expected, 3e-3, "a sun on the horizon");
}

/// The cone of a spot is one of directions; the integral over its disc is by quadrature.
#[test]
fn spots_with_a_radius_have_a_soft_edge() {
    let (position, direction) = (Vec3::new(0.6, 0.0, 2.0), Vec3::NEG_Z);
    let (cos_inner, cos_outer) = (0.3f32.cos(), 0.32f32.cos());
    for (radius, edge) in [(0.05, SpotEdge::Square), (0.3, SpotEdge::Smooth), (0.6, SpotEdge::Square)] {
        let intensity = Vec3::splat(INTENSITY);
        let light = PunctualLight::Spot { position, direction, intensity, radius, cos_inner, cos_outer, edge };
        let to_light = position.as_dvec3();
        let axis = to_light.normalize();
        let across = axis.any_orthonormal_vector();
        let other = axis.cross(across);
        let most = (f64::from(radius) / to_light.length()).asin().min(FRAC_PI_2);
        let (steps, mut sum) = (400, 0.0);
        for i in 0..steps {
            let theta = most * (f64::from(i) + 0.5) / f64::from(steps);
            for j in 0..steps {
                let phi = TAU * (f64::from(j) + 0.5) / f64::from(steps);
                let way: DVec3 = axis * theta.cos() + (across * phi.cos() + other * phi.sin()) * theta.sin();
                let ramp = ((way.z - f64::from(cos_outer)) / f64::from(cos_inner - cos_outer)).clamp(0.0, 1.0);
                let part = if edge == SpotEdge::Square { ramp } else { ramp * (3.0 - 2.0 * ramp) } * ramp;
                sum += theta.sin() * part * way.z.max(0.0);
            }
        }
        let solid_angle = most * TAU / f64::from(steps * steps);
        let radiance = f64::from(INTENSITY) / (std::f64::consts::PI * f64::from(radius * radius));
        let expected = radiance * sum * solid_angle;
        close(irradiance(light, Vec3::Z, false), expected, 6e-3, &format!("radius {radius}"));
    }
}
