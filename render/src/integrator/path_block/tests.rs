//! Lanes equal paths one by one.

use glam::{Affine3A, Quat};
use halfdome_kernel::sampling::Stream;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Triangle as TriangleWarp, UniformSphere, Warp};
use halfdome_kernel::{Isa, Level, Task};

use super::*;
use crate::estimator::{ShadowRay, sample_direct};
use crate::integrator::state::u_light_choice;
use crate::light::SkyPart;
use crate::scene::{CameraPose, Instance, Mesh, Object, Scene};
use crate::settings::LightSampling;
use crate::world::MIDDLE;

/// A block's step, compiled for an instruction set.
struct Step<'a> {
    world: &'a World,
    paths: &'a [Path],
    rays: &'a [Ray],
    lights: LightSampling,
    matte: &'a Material,
    block: &'a mut PathBlock,
    shadows: &'a mut ShadowRays,
    bounces: &'a mut Bounces,
}

impl Task for Step<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { world, paths, rays, lights, matte, block, shadows, bounces } = self;
        block.arrive(world, paths, rays);
        block.roulette(Survival::Throughput { max: 0.9 });
        assert!(block.choose_lights(world, SkyPart::Bright));
        block.sample_lights(&Lambert, lights, matte, shadows);
        block.bounce(&Lambert, matte, bounces);
    }
}

/// Triangles anywhere, every second one a light, of which every other shines to both sides. Every fourth one, which is
/// none, may be in an object with two instances, and comes after the others then.
fn world(triangles: u32, has_instances: bool) -> World {
    let material = |i: u32| {
        let [red, green, blue, _] = Stream::new(1, i, 0).uniform4(0);
        let (diffuse, emission) = (Vec3::new(red, green, blue), Vec3::new(blue, red, green) * (i % 2) as f32);
        Material { emission, emits_both_sides: i % 4 == 3, ..Material::matte(diffuse) }
    };
    let mesh = |i: u32| Mesh {
        positions: [1, 2, 3].map(|set| UniformSphere.map(Stream::new(1, i, 0).uniform2(set))).into(),
        triangles: vec![[0, 1, 2]],
        material: i as usize,
        object: (has_instances && i.is_multiple_of(4)).then_some(0),
        ..Mesh::default()
    };
    let camera = CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 };
    let (meshes, materials) = ((0..triangles).map(mesh).collect(), (0..triangles).map(material).collect());
    let turn = Quat::from_rotation_y(1.0);
    let at = |scale: Vec3| Affine3A::from_scale_rotation_translation(scale, turn, Vec3::new(0.3, -0.2, 0.1));
    let instances =
        [Vec3::splat(0.7), Vec3::new(-1.0, 2.0, 0.5)].map(|scale| Instance { object: 0, to_world: at(scale) });
    let (objects, instances) =
        if has_instances { (vec![Object::default()], instances.to_vec()) } else { (vec![], vec![]) };
    World::new(Scene { meshes, materials, objects, instances, camera: Some(camera), ..Scene::default() }).unwrap()
}

/// A path that comes to a point of a triangle.
fn path(number: u32, triangles: u32, has_instances: bool) -> (Path, Ray, Hit) {
    let stream = Stream::new(2, number, 0);
    let [red, green, blue, density] = stream.uniform4(0);
    let throughput = Vec3::new(red, green, blue);
    let path = Path { throughput, density, ..Path::from_camera(1000 + number, 0.0) };
    let ray = Ray::new(Vec3::ZERO, UniformSphere.map(stream.uniform2(1)));
    let point = TriangleWarp.map(stream.uniform2(2));
    let prim_id = number * 7 % triangles;
    let is_shared = has_instances && prim_id >= triangles * 3 / 4;
    let instance = if is_shared { 1 + number % 2 } else { 0 };
    (path, ray, Hit { t: 1.0, u: point.x, v: point.y, prim_id, instance, time: MIDDLE })
}

