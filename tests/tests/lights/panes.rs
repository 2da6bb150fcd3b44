//! Light through panes, which paths and light samples cross straight: against integrals of Fresnel's equations, and
//! against bounces alone.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use halfdome::driver;
use halfdome::material::Inputs;
use halfdome::scene::{CameraPose, Material, Scene, Sky, SkyPicture};
use halfdome::settings::{Integrator, LightSampling, PathOptions, Settings, Stop};
use halfdome::world::World;
use halfdome_tests::render::{Estimate, NeverStops, material, mesh, pixels, quad, render, seeds};

use crate::openings::{LOW, WINDOW, furnished};
use crate::panes_everywhere::integrators;
use crate::secondary::{hollow, picture};
use crate::{SIZE, check_settings, expected, plane, settings, square};

const IOR: f64 = 1.5;
const TINT: Vec3 = Vec3::new(0.9, 0.8, 0.6);
const ABSORPTION: Vec3 = Vec3::new(1.0, 4.0, 10.0);
const THICKNESS: f32 = 0.02;

fn glass(thin_walled: bool) -> Material {
    let inputs = Inputs {
        specular_weight: 1.0,
        specular_roughness: 0.0,
        specular_ior: IOR as f32,
        transmission_weight: 1.0,
        transmission_color: TINT,
        absorption: if thin_walled { Vec3::ZERO } else { ABSORPTION },
        thin_walled,
        ..Inputs::default()
    };
    Material { inputs, ..Material::default() }
}

/// What a pane lets through and what it reflects at an angle.
pub(crate) fn parts(thin_walled: bool, cos: f64) -> [DVec3; 2] {
    let inside = (1.0 - (1.0 - cos * cos) / (IOR * IOR)).sqrt();
    let [s, p] = [(cos - IOR * inside) / (cos + IOR * inside), (IOR * cos - inside) / (IOR * cos + inside)];
    let f = 0.5 * (s * s + p * p);
    let tint = TINT.as_dvec3();
    if thin_walled {
        return [tint * ((1.0 - f) / (1.0 + f)), DVec3::splat(2.0 * f / (1.0 + f))];
    }
    let a = tint * tint * (-f64::from(THICKNESS) / inside * ABSORPTION.as_dvec3()).exp();
    // Tint and absorption are on the way in and out.
    let inner = (1.0 - f).powi(2) / (1.0 - f * f * a * a / (tint * tint) / (tint * tint));
    [a * inner, f + f * a * a / (tint * tint) * inner]
}

/// The means of both in all directions of a hemisphere, by the cosine.
pub(crate) fn mean_parts(thin_walled: bool) -> [DVec3; 2] {
    const STEPS: u32 = 4000;
    let cosines = (0..STEPS).map(|i| ((f64::from(i) + 0.5) / f64::from(STEPS)).sqrt());
    let all = cosines.map(|cos| parts(thin_walled, cos));
    all.fold([DVec3::ZERO; 2], |[t, r], [dt, dr]| [t + dt, r + dr]).map(|sum| sum / f64::from(STEPS))
}

/// A plane below a pane at the height 2, both so large that nothing comes from beside them.
pub(crate) fn below_a_pane(thin_walled: bool, reflectance: f32) -> Scene {
    let [low, high] = [2.0, 2.0 + THICKNESS].map(|y| square(2000.0, y));
    let pane = if thin_walled { low.into() } else { [flipped(&low), high.into()].concat() };
    Scene {
        meshes: vec![mesh(&square(2000.0, 0.0), 0), mesh(&pane, 1)],
        materials: vec![material(Vec3::splat(reflectance), Vec3::ZERO), glass(thin_walled)],
        ..plane()
    }
}

pub(crate) fn flipped(triangles: &[[Vec3; 3]]) -> Vec<[Vec3; 3]> {
    triangles.iter().map(|&[a, b, c]| [a, c, b]).collect()
}

fn path(lights: LightSampling) -> Settings {
    Settings { integrator: Integrator::Path(PathOptions { lights, ..PathOptions::default() }), ..settings() }
}

const ALL: [LightSampling; 3] = [LightSampling::Naive, LightSampling::Direct, LightSampling::Mis];

#[test]
fn the_sky_behind_a_pane_lights_by_fresnels_equations() {
    for thin_walled in [true, false] {
        // Dark, as the pane sends back a part of what the plane reflects.
        let mut scene = below_a_pane(thin_walled, 0.01);
        let [through, _] = mean_parts(thin_walled);
        let expected = expected(&scene, 0.0, |_| 0.01 * through);
        let picture = SkyPicture::new(6, 4, vec![Vec3::ONE; 24]);
        for sky in [Sky::constant(Vec3::ONE), Sky { radiance: Vec3::ZERO, picture: Some(picture) }] {
            scene.sky = sky;
            for lights in ALL {
                check_settings(&scene, &path(lights), &expected, 0.1);
            }
        }
    }
}

