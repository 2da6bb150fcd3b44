//! Light through water, balls and wedges, against Snell's law in double precision and against paths.

use glam::{Affine3A, DMat2, DVec2, Quat, Vec2, vec2, vec3};

use halfdome_kernel::sampling::warp::{UniformHemisphere, Warp};

use super::super::Between;
use super::*;
use crate::driver;
use crate::fixtures::{self, IOR, reflectance, sloping_square, square, sun};
use crate::material::Inputs;
use crate::scene::{CameraPose, Instance, Material, Mesh, Object, PunctualLight, Scene};
use crate::settings::{CachedOptions, DirectOptions, Integrator, MonteCarloOptions, PathOptions, Settings};
use crate::watch::NeverStops;
use crate::world::MIDDLE;

const CAMERA: CameraPose = CameraPose { eye: vec3(0.0, -0.2, 0.05), target: Vec3::ZERO, up: Vec3::Z, vfov: 0.01 };

fn glass(absorption: Vec3) -> Material {
    Material { inputs: Inputs { absorption, ..fixtures::glass() }, ..Material::default() }
}

/// A ball with vertex normals.
fn ball(center: Vec3, material: usize) -> Mesh {
    let ball = fixtures::ball([48, 96]);
    let positions = ball.positions.iter().map(|position| center + *position).collect();
    Mesh { positions, material, ..ball }
}

/// Meshes above a floor, of which the camera sees the middle. Materials: 0 is glass, 1 so dark that nearly all light on it is direct,
/// 2 emits, 3 is tinted glass.
fn world(lights: Vec<PunctualLight>, meshes: Vec<Mesh>) -> World {
    World::new(Scene {
        meshes: meshes.into_iter().chain([square(0.0, true, 1)]).collect(),
        materials: vec![
            glass(Vec3::ZERO),
            Material::matte(Vec3::splat(0.05)),
            Material { emission: Vec3::ONE, ..Material::matte(Vec3::ZERO) },
            glass(vec3(0.5, 1.0, 2.0)),
        ],
        lights,
        camera: Some(CAMERA),
        ..Scene::default()
    })
    .unwrap()
}

fn point(position: Vec3, intensity: f32) -> PunctualLight {
    PunctualLight::Point { position, intensity: Vec3::splat(intensity), radius: 0.0 }
}

/// The surface of the floor at a place.
fn floor(world: &World, x: f32, y: f32) -> Surface<'_> {
    let hit = world.intersect_at(&Ray::new(vec3(x, y, 0.01), -Vec3::Z), MIDDLE);
    world.surface_at(&hit).facing(-Vec3::Z)
}

/// The way that is next to the straight line.
fn way(world: &World, from: &Surface, end: LightEnd) -> Option<SpecularConnection> {
    world.connection_near(from, (end, None), world.first_direction(from, end)?, FROM_STRAIGHT)
}

/// The number of starts at a point for the first light.
fn starts(world: &World, point: Vec3) -> usize {
    let mut starts = Starts::default();
    world.specular.refracted.find_starts(0, point, &mut starts);
    starts.iter().count()
}

fn is_near(found: f32, expected: f64, tolerance: f64) -> bool {
    (f64::from(found) / expected - 1.0).abs() < tolerance
}

