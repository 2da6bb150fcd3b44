use crate::world::Hit;
use glam::{Vec2, vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};

use super::*;
use crate::cache::Record;
use crate::camera::FilmPoint;
use crate::integrator::FIRST_SET;
use crate::scene::{CameraPose, ColorSpace, Material, Mesh, NormalMap, Scene, Sky, Texture, TextureMap, cornell_box};
use crate::settings::Settings;
use crate::watch::NeverStops;

/// The inside of a tetrahedron about the origin that emits 1 and reflects half.
fn furnace() -> World {
    World::new(furnace_scene()).unwrap()
}

fn furnace_scene() -> Scene {
    let positions = vec![vec3(1.0, 1.0, 1.0), vec3(1.0, -1.0, -1.0), vec3(-1.0, 1.0, -1.0), vec3(-1.0, -1.0, 1.0)];
    let triangles = vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];
    let wall = Material { emission: Vec3::ONE, ..Material::matte(Vec3::splat(0.5)) };
    Scene {
        meshes: vec![Mesh { positions, triangles, ..Mesh::default() }],
        materials: vec![wall],
        camera: Some(CameraPose { eye: Vec3::ZERO, target: Vec3::X, up: Vec3::Y, vfov: 60.0 }),
        ..Scene::default()
    }
}

/// Rays from the origin, about the z axis, and what they hit.
struct CameraRays {
    samplers: Vec<Sampler>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
}

impl CameraRays {
    fn new(world: &World, count: u32) -> Self {
        let samplers: Vec<Sampler> = (0..count).map(|i| Sampler::new(Pattern::Sobol, 5, 0, i)).collect();
        let direction = |sampler: &Sampler| CosineHemisphere.map(sampler.uniform2(0));
        let rays: Vec<Ray> = samplers.iter().map(|sampler| Ray::new(Vec3::ZERO, direction(sampler))).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        world.intersect_many(&rays, &mut hits);
        Self { samplers, rays, hits }
    }

    fn batch(&self) -> RayBatch<'_> {
        let Self { samplers, rays, hits } = self;
        RayBatch { rays, hits, samplers, times: &[], first_set: FIRST_SET, density: f32::INFINITY }
    }

    fn surfaces<'w>(&self, world: &'w World) -> Vec<Surface<'w>> {
        self.rays.iter().zip(&self.hits).map(|(ray, hit)| world.surface_at(hit).facing(ray.direction)).collect()
    }
}

/// The mean of the green channel.
fn mean(found: &[Vec3]) -> f64 {
    found.iter().map(|radiance| f64::from(radiance.y)).sum::<f64>() / found.len() as f64
}

/// `L = 1 + ρ (1 + Σ ρ^k)`, with as many terms as the cache has reflections; for ever `1 / (1 - ρ)`.
#[test]
fn paths_in_place_of_records_are_as_long() {
    let world = furnace();
    const COUNT: u32 = 1 << 14;
    let camera = CameraRays::new(&world, COUNT);
    for (bounces, expected) in [(Some(1), 1.75), (Some(2), 1.875), (Some(3), 1.9375), (None, 2.0)] {
        let cache = Cache::new(CachedOptions { bounces, ..CachedOptions::default() }, world.surroundings_hash());
        let frozen = FrozenCache::new(cache);
        let mut found = vec![Vec3::ZERO; COUNT as usize];
        radiance(&world, &frozen, &camera.batch(), &mut Wavefront::default(), &mut CacheMisses::default(), &mut found);
        assert_eq!(frozen.usage().misses, u64::from(COUNT));
        let mean = mean(&found);
        assert!((mean / expected - 1.0).abs() < 0.008, "{bounces:?}: {mean}, not {expected}");
    }
}

/// Nobody watches.
/// Whatever the error, records reach most of what is beside a site: paths are for what is left.
#[test]
fn few_points_have_no_record() {
    let world = World::new(cornell_box()).unwrap();
    let settings = Settings { width: 128, height: 128, ..Settings::default() };
    let camera = world.camera_on(settings.width, settings.height);
    for error in [0.6, 0.2, 0.1] {
        let options = CachedOptions { error, rays: 48, ..CachedOptions::default() };
        let cache = Cache::new(options, world.surroundings_hash());
        let (frozen, _) = fill_for_camera(&world, &settings, cache, &NeverStops);
        let rays = (0..1 << 15).filter_map(|i| {
            let place = Sampler::new(Pattern::Sobol, 2, 0, i).uniform2(0) * 128.0;
            camera.central_ray(&FilmPoint::within(place))
        });
        let points: Vec<_> = rays
            .filter_map(|ray| Some(world.surface_at(&Hit::of(&world.tree().intersect(&ray)?)).facing(ray.direction)))
            .filter(|surface| surface.diffuse != Vec3::ZERO)
            .collect();
        let missing = points.iter().filter(|surface| frozen.irradiance(&world, surface).is_none()).count();
        println!("error {error}: {missing} of {} points", points.len());
        assert!(points.len() > 1 << 14 && missing * 25 < points.len(), "{missing} of {}", points.len());
    }
}