#[test]
fn lanes_equal_paths_one_by_one_on_every_instruction_set() {
    lanes_equal_paths(40, false);
    lanes_equal_paths(40, true);
    // So many lights that their tree has several levels.
    lanes_equal_paths(1000, false);
}

fn lanes_equal_paths(triangles: u32, has_instances: bool) {
    let (world, matte) = (world(triangles, has_instances), Material::default());
    // One lane less than there are: what is behind the last path must not count.
    let count = LANES - 1;
    let numbers: Vec<_> = (0..count).map(|i| path(i as u32, triangles, has_instances)).collect();
    // Not in the order of the lanes.
    let (paths, rays): (Vec<Path>, Vec<Ray>) = numbers.iter().rev().map(|(path, ray, _)| (*path, *ray)).unzip();
    let (mut lit, mut unlit) = (0, 0);
    for isa in Level::ALL.into_iter().filter_map(Isa::new) {
        for lights in [LightSampling::Naive, LightSampling::Direct, LightSampling::Mis] {
            let (mut block, mut shadows, mut bounces) = (PathBlock::new(), ShadowRays::new(), Bounces::new());
            block.len = count;
            for (i, (_, _, hit)) in numbers.iter().enumerate() {
                block.put(i, count - 1 - i, hit);
                let stream = Stream::new(3, i as u32, 0);
                (block.u_light[i], block.u_direction[i]) = (stream.uniform2(0), stream.uniform2(1));
                (block.cosine[i], block.u_roulette[i]) =
                    (CosineHemisphere.map(block.u_direction[i]), stream.uniform2(2).x);
            }
            let (block_, shadows_, bounces_) = (&mut block, &mut shadows, &mut bounces);
            isa.run(Step {
                world: &world,
                paths: &paths,
                rays: &rays,
                lights,
                matte: &matte,
                block: block_,
                shadows: shadows_,
                bounces: bounces_,
            });
            let (mut found_shadows, mut found_lights) = (vec![Ray::zeroed(); count], vec![[0.0; 4]; count]);
            let connections = shadows.keep(isa, count, &mut found_shadows, &mut found_lights);
            let (mut next_rays, mut next_paths) = (vec![Ray::zeroed(); count], paths.clone());
            let kept = bounces.keep(isa, count, &mut next_rays, &mut next_paths);
            let mut connected = found_shadows[..connections].iter().zip(&found_lights);
            let mut gone_on = next_rays[..kept].iter().zip(&next_paths);
            for (i, (path, ray, hit)) in numbers.iter().enumerate() {
                let seen = world.surface_at(hit);
                assert_eq!(block.is_general(i), seen.emitted(ray.direction) != Vec3::ZERO, "{isa:?}, {i}");
                let mut surface = seen.facing(ray.direction);
                let scattering = world.scattering(&mut surface);
                // A light, as one path would sample it.
                let u = u_light_choice(block.u_light[i], block.u_direction[i]);
                let sample =
                    sample_direct(&world, &surface, &scattering, (lights, SkyPart::Bright), (u, block.u_light[i].y))
                        .next();
                unlit += usize::from(sample.is_none());
                if let Some(ShadowRay { ray, radiance, .. }) = sample {
                    let (shadow, found) = connected.next().unwrap();
                    let light_found = Vec3::new(found[1], found[2], found[3]);
                    assert_eq!((*shadow, found[0].to_bits()), (ray, path.index), "{isa:?}, {lights:?}, {i}");
                    assert_eq!(light_found, path.throughput * radiance, "{isa:?}, {lights:?}, {i}");
                    lit += 1;
                }
                let survival = (path.throughput * surface.diffuse).max_element().min(0.9);
                if let Some(bounce) = scattering.sample(block.u_direction[i])
                    && block.u_roulette[i] < survival
                {
                    let (next_ray, next) = gone_on.next().unwrap();
                    let origin = surface.origin_towards(bounce.direction);
                    assert_eq!(*next_ray, Ray::new(origin, bounce.direction), "{isa:?}, {i}");
                    let normal = surface.receiver().packed();
                    assert_eq!((next.index, next.normal, next.density), (path.index, normal, bounce.density));
                    assert_eq!(next.throughput, path.throughput * survival.recip() * bounce.weight, "{isa:?}, {i}");
                }
            }
            assert!(connected.next().is_none() && gone_on.next().is_none());
        }
    }
    assert!(lit > 50 && unlit > 5, "{lit}, {unlit}");
}