#[test]
fn the_sun_reaches_the_ground_of_water() {
    for angle in [0.0f32, 0.5, 1.0, 1.4] {
        let to_sun = vec3(angle.sin(), 0.0, angle.cos());
        for (material, absorption) in [(0, 0.0), (3, 0.5)] {
            let world = world(vec![sun(to_sun)], vec![sloping_square(1.0, true, 0.0, 30.0, material)]);
            let from = floor(&world, 0.1, 0.2);
            let bent = way(&world, &from, LightEnd::Direction(to_sun)).unwrap();
            let sin_inside = to_sun.x / IOR;
            let cos_inside = (1.0 - sin_inside * sin_inside).sqrt();
            assert!((bent.direction - vec3(sin_inside, 0.0, cos_inside)).length() < 1e-4, "{}", bent.direction);
            let left = (1.0 - reflectance(f64::from(to_sun.z))) * f64::from(-absorption / cos_inside).exp();
            assert!(is_near(bent.transmittance.x, left, 1e-3), "{}, not {left}", bent.transmittance);
            let spread = f64::from(to_sun.z / (IOR * IOR * cos_inside));
            assert!(is_near(bent.spread, spread, 1e-3), "{}, not {spread}", bent.spread);
            assert!(bent.rest.origin.z > 0.999 && !world.occluded(&bent.rest) && bent.rest.direction == to_sun);
        }
    }
}

/// Where a ray that leaves the origin with these tangents and is refracted at the height 1 meets the plane at `end`.
fn through_plane(tangents: DVec2, n: f64, end: f64) -> DVec2 {
    let across = tangents.length();
    let sin = across / (1.0 + across * across).sqrt() * n;
    tangents + tangents / across * ((end - 1.0) * sin / (1.0 - sin * sin).sqrt())
}

#[test]
fn points_shine_into_and_out_of_water() {
    let (into, out) = (f64::from(IOR), 1.0 / f64::from(IOR));
    for (is_up, n, material, absorption) in [(true, into, 0, 0.0), (false, out, 0, 0.0), (false, out, 3, 0.5)] {
        let end = vec3(1.2, 0.7, 2.5);
        let world = world(vec![point(end, 1.0)], vec![sloping_square(1.0, is_up, 0.0, 30.0, material)]);
        let bent = way(&world, &floor(&world, 0.0, 0.0), LightEnd::Point(end)).unwrap();
        let tangents =
            DVec2::new(f64::from(bent.direction.x), f64::from(bent.direction.y)) / f64::from(bent.direction.z);
        let found = through_plane(tangents, n, 2.5);
        assert!((found - DVec2::new(1.2, 0.7)).length() < 2e-3, "{found}");
        // Per solid angle, and across the ray.
        let step = 1e-5;
        let by =
            |way: DVec2| (through_plane(tangents + way, n, 2.5) - through_plane(tangents - way, n, 2.5)) / (2.0 * step);
        let area = DMat2::from_cols(by(DVec2::X * step), by(DVec2::Y * step)).determinant();
        let cos = 1.0 / (1.0 + tangents.length_squared()).sqrt();
        let cos_at_light = -f64::from(bent.leaving.z);
        let expected = cos.powi(3) / (area * cos_at_light);
        assert!(is_near(bent.spread, expected, 2e-3), "{}, not {expected}", bent.spread);
        // The light is in the solid: it absorbs on the way to its face.
        let cos_in_air = if is_up { cos_at_light } else { cos };
        let absorbed = (-absorption * f64::from(end.distance(bent.rest.origin))).exp();
        let left = (1.0 - reflectance(cos_in_air)) * absorbed;
        assert!(is_near(bent.transmittance.x, left, 1e-3), "{}, not {left}", bent.transmittance);
    }
}

/// A ball, in place or as an instance that is stretched and turned.
fn balls() -> [World; 2] {
    let placed = world(vec![sun(Vec3::Z)], vec![ball(vec3(0.0, 0.0, 2.0), 0)]);
    let to_world =
        Affine3A::from_scale_rotation_translation(vec3(1.5, 0.7, 1.0), Quat::from_rotation_x(0.7), vec3(0.0, 0.2, 2.2));
    let instance = World::new(Scene {
        meshes: vec![Mesh { object: Some(0), ..ball(Vec3::ZERO, 0) }, square(0.0, true, 1)],
        objects: vec![Object::default()],
        instances: vec![
            Instance { object: 0, to_world },
            Instance { object: 0, to_world: Affine3A::from_translation(vec3(9.0, 9.0, 9.0)) * to_world },
        ],
        materials: vec![glass(Vec3::ZERO), Material::matte(Vec3::splat(0.5))],
        lights: vec![sun(Vec3::Z)],
        camera: Some(CAMERA),
        ..Scene::default()
    });
    [placed, instance.unwrap()]
}