/// Of a small lamp the integral is the formula of a point's.
#[test]
fn a_lamp_behind_a_pane_lights_by_fresnels_equations() {
    let (half, at) = (0.05f32, Vec3::new(0.5, 4.0, 0.5));
    for thin_walled in [true, false] {
        let mut scene = below_a_pane(thin_walled, 0.01);
        scene.materials.push(material(Vec3::ZERO, Vec3::splat(1000.0)));
        let lamp = flipped(&square(half, 0.0)).iter().map(|face| face.map(|corner| at + corner)).collect::<Vec<_>>();
        scene.meshes.push(mesh(&lamp, 2));
        let expected = expected(&scene, 0.0, |point| {
            let way = at.as_dvec3() - point;
            let cos = way.y / way.length();
            let irradiance = 1000.0 * 4.0 * f64::from(half * half) * cos * cos / way.length_squared();
            0.01 / PI * irradiance * parts(thin_walled, cos)[0]
        });
        for lights in [LightSampling::Direct, LightSampling::Mis] {
            check_settings(&scene, &path(lights), &expected, 0.1);
        }
        for (_, integrator) in integrators() {
            check_settings(&scene, &Settings { integrator, ..settings() }, &expected, 0.1);
        }
    }
}

/// A sheet within a pane keeps all light off, wherever light samples and bounces look.
#[test]
fn a_sheet_within_a_pane_lets_nothing_through() {
    let mut scene = below_a_pane(false, 0.5);
    scene.meshes.push(mesh(&square(1990.0, 2.0 + 0.5 * THICKNESS), 2));
    scene.meshes.push(mesh(&flipped(&square(1.0, 4.0)), 3));
    scene.materials.extend([material(Vec3::ZERO, Vec3::ZERO), material(Vec3::ZERO, Vec3::ONE)]);
    // Rays leave the edges nearly level.
    let mut walls = hollow(Vec3::new(-1980.0, -1.0, -1980.0), Vec3::new(1980.0, 9.0, 1980.0));
    walls.retain(|wall| wall.iter().any(|corner| corner.y < 9.0));
    scene.meshes.push(mesh(&walls, 2));
    scene.sky = Sky { radiance: Vec3::ZERO, picture: Some(SkyPicture::new(6, 4, vec![Vec3::ONE; 24])) };
    for lights in ALL {
        let picture = pixels(&render(&scene, &path(lights)));
        assert!(picture.iter().all(|&pixel| pixel == DVec3::ZERO), "{lights:?}");
    }
}

/// Glass that neither reflects nor lets anything through, in lights of all kinds.
#[test]
fn a_pane_that_takes_all_light_is_black() {
    for thin_walled in [true, false] {
        let mut scene = below_a_pane(thin_walled, 0.5);
        (scene.materials[1].inputs.specular_weight, scene.materials[1].inputs.transmission_color) = (0.0, Vec3::ZERO);
        scene.sky = Sky::constant(Vec3::ONE);
        for lights in ALL {
            let render = driver::render(&World::new(scene.clone()).unwrap(), &path(lights), &NeverStops);
            assert!(pixels(&render.picture).iter().all(|&pixel| pixel == DVec3::ZERO), "{lights:?}");
            assert_eq!(render.film.bad_samples().count, 0, "{lights:?}");
        }
    }
}

/// The furnished room with a pane in its window, a lamp before the window and one inside.
fn glazed(thin_walled: bool) -> Scene {
    glazed_by(thin_walled, 0.01)
}

fn glazed_by(thin_walled: bool, thickness: f32) -> Scene {
    let mut scene = furnished();
    let [low, high] = WINDOW;
    let first = scene.materials.len();
    let glazing = if thin_walled {
        quad([low, [low[0], high[1]], high, [high[0], low[1]]].map(|[y, z]| Vec3::new(2.5, y, z))).to_vec()
    } else {
        hollow(Vec3::new(2.5 - thickness, low[0], low[1]), Vec3::new(2.5, high[0], high[1]))
    };
    scene.meshes.push(mesh(&glazing, first));
    scene.meshes.push(mesh(&hollow(Vec3::new(3.5, 1.5, 0.8), Vec3::new(3.7, 1.7, 1.0)), first + 1));
    scene.meshes.push(mesh(&hollow(LOW + Vec3::new(0.3, 0.5, 0.3), LOW + Vec3::new(0.5, 0.7, 0.5)), first + 2));
    let lamps = [Vec3::new(20.0, 10.0, 5.0), Vec3::new(0.5, 1.0, 2.0)];
    scene.materials.push(glass(thin_walled));
    scene.materials.extend(lamps.map(|emission| material(Vec3::splat(0.2), emission)));
    scene
}