/// A block of paths that have arrived in a world of 40 triangles.
fn arrived(world: &World) -> (Vec<(Path, Ray, Hit)>, PathBlock) {
    let numbers: Vec<_> = (0..LANES).map(|i| path(i as u32, 40, false)).collect();
    let (paths, rays): (Vec<Path>, Vec<Ray>) = numbers.iter().map(|(path, ray, _)| (*path, *ray)).unzip();
    let mut block = PathBlock::new();
    block.len = LANES;
    numbers.iter().enumerate().for_each(|(i, (_, _, hit))| block.put(i, i, hit));
    block.arrive(world, &paths, &rays);
    (numbers, block)
}

#[test]
fn thresholds_end_the_paths_below_them() {
    let (world, cutoff) = (world(40, false), 0.3);
    let (numbers, mut block) = arrived(&world);
    block.end_below_threshold(cutoff);
    let mut ended = 0;
    for (i, (path, _, hit)) in numbers.iter().enumerate() {
        let reflected = path.throughput * world.surface_at(hit).diffuse;
        let expected = (reflected.max_element() < cutoff).then_some((path.index, reflected));
        assert_eq!(block.ended(i), expected, "{i}");
        ended += usize::from(expected.is_some());
    }
    assert!((10..LANES - 10).contains(&ended), "{ended}");
}

#[test]
fn matte_lanes_with_bumps_equal_closures_one_by_one() {
    let (world, matte) = (world(40, false), Material::default());
    let (numbers, mut block) = arrived(&world);
    let (mut directions, mut unbent, mut surfaces) = (Vectors::zeroed(), Vec::new(), Vec::new());
    for (i, (_, ray, hit)) in numbers.iter().enumerate() {
        let stream = Stream::new(5, i as u32, 0);
        let surface = world.surface_at(hit).facing(ray.direction);
        // Every other one has bumps.
        let tilted = (surface.normal + 0.6 * UniformSphere.map(stream.uniform2(0))).normalize();
        let shading_normal = if i % 2 == 0 { tilted } else { surface.normal };
        let mut surface = Surface { shading_normal, ..surface };
        unbent.push(surface);
        let albedo = Lambert.arrive(&world, &mut surface);
        block.set(i, &surface, albedo);
        block.cosine[i] = CosineHemisphere.map(stream.uniform2(1));
        directions.set(i, surface.above(UniformSphere.map(stream.uniform2(2))));
        surfaces.push(surface);
    }
    let (mut scattered, mut on) = (Scattered::zeroed(), Continuations::zeroed());
    Lambert.eval_all(&block, &matte, &directions, &mut scattered);
    Lambert.sample_all(&block, &matte, &mut on);
    let mut shadowed = 0;
    for (i, surface) in surfaces.iter().enumerate() {
        let (f_cos, density) = Lambert.eval(i, surface, directions.get(i));
        assert_eq!((scattered.f_cos.get(i), scattered.density[i]), (f_cos, density), "{i}");
        let (expected, _) = world.scattering(&mut unbent[i].clone()).eval(directions.get(i));
        assert!(f_cos.abs_diff_eq(expected, 1e-5), "{i}: {f_cos}, {expected}");
        let (bounce, _) = Lambert.sample(i, surface, Vec2::ZERO, block.cosine[i]);
        assert_eq!((on.direction.get(i), on.weight.get(i)), (bounce.direction, bounce.weight), "{i}");
        shadowed += usize::from(on.weight.get(i) != surface.diffuse);
    }
    assert!((LANES / 4..=LANES / 2).contains(&shadowed), "{shadowed}");
}
