//! Light through a pane in integrators besides path tracing, at sensors and at probes: against integrals of Fresnel's
//! equations.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use halfdome::irradiance::{Part, Request, Sensor, by_paths};
use halfdome::material::Inputs;
use halfdome::probes;
use halfdome::scene::{Material, Scene, Sky, SkyPicture};
use halfdome::settings::{CachedOptions, DirectOptions, Integrator, MonteCarloOptions, PathOptions, Survival};
use halfdome::world::World;
use halfdome_tests::render::{Estimate, NeverStops, material, mesh};

use crate::panes::{below_a_pane, flipped, glowing_below_a_pane, mean_parts, parts};
use crate::{means, square};

/// How dark the plane is, as the pane sends back a part of what it reflects.
const DARK: f32 = 0.002;
const HEIGHT: u32 = 16;
const SUN: f32 = 400.0;

/// Radiance by the cosine of the angle from the zenith.
type Radiance = fn(f64) -> f64;

/// A sky with a bright cap about the zenith. It counts as a sun, which gathers leave to light samples.
fn sky_with_sun() -> Sky {
    let (width, height) = (2 * HEIGHT, HEIGHT);
    let texels = (0..width * height).map(|texel| Vec3::splat(if texel < 2 * width { SUN } else { 1.0 }));
    Sky { radiance: Vec3::ZERO, picture: Some(SkyPicture::new(width, height, texels.collect())) }
}

/// Its radiance: from the middle of a row to its border, and from there to the next middle, it changes evenly by solid
/// angle.
fn radiance(cos: f64) -> f64 {
    let border = |row: f64| (PI * row / f64::from(HEIGHT)).cos();
    let [above, below] = [1.0, 2.0].map(|row| 0.5 * (border(row) + border(row + 1.0)));
    let middle = border(2.0);
    let part = if cos > middle {
        0.5 + 0.5 * (cos - middle) / (above - middle)
    } else {
        0.5 * (cos - below) / (middle - below)
    };
    1.0 + f64::from(SUN - 1.0) * part.clamp(0.0, 1.0)
}

/// The integral over the upper hemisphere of what comes through the pane of light by its cosine, times that to a power.
fn through_pane(thin_walled: bool, radiance: Radiance, power: i32) -> DVec3 {
    const STEPS: u32 = 20_000;
    let cosines = (0..STEPS).map(|i| (f64::from(i) + 0.5) / f64::from(STEPS));
    let all = cosines.map(|cos| parts(thin_walled, cos)[0] * radiance(cos) * cos.powi(power));
    all.sum::<DVec3>() * (2.0 * PI / f64::from(STEPS))
}

fn scene(thin_walled: bool) -> Scene {
    Scene { sky: sky_with_sun(), ..below_a_pane(thin_walled, DARK) }
}

/// A panel above the pane, so near to what is below that bounces find it as well as light samples.
fn below_panel(thin_walled: bool) -> Scene {
    let mut scene = below_a_pane(thin_walled, DARK);
    scene.materials.push(material(Vec3::ZERO, Vec3::ONE));
    scene.meshes.push(mesh(&flipped(&square(1990.0, 2.5)), 2));
    scene
}

fn check(what: &str, found: &[DVec3], expected: DVec3) {
    let estimate = Estimate::of(found);
    let z = estimate.z(&expected.into(), 2e-3).max_element();
    let off = (estimate.mean - expected).abs().max_element() / expected.max_element();
    assert!(z < 4.5 && off < 0.03, "{what}: {estimate:?}, not {expected}; z {z}");
}

