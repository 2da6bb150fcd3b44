//! Panes against Fresnel's equations in double precision.

use glam::vec3;
use halfdome_kernel::sampling::Stream;

use super::*;
use crate::fixtures::{self, IOR, ball, reflectance, sloping_square, square};
use crate::material::Inputs;
use crate::scene::{CameraPose, Scene};
use crate::world::World;

const TINT: Vec3 = Vec3::new(0.9, 0.6, 0.3);
const ABSORPTION: Vec3 = Vec3::new(0.5, 1.0, 2.0);

/// Materials: 0 clear glass, 1 tinted and absorbing, 2 a tinted thin wall, 3 rough, 4 coated.
fn world(meshes: Vec<Mesh>) -> World {
    let material = |inputs: Inputs| Material { inputs, ..Material::default() };
    let clear = fixtures::glass();
    let materials = vec![
        material(clear),
        material(Inputs { transmission_color: TINT, absorption: ABSORPTION, ..clear }),
        material(Inputs { transmission_color: TINT, thin_walled: true, ..clear }),
        material(Inputs { specular_roughness: 0.3, ..clear }),
        material(Inputs { coat_weight: 1.0, ..clear }),
    ];
    let camera = Some(CameraPose { eye: Vec3::Z * 0.5, target: Vec3::ZERO, up: Vec3::Y, vfov: 1.0 });
    World::new(Scene { meshes, materials, camera, ..Scene::default() }).unwrap()
}

fn slab(material: usize, thickness: f32) -> Vec<Mesh> {
    vec![square(1.0, false, material), square(1.0 + thickness, true, material)]
}

fn next(world: &World, ray: &Ray) -> Next {
    world.panes().map_or(Next::Nothing, |glass| glass.next(ray))
}

/// A ray from the origin up, at this angle from the normal of panes.
fn slanted(angle: f32) -> Ray {
    Ray::new(Vec3::ZERO, vec3(angle.sin(), 0.0, angle.cos()))
}

fn assert_near(found: Vec3, expected: [f64; 3]) {
    let expected = vec3(expected[0] as f32, expected[1] as f32, expected[2] as f32);
    assert!((found - expected).abs().max_element() < 2e-6, "{found}, not {expected}");
}

#[test]
fn panes_have_fresnels_transmittance_and_reflectance() {
    const THICKNESS: f32 = 0.01;
    let [solid, thin] = [world(slab(1, THICKNESS)), world(vec![square(1.0, true, 2)])];
    for angle in [0.0, 0.4, 0.8, 1.2, 1.4] {
        let (ray, cos) = (slanted(angle), f64::from(angle).cos());
        let (f, inside) = (reflectance(cos), (1.0 - (1.0 - cos * cos) / f64::from(IOR).powi(2)).sqrt());
        let Next::Pane(pane) = next(&solid, &ray) else { panic!("{angle}") };
        let by_channel = |of: &dyn Fn(f64, f64) -> f64| {
            [0, 1, 2].map(|c| {
                let way = f64::from(pane.leaves - pane.enters) * cos / inside;
                of((-way * f64::from(ABSORPTION[c])).exp(), f64::from(TINT[c]))
            })
        };
        assert_near(
            pane.transmittance,
            by_channel(&|a, tint| tint * tint * a * (1.0 - f).powi(2) / (1.0 - f * f * a * a)),
        );
        let back = |a: f64, tint: f64| f + (tint * a * (1.0 - f)).powi(2) * f / (1.0 - f * f * a * a);
        assert_near(pane.reflectance, by_channel(&back));
        assert_eq!(pane.normal, Vec3::NEG_Z);
        assert!((ray.at(pane.enters).z - 1.0).abs() < 1e-6 && (ray.at(pane.leaves).z - 1.0 - THICKNESS).abs() < 1e-6);
        let Next::Pane(pane) = next(&thin, &ray) else { panic!("{angle}") };
        assert_near(pane.transmittance, [0, 1, 2].map(|c| f64::from(TINT[c]) * (1.0 - f) / (1.0 + f)));
        assert_near(pane.reflectance, [2.0 * f / (1.0 + f); 3]);
        assert_eq!(pane.enters, pane.leaves);
    }
}

#[test]
fn clear_panes_lose_nothing() {
    let world = world(slab(0, 0.01));
    for angle in [0.0, 0.7, 1.3] {
        let Next::Pane(pane) = next(&world, &slanted(angle)) else { panic!("{angle}") };
        assert!((pane.transmittance + pane.reflectance - 1.0).abs().max_element() < 1e-6, "{pane:?}");
    }
}