#[test]
fn differentials_are_differences() {
    for world in balls() {
        let from = floor(&world, 0.1, -0.15);
        let direction = vec3(0.1, -0.05, 1.0).normalize();
        let frame = Frame::from_normal(direction);
        // Lights where that leads.
        for kind in [None, Some(0), Some(1)] {
            let towards = |end| world.trace_chain(&from, (direction, &frame), (end, kind));
            // Any direction, as no light is behind a chain that leads back to the floor.
            let last = [Vec3::Z, -Vec3::Z].into_iter().find_map(|sun| towards(LightEnd::Direction(sun))).unwrap().beam;
            for end in [LightEnd::Direction(last.ray.direction), LightEnd::Point(last.ray.at(4.0))] {
                differences(&world, &from, &frame, (end, kind));
            }
        }
    }
}

/// Compares a chain's derivatives with differences.
fn differences(world: &World, from: &Surface, frame: &Frame, chain: (LightEnd, Reflection)) {
    const STEP: f32 = 2e-3;
    let trace_chain = |step: Vec2| {
        let direction = frame.to_world(step.extend(1.0)).normalize();
        world.trace_chain(from, (direction, frame), chain).unwrap()
    };
    let arrival = trace_chain(Vec2::ZERO);
    assert!(arrival.beam.transmittance.x < 0.93, "two faces, or a reflection");
    for (axis, by) in [(Vec2::X, arrival.jacobian.x_axis), (Vec2::Y, arrival.jacobian.y_axis)] {
        let [more, less] = [STEP, -STEP].map(|step| trace_chain(axis * step).beside);
        let difference = (more - less) / (2.0 * STEP);
        let most = arrival.jacobian.x_axis.length().max(arrival.jacobian.y_axis.length());
        assert!((difference - by).length() < 0.02 * most, "{by}, not {difference}: {chain:?}");
    }
}

/// The mean of a picture of the middle of the floor.
fn seen(world: &World, integrator: Integrator, spp: u32) -> f64 {
    let settings = Settings { width: 16, height: 16, spp, integrator, ..Settings::default() };
    let picture = driver::render(world, &settings, &NeverStops).picture;
    f64::from(picture.channel("G").unwrap().values.iter().sum::<f32>()) / 256.0
}

/// A wedge from -2.3 to -0.3 along x, which bends light by 16° to where x is more.
fn wedge_beside() -> [Mesh; 2] {
    [sloping_square(4.0, false, 0.0, 1.0, 0), sloping_square(5.0, true, 0.5, 1.0, 0)].map(|mut face| {
        face.positions.iter_mut().for_each(|corner| corner.x -= 1.3);
        face
    })
}

#[test]
fn light_is_found_where_no_glass_is_on_the_straight_line() {
    let world = world(vec![sun(Vec3::Z)], wedge_beside().to_vec());
    let [shadow, lit, outside] = [-0.8, 0.0, 2.0].map(|x| floor(&world, x, 0.05));
    let straight = |from: &Surface| {
        let ray = Ray::new(from.origin_towards(Vec3::Z), Vec3::Z);
        matches!(world.glass_between(&ray, MIDDLE), Between::NoGlass).then_some(Vec3::Z)
    };
    let ways = |from: &Surface| {
        world.refracted_connections(from, (LightEnd::Direction(Vec3::Z), 0), straight(from)).iter().count()
    };
    assert_eq!((straight(&shadow), straight(&lit)), (None, Some(Vec3::Z)));
    assert_eq!([ways(&shadow), ways(&lit), ways(&outside)], [1, 1, 0]);
}