/// A closed room of glossy walls that emit 1 is as bright by records as by paths, and by neither where a record is missing.
#[test]
fn glossy_walls_are_as_bright_as_by_paths() {
    let mut scene = furnace_scene();
    let wall = &mut scene.materials[0];
    wall.inputs.specular_weight = 1.0;
    wall.inputs.specular_roughness = 0.2;
    wall.inputs.base_color = Vec3::splat(0.6);
    let world = World::new(scene).unwrap();
    const COUNT: u32 = 1 << 15;
    let camera = CameraRays::new(&world, COUNT);
    let mut found = vec![Vec3::ZERO; COUNT as usize];
    let options = PathOptions { max_depth: 64, stop: Stop::Depth, ..PathOptions::default() };
    let wave = &mut Wavefront::default();
    path::radiance(&world, &options, &camera.batch(), wave, &mut found, &mut |_| (), path::PathObservers::default());
    let expected = mean(&found);
    let empty = || Cache::new(CachedOptions::default(), world.surroundings_hash());
    let surfaces = camera.surfaces(&world);
    let (filled, _) = fill_for_surfaces(&world, 1, empty(), &surfaces[..4096], FillTarget::Options, &NeverStops);
    // Half of the points without a record.
    let half = filled.cache.records().iter().filter(|record| record.position.x > 0.0).copied().collect();
    let half = Cache::of(CachedOptions::default(), world.surroundings_hash(), half);
    let mut misses_before = u64::MAX;
    for (name, frozen) in [("none", FrozenCache::new(empty())), ("half", FrozenCache::new(half)), ("all", filled)] {
        radiance(&world, &frozen, &camera.batch(), wave, &mut CacheMisses::default(), &mut found);
        let (mean, misses) = (mean(&found), frozen.usage().misses);
        println!("{name}: {mean}, by paths {expected}; {misses} misses");
        assert!((mean / expected - 1.0).abs() < 0.004, "{name}: {mean}, not {expected}");
        assert!(misses < misses_before / 2, "{name}: {misses} of {misses_before} misses");
        misses_before = misses;
    }
}

/// What the Cornell box's camera sees.
fn cornell_surfaces(world: &World) -> Vec<Surface<'_>> {
    let camera = world.camera_on(64, 64);
    let rays = (0..64 * 64).filter_map(|pixel| camera.central_ray(&FilmPoint::middle(pixel % 64, pixel / 64)));
    rays.filter_map(|ray| Some(world.surface_at(&Hit::of(&world.tree().intersect(&ray)?)).facing(ray.direction)))
        .filter(|surface| surface.diffuse != Vec3::ZERO)
        .collect()
}

/// Of gathers of few rays some are far off. With more rays for these few are left.
#[test]
fn doubtful_records_are_gathered_again() {
    let world = World::new(cornell_box()).unwrap();
    let surfaces = cornell_surfaces(&world);
    let noisy = |aim: FillTarget| {
        let options = CachedOptions { rays: 24, ..CachedOptions::default() };
        let cache = Cache::new(options, world.surroundings_hash());
        let (frozen, _) = fill_for_surfaces(&world, 1, cache, &surfaces, aim, &NeverStops);
        let records = frozen.cache.records();
        let noisy = |record: &&Record| record.standard_error > 0.3 * record.irradiance.max_element();
        (records.iter().filter(noisy).count(), records.len())
    };
    let [(before, all), (after, _)] = [FillTarget::Means, FillTarget::Options].map(noisy);
    println!("{before} of {all} records were noisy, {after} are");
    assert!(before > 20 && after * 4 < before, "{before} of {all} records were noisy, {after} are");
}