#[test]
fn what_is_no_pane_bends() {
    let wedge = vec![square(1.0, false, 0), sloping_square(1.1, true, 0.06, 9.0, 0)];
    let others = vec![square(1.0, false, 0), square(1.01, true, 1)];
    // Of 0.2 m across, light is 6 cm off, 6% of the distance.
    let far = |mut mesh: Mesh| {
        mesh.positions.iter_mut().for_each(|corner| *corner -= Vec3::Z * 50.0);
        mesh
    };
    let with_pane = |meshes: Vec<Mesh>| world(meshes.into_iter().chain(slab(0, 0.01).into_iter().map(far)).collect());
    for (meshes, angle) in [(wedge, 0.3), (others, 0.3), (vec![square(1.0, false, 0)], 0.3), (slab(0, 0.2), 0.8)] {
        assert_eq!(next(&with_pane(meshes), &slanted(angle)), Next::Bends);
    }
    // From within.
    let within = Ray::new(Vec3::Z * 1.005, Vec3::Z);
    assert_eq!(next(&world(slab(0, 0.01)), &within), Next::Bends);
    // Curved, rough and coated glass, beside a pane far away.
    let mut sphere = ball([16, 32]);
    sphere.positions.iter_mut().for_each(|corner| *corner += Vec3::Z * 3.0);
    for meshes in [slab(3, 0.01), slab(4, 0.01), vec![sphere]] {
        assert!(world(meshes.clone()).panes().is_none());
        let world = with_pane(meshes);
        assert_eq!(next(&world, &slanted(0.1)), Next::Bends);
        assert_eq!(next(&world, &Ray::new(Vec3::ZERO, Vec3::X)), Next::Nothing);
    }
}

/// All corners of a box of glass that stands as a window pane does, from both sides.
#[test]
fn a_box_of_glass_is_a_pane() {
    let world = world(slab(0, 0.01));
    let glass = world.panes().unwrap();
    for i in 0..1000 {
        let [a, b, c, d] = Stream::new(3, i, 0).uniform4(0);
        let ray = Ray::new(vec3(a, b, 0.0), vec3(c - 0.5, d - 0.5, 1.0));
        for ray in [ray, Ray::new(ray.at(2.0), -ray.direction)] {
            let Next::Pane(pane) = glass.next(&ray) else { panic!("{ray:?}") };
            assert!(pane.enters < pane.leaves && pane.normal.dot(ray.direction) < 0.0);
        }
    }
}

#[test]
fn water_and_wedges_are_no_panes() {
    let wedge = vec![square(1.0, false, 0), sloping_square(1.1, true, 0.06, 9.0, 0)];
    for meshes in [vec![square(1.0, true, 0)], vec![square(1.0, false, 0)], wedge] {
        assert!(world(meshes).panes().is_none());
    }
    assert!(world(slab(0, 0.01)).panes().is_some() && world(vec![square(1.0, false, 2)]).panes().is_some());
}

#[test]
fn shadow_rays_go_through_all_panes() {
    let double: Vec<Mesh> = slab(0, 0.01).into_iter().chain([square(1.2, false, 0), square(1.21, true, 0)]).collect();
    let (one, two) = (world(slab(0, 0.01)), world(double));
    let ray = slanted(0.5);
    let cross = |world: &World, ray: &Ray| {
        let (glass, mut parts) = (world.panes().unwrap(), Vec::new());
        let mut first = [Hit::MISS];
        glass.intersect_many(&[*ray], &mut first);
        let (rest, left) = glass.cross(ray, &first[0], |part| parts.push(part)).unwrap();
        (rest, left, parts)
    };
    let ((_, once, _), (rest, twice, parts)) = (cross(&one, &ray), cross(&two, &ray));
    assert!((twice - once * once).abs().max_element() < 1e-6, "{twice}, {once}");
    // Before, inside, between, inside, and what is left: neither has a face of glass.
    assert_eq!(parts.len(), 4);
    for part in parts.iter().chain([&rest]) {
        assert!(part.t_min <= part.t_max && !two.occluded(part), "{part:?}");
    }
    assert!(rest.origin == ray.origin && rest.t_max == ray.t_max && rest.at(rest.t_min).z >= 1.2);
    // A lamp between the panes is behind one of them.
    let (rest, left, parts) = cross(&two, &Ray::between(Vec3::ZERO, Vec3::Z * 1.1));
    assert!(parts.len() == 2 && rest.t_max == 1.0 && left.x > twice.x, "{left}");
}