#[test]
fn a_ball_is_no_pane_at_its_axis() {
    // Its faces are parallel within 2° there.
    let world = world(vec![sun(-Vec3::Z)], vec![ball(vec3(0.0, 0.0, 2.0), 0)]);
    let ray = Ray::new(floor(&world, 0.01, 0.006).origin_towards(Vec3::Z), Vec3::Z);
    assert!(matches!(world.glass_between(&ray, MIDDLE), Between::Bends));
}

#[test]
fn photons_go_through_every_instance() {
    let [_, world] = balls();
    // Below the first and the second.
    for (x, y) in [(0.3, 0.2), (8.7, 8.8)] {
        assert!(starts(&world, floor(&world, x, y).position) > 0, "{x}, {y}");
    }
}

/// Lamps with a surface, which bounces find, are as bright as points all over them.
/// Nothing in a light's place, at the middle of a solid or far from the origin, keeps its photons.
#[test]
fn photons_leave_a_solid_around_their_light() {
    let [bottom, top] = [(1.0, false), (3.0, true)].map(|(z, is_up)| sloping_square(z, is_up, 0.0, 1.0, 0));
    let slab = Mesh {
        positions: [bottom.positions, top.positions].concat(),
        triangles: bottom.triangles.iter().copied().chain(top.triangles.iter().map(|t| t.map(|i| i + 4))).collect(),
        ..Mesh::default()
    };
    for (radius, scale, away) in [(0.0, 1.0, 0.0), (0.1, 1.0, 0.0), (0.0, 1e-3, 3e4)] {
        let place = |position: Vec3| position * scale + Vec3::X * away;
        let moved = |mesh: Mesh| Mesh { positions: mesh.positions.iter().map(|p| place(*p)).collect(), ..mesh };
        let light = PunctualLight::Point { position: place(vec3(0.0, 0.0, 2.0)), intensity: Vec3::ONE, radius };
        let world = World::new(Scene {
            meshes: vec![moved(slab.clone()), moved(square(0.0, true, 1))],
            materials: vec![glass(Vec3::ZERO), Material::matte(Vec3::splat(0.5))],
            lights: vec![light],
            camera: Some(CAMERA),
            ..Scene::default()
        });
        let starts = starts(&world.unwrap(), place(vec3(0.3, 0.2, 0.0)));
        assert!(starts > 0, "{radius}, {scale}, {away}");
    }
}

#[test]
fn bent_light_is_as_bright_as_that_of_lamps_with_a_surface() {
    let half = 0.5;
    for (glass, at) in [
        (vec![ball(vec3(0.0, 0.0, 2.0), 0)], vec3(0.0, 0.0, 20.0)),
        (vec![ball(vec3(0.1, 0.0, 2.05), 0)], vec3(2.0, 0.0, 20.0)),
        (vec![ball(vec3(0.0, 0.2, 1.8), 3)], vec3(0.0, 3.0, 20.0)),
        (vec![square(1.0, false, 0), sloping_square(3.0, true, 0.2, 9.0, 0)], vec3(0.0, 0.0, 20.0)),
        // Three ways, between the foci of the rim and of the middle.
        (vec![ball(vec3(0.12, 0.0, 1.25), 0)], vec3(0.0, 0.0, 20.0)),
        // Nothing is above the place that this wedge lights.
        (wedge_beside().to_vec(), vec3(0.0, 0.0, 20.0)),
    ] {
        let mut lamp = sloping_square(0.0, false, 0.0, half, 2);
        lamp.positions.iter_mut().for_each(|corner| *corner += at);
        let path = || Integrator::Path(PathOptions::default());
        let of_lamp = seen(&world(vec![], glass.iter().cloned().chain([lamp]).collect()), path(), 2048);
        // Points all over the square, which faces down.
        let cos = at.z / at.length();
        let places = (0..64).map(|i| vec3((i % 8) as f32 - 3.5, (i / 8) as f32 - 3.5, 0.0) * (half / 4.0));
        let points = places.map(|place| point(at + place, half * half * cos / 16.0)).collect();
        let of_points = seen(&world(points, glass.clone()), path(), 64);
        assert!((of_points / of_lamp - 1.0).abs() < 0.04, "{of_points}, not {of_lamp}, at {at}");
    }
}