/// The root mean square of the records' standard errors is what was asked for.
#[test]
fn the_noise_of_records_is_what_was_asked_for() {
    let world = World::new(cornell_box()).unwrap();
    let surfaces = cornell_surfaces(&world);
    const ACCURACY: f64 = 0.01;
    let options = CachedOptions { accuracy: Some(ACCURACY as f32), ..CachedOptions::default() };
    let points = (surfaces.len(), |i: usize| surfaces[i]);
    let held_out = HeldOut::new(&world, &options, points, MeanLight::Total, 1, &NeverStops).unwrap();
    let cache = Cache::new(options, world.surroundings_hash());
    let (frozen, _) = fill_for_surfaces(&world, 1, cache, &surfaces, FillTarget::Accuracy(&held_out), &NeverStops);
    let records = frozen.cache.records();
    let squares = records.iter().map(|record| f64::from(record.standard_error).powi(2));
    let reached = (squares.sum::<f64>() / records.len() as f64).sqrt() / f64::from(held_out.light());
    println!("{} records: {reached}", records.len());
    assert!((0.4 * ACCURACY..0.65 * ACCURACY).contains(&reached), "{reached}");
}

/// A camera that looks down at a polished floor sees the ceiling behind it, which has records for that.
#[test]
fn what_glossy_surfaces_show_has_records() {
    let square = |y: f32, side: f32, material: usize| Mesh {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| vec3(side * x, y, z)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Mesh::default()
    };
    let mut polished = Material::matte(Vec3::splat(0.5));
    polished.inputs.specular_weight = 1.0;
    polished.inputs.specular_roughness = 0.15;
    let records_above = |floor: Material| {
        let world = World::new(Scene {
            meshes: vec![square(0.0, 1.0, 0), square(2.0, -1.0, 1)],
            materials: vec![floor, Material::matte(Vec3::splat(0.5))],
            camera: Some(CameraPose { eye: Vec3::Y, target: Vec3::ZERO, up: Vec3::Z, vfov: 60.0 }),
            ..Scene::default()
        })
        .unwrap();
        let settings = Settings { width: 64, height: 64, ..Settings::default() };
        let cache = Cache::new(CachedOptions { rays: 48, ..CachedOptions::default() }, world.surroundings_hash());
        let (frozen, _) = fill_for_camera(&world, &settings, cache, &NeverStops);
        frozen.cache.records().iter().filter(|record| record.position.y > 1.0).count()
    };
    assert_eq!(records_above(Material::matte(Vec3::splat(0.5))), 0);
    assert!(records_above(polished) > 0);
}

/// Records of a floor with a normal map are of the floor; what they say is tilted as the map says. Under a uniform sky of 1 a
/// normal at an angle θ receives `π (1 + cos θ) / 2`.
#[test]
fn records_are_of_the_surface_below_a_normal_map() {
    let mut material = Material::matte(Vec3::splat(0.5));
    let texture = TextureMap { space: ColorSpace::Linear, ..TextureMap::default() };
    material.normal_map = Some(NormalMap { texture, scale: Vec2::ONE });
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let mut scene = Scene {
        meshes: vec![Mesh {
            positions: corners.map(|(x, y)| vec3(x, y, 0.0)).to_vec(),
            texcoords: corners.map(|(x, y)| Vec2::new(x, 1.0 - y)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }],
        materials: vec![material],
        textures: vec![Texture::new(1, 1, vec![[218, 128, 218, 255]])],
        sky: Sky::constant(Vec3::ONE),
        camera: Some(CameraPose { eye: vec3(0.5, 0.5, 1.0), target: vec3(0.5, 0.5, 0.0), up: Vec3::Y, vfov: 45.0 }),
        ..Scene::default()
    };
    scene.complete_tangents();
    let world = World::new(scene).unwrap();
    let settings = Settings { width: 32, height: 32, ..Settings::default() };
    let cache = Cache::new(CachedOptions { rays: 256, ..CachedOptions::default() }, world.surroundings_hash());
    let (frozen, _) = fill_for_camera(&world, &settings, cache, &NeverStops);
    assert!(!frozen.cache.records().is_empty());
    assert!(frozen.cache.records().iter().all(|record| record.normal == Vec3::Z));
    let surface = world.surface(0, 0.3, 0.3);
    let cosine = surface.shading_normal.z;
    assert!((0.6..0.8).contains(&cosine), "the map tilts by 45°");
    let found = frozen.irradiance(&world, &surface).unwrap().y;
    let expected = std::f32::consts::PI * 0.5 * (1.0 + cosine);
    assert!((found / expected - 1.0).abs() < 0.01, "{found}, not {expected}");
}