#[test]
fn going_straight_through_panes_changes_nothing_but_noise() {
    for thin_walled in [true, false] {
        let scene = glazed(thin_walled);
        let (alone, noise_alone) = picture(&scene, LightSampling::Naive, &Stop::Depth, 256);
        for lights in [LightSampling::Mis, LightSampling::Direct] {
            let (found, noise) = picture(&scene, lights, &Stop::Depth, 64);
            let z = found.z(&alone, 0.0);
            assert!(z.max_element() < 4.0, "{lights:?}: {} and {}: {z}", found.mean, alone.mean);
            let ratio = 4.0 * noise_alone / noise;
            assert!(ratio > 3.0, "{lights:?}: {ratio} times the variance by bounces alone");
        }
    }
}

/// Where the two faces of a pane are of two materials, if equal ones, paths refract light at both.
#[test]
fn going_straight_through_panes_is_as_bright_as_refraction() {
    // Little light passes the rim.
    let mut scene = glazed_by(false, 0.001);
    scene.camera = Some(CameraPose { vfov: 50.0, ..scene.camera.unwrap() });
    let mean = |scene: &Scene, spp: u32| {
        Estimate::of_means(&seeds(scene, &Settings { width: 20, height: 20, spp, ..settings() }, 8))
    };
    // The solid that paths leave is not the one that they have entered, so nothing may be absorbed.
    for material in scene.materials.iter_mut().filter(|material| material.inputs.transmission_weight == 1.0) {
        material.inputs.absorption = Vec3::ZERO;
    }
    let straight = mean(&scene, 128);
    let glass = scene.meshes.iter().find(|mesh| scene.materials[mesh.material].inputs.transmission_weight == 1.0);
    let mut outside = glass.unwrap().clone();
    let is_outside =
        |[a, b, c]: &[u32; 3]| [a, b, c].iter().all(|&&corner| outside.positions[corner as usize].x == 2.5);
    outside.triangles = outside.triangles.iter().copied().filter(is_outside).collect();
    assert_eq!(outside.triangles.len(), 2);
    let inside = scene.meshes.iter_mut().find(|mesh| mesh.material == outside.material).unwrap();
    inside.triangles.retain(|triangle| !outside.triangles.contains(triangle));
    scene.materials.push(scene.materials[outside.material].clone());
    outside.material = scene.materials.len() - 1;
    scene.meshes.push(outside);
    let refracted = mean(&scene, 512);
    let z = straight.z(&refracted, 1e-3);
    assert!(z.max_element() < 4.0, "{} and {}: {z}", straight.mean, refracted.mean);
    assert!(refracted.error.max_element() < 0.01 * refracted.mean.min_element(), "{refracted:?}");
}

/// A plane that glows sees itself in the pane: `L = 1 + ρ R L`; and this radiance.
pub(crate) fn glowing_below_a_pane(thin_walled: bool) -> (Scene, DVec3) {
    let mut scene = below_a_pane(thin_walled, 0.0);
    scene.materials[0] = material(Vec3::splat(0.5), Vec3::ONE);
    let [_, back] = mean_parts(thin_walled);
    (scene, (1.0 - 0.5 * back).recip())
}

#[test]
fn panes_reflect_what_is_below_by_fresnels_equations() {
    for thin_walled in [true, false] {
        let (scene, radiance) = glowing_below_a_pane(thin_walled);
        let expected = vec![radiance; (SIZE.0 * SIZE.1) as usize];
        for lights in ALL {
            check_settings(&scene, &path(lights), &expected, 0.02);
        }
    }
}

/// Without absorption and tint a pane keeps nothing: what it does not let through it reflects.
#[test]
fn below_a_pane_in_a_white_furnace_all_is_white() {
    for thin_walled in [true, false] {
        let mut scene = below_a_pane(thin_walled, 1.0);
        scene.materials[1].inputs.transmission_color = Vec3::ONE;
        scene.materials[1].inputs.absorption = Vec3::ZERO;
        let picture = SkyPicture::new(6, 4, vec![Vec3::ONE; 24]);
        for sky in [Sky::constant(Vec3::ONE), Sky { radiance: Vec3::ZERO, picture: Some(picture) }] {
            scene.sky = sky;
            for lights in ALL {
                check_settings(&scene, &path(lights), &[DVec3::ONE; (SIZE.0 * SIZE.1) as usize], 0.1);
            }
        }
    }
}