pub(crate) fn integrators() -> [(&'static str, Integrator); 4] {
    let tail = Some(Survival::THROUGHPUT);
    let gathers = MonteCarloOptions { bounces: 1, rays: 16, tail, ..MonteCarloOptions::default() };
    [
        ("direct", Integrator::Direct(DirectOptions::default())),
        ("montecarlo", Integrator::MonteCarlo(gathers)),
        ("cached", Integrator::Cached(CachedOptions { rays: 256, ..CachedOptions::default() })),
        ("path", Integrator::Path(PathOptions::default())),
    ]
}

#[test]
fn all_integrators_see_sky_and_sun_through_panes() {
    for thin_walled in [true, false] {
        let expected = f64::from(DARK) / PI * through_pane(thin_walled, radiance, 1);
        for (name, integrator) in integrators() {
            check(name, &means(&scene(thin_walled), &integrator, 8), expected);
        }
    }
}

#[test]
fn all_integrators_see_panels_through_panes() {
    for thin_walled in [true, false] {
        let scene = below_panel(thin_walled);
        let expected = f64::from(DARK) * mean_parts(thin_walled)[0];
        // Without bounces that find it, samples evenly over the panel are too rarely near.
        for (name, integrator) in integrators().into_iter().skip(2) {
            check(name, &means(&scene, &integrator, 8), expected);
        }
    }
}

#[test]
fn all_integrators_see_what_panes_reflect() {
    for thin_walled in [true, false] {
        let (scene, expected) = glowing_below_a_pane(thin_walled);
        // Direct light has no reflections.
        for (name, integrator) in integrators().into_iter().skip(1) {
            check(name, &means(&scene, &integrator, 8), expected);
        }
    }
}

/// Gloss, whose reflections are followed by rays of its own, and what is left by records: of plastic and of metal.
#[test]
fn gloss_below_panes_is_as_bright_in_all_integrators() {
    for (thin_walled, base_metalness) in [(true, 0.0), (false, 0.0), (true, 1.0), (false, 1.0)] {
        let mut scene = below_a_pane(thin_walled, 0.0);
        let base_color = Vec3::splat(0.8);
        let inputs = Inputs { base_color, base_metalness, specular_roughness: 0.3, ..Inputs::default() };
        scene.materials[0] = Material { inputs, ..Material::default() };
        scene.sky = Sky::constant(Vec3::ONE);
        let [_, (_, montecarlo), (_, cached), (_, path)] = integrators();
        let expected = Estimate::of(&means(&scene, &path, 8));
        for integrator in [montecarlo, cached] {
            let found = Estimate::of(&means(&scene, &integrator, 8));
            let z = found.z(&expected, 5e-3).max_element();
            assert!(z < 4.5, "{integrator:?}, metalness {base_metalness}: {found:?} and {expected:?}: {z}");
        }
    }
}

#[test]
fn sensors_see_sky_sun_and_panels_through_panes() {
    for thin_walled in [true, false] {
        let sensors = [Vec3::ZERO, Vec3::new(0.3, 0.0, 0.2)].map(|position| Sensor { position, normal: Vec3::Y });
        let found = |scene: Scene| -> Vec<DVec3> {
            let world = World::new(scene).unwrap();
            let run = |seed| {
                let request = Request { spp: 1024, seed, part: Part::Total };
                by_paths(&world, &sensors, &request, &NeverStops).values
            };
            (0..8).flat_map(run).map(|value| value.as_dvec3()).collect()
        };
        check("sky", &found(scene(thin_walled)), through_pane(thin_walled, radiance, 1));
        check("panel", &found(below_panel(thin_walled)), PI * mean_parts(thin_walled)[0]);
    }
}

/// Their first coefficient is the integral of radiance, times that harmonic.
#[test]
fn probes_see_sky_sun_and_panels_through_panes() {
    for thin_walled in [true, false] {
        for (scene, radiance) in [(scene(thin_walled), radiance as Radiance), (below_panel(thin_walled), |_| 1.0)] {
            let world = World::new(scene).unwrap();
            let run = |seed| {
                let options = probes::Options { rays: 2048, spp: 1024, seed };
                let probes = probes::at_points(&world, &[Vec3::Y], &options, &NeverStops).unwrap();
                probes.probes[0].light.harmonics[0].as_dvec3()
            };
            let found: Vec<DVec3> = (0..8).map(run).collect();
            let from_plane = 2.0 * f64::from(DARK) * through_pane(thin_walled, radiance, 1);
            let expected = (0.25 / PI).sqrt() * (through_pane(thin_walled, radiance, 0) + from_plane);
            check("probe", &found, expected);
        }
    }
}