#[test]
fn all_integrators_find_bent_light() {
    let world = world(vec![point(vec3(0.0, 0.0, 20.0), 100.0)], vec![ball(vec3(0.0, 0.0, 2.0), 0)]);
    let expected = seen(&world, Integrator::Path(PathOptions::default()), 16);
    assert!(expected > 0.0);
    for integrator in [
        Integrator::MonteCarlo(MonteCarloOptions::default()),
        Integrator::Direct(DirectOptions::default()),
        Integrator::Cached(CachedOptions { rays: 64, ..CachedOptions::default() }),
    ] {
        let found = seen(&world, integrator.clone(), 16);
        assert!((found / expected - 1.0).abs() < 0.05, "{integrator:?}: {found}, not {expected}");
    }
}

#[test]
fn walls_within_and_behind_glass_throw_shadows() {
    let ball = || ball(vec3(0.0, 0.0, 2.0), 0);
    let wall = |z: f32| sloping_square(z, true, 0.0, 2.0, 1);
    let end = LightEnd::Point(vec3(0.0, 0.0, 20.0));
    for z in [2.0, 4.0] {
        let world = world(vec![point(vec3(0.0, 0.0, 20.0), 1.0)], vec![ball(), wall(z)]);
        let bent = way(&world, &floor(&world, 0.1, 0.0), end);
        assert!(bent.is_none_or(|bent| world.occluded(&bent.rest)), "{z}");
    }
    // A lamp between floor and ball has nothing to cross.
    let lamp = vec3(0.1, 0.0, 0.5);
    let world = world(vec![point(lamp, 1.0)], vec![ball()]);
    let from = floor(&world, 0.1, 0.0);
    assert!(world.refracted_connections(&from, (LightEnd::Point(lamp), 0), Some(Vec3::Z)).is_empty());
}

/// What the ways of light bring to a surface that faces up.
fn brought<'a>(ways: impl Iterator<Item = &'a SpecularConnection>) -> f32 {
    ways.map(|way| way.spread * way.transmittance.x * way.direction.z).sum()
}

#[test]
fn photons_find_nearly_all_ways() {
    const STARTS: u16 = 48;
    let light = vec3(0.1, 0.03, 20.0);
    let end = LightEnd::Point(light);
    // With one way, with three, and with both; so many lights that they share photons.
    for height in [1.1, 1.25, 1.6, 2.5] {
        let world = world(vec![point(light, 1.0); 64], vec![ball(vec3(0.0, 0.0, height), 0)]);
        let (mut found, mut there) = (0.0, 0.0);
        for i in 13..60u16 {
            // Nearer to the axis there are too many to count.
            let place = 0.3 * (0.03 * f32::from(i)).powi(2) * Vec2::from_angle(2.4 * f32::from(i));
            let from = floor(&world, place.x, place.y);
            found += brought(world.refracted_connections(&from, (end, 0), None).iter());
            let mut all: Vec<SpecularConnection> = Vec::new();
            for start in 0..STARTS * STARTS {
                let place = (vec2(f32::from(start % STARTS), f32::from(start / STARTS)) + 0.5) / f32::from(STARTS);
                let way = world.connection_near(&from, (end, None), UniformHemisphere.map(place), FROM_STRAIGHT);
                all.extend(way.filter(|way| !all.iter().any(|other| way.direction.distance(other.direction) < 0.01)));
            }
            there += brought(all.iter());
        }
        assert!((found / there - 1.0).abs() < 0.03, "{height}: {found}, not {there}");
    }
}
