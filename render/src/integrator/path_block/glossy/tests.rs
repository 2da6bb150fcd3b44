//! Glossy closures in lanes are those of one path at a time.

use halfdome_kernel::sampling::Stream;
use halfdome_kernel::sampling::warp::{CosineHemisphere, UniformSphere, Warp};
use halfdome_kernel::{Level, Task};

use super::*;
use crate::material::Inputs;
use crate::scene::{CameraPose, Mesh, Scene};

const PATHS: usize = LANES - 1;

/// Triangles of all glossy materials: mirrors, rough metals, varnish, rough diffuse reflection, mixtures; every other one
/// with vertex normals of its own.
fn world() -> World {
    let material = |i: u32| {
        let stream = Stream::new(1, i, 0);
        let [red, green, blue, roughness] = stream.uniform4(0);
        let [weight, metalness, anisotropy, diffuse_roughness] = stream.uniform4(1);
        let base_metalness = [0.0, 1.0, metalness][i as usize % 3];
        let inputs = Inputs {
            base_color: Vec3::new(red, green, blue),
            base_metalness,
            base_diffuse_roughness: if i % 4 == 1 { diffuse_roughness } else { 0.0 },
            specular_weight: if i % 5 == 4 { 0.0 } else { weight },
            specular_roughness: if i.is_multiple_of(7) { 0.0 } else { roughness },
            specular_anisotropy: if i % 6 == 1 { anisotropy } else { 0.0 },
            metal_edge_color: Vec3::new(blue, red, 1.0),
            ..Inputs::default()
        };
        // Never matte.
        let diffuse_roughness = inputs.base_diffuse_roughness.max(if i % 5 == 4 { 0.2 } else { 0.0 });
        Material { inputs: Inputs { base_diffuse_roughness: diffuse_roughness, ..inputs }, ..Material::default() }
    };
    let mesh = |i: u32| {
        let corner = |set| UniformSphere.map(Stream::new(2, i, 0).uniform2(set));
        let positions = [1, 2, 3].map(corner);
        let normal = (positions[1] - positions[0]).cross(positions[2] - positions[0]).normalize();
        let normals = [4, 5, 6].map(|set| (normal + 0.4 * corner(set)).normalize());
        Mesh {
            positions: positions.into(),
            normals: if i.is_multiple_of(2) { normals.into() } else { Vec::new() },
            triangles: vec![[0, 1, 2]],
            material: i as usize,
            ..Mesh::default()
        }
    };
    let camera = CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 };
    let count = PATHS as u32;
    let (meshes, materials) = ((0..count).map(mesh).collect(), (0..count).map(material).collect());
    World::new(Scene { meshes, materials, camera: Some(camera), ..Scene::default() }).unwrap()
}

struct Step<'a> {
    closures: &'a GlossyLanes,
    block: &'a PathBlock,
    directions: &'a Vectors,
    scattered: &'a mut Scattered,
    on: &'a mut Continuations,
}

impl Task for Step<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let matte = Material::default();
        self.closures.eval_all(self.block, &matte, self.directions, self.scattered);
        self.closures.sample_all(self.block, &matte, self.on);
    }
}

/// The surface that path `i` has arrived at, along a ray that sees one of its sides.
fn surface(world: &World, i: usize) -> Surface<'_> {
    let stream = Stream::new(3, i as u32, 0);
    let [u, v, ..] = stream.uniform4(0);
    let surface = world.surface(i as u32, u.min(1.0 - v), v.min(0.9)).facing(UniformSphere.map(stream.uniform2(1)));
    // A third of them with bumps.
    let tilted = (surface.shading_normal + 0.5 * UniformSphere.map(stream.uniform2(2))).normalize();
    let shading_normal = if i % 3 == 1 { tilted } else { surface.shading_normal };
    Surface { shading_normal, ..surface }
}

#[test]
fn glossy_lanes_equal_closures_one_by_one_on_every_instruction_set() {
    let world = world();
    for isa in Level::ALL.into_iter().filter_map(Isa::new) {
        let (mut lanes, mut closures) = (GlossyLanes::default(), Closures::<Glossy>::default());
        let mut block = PathBlock::new();
        block.len = PATHS;
        let mut directions = Vectors::zeroed();
        // A block of others before, of which nothing may be left.
        for i in (0..PATHS).rev() {
            lanes.arrive(&world, &mut surface(&world, i));
        }
        lanes.arrived(isa);
        lanes.clear();
        for i in 0..PATHS {
            let stream = Stream::new(4, i as u32, 0);
            let arrived =
                [lanes.arrive(&world, &mut surface(&world, i)), closures.arrive(&world, &mut surface(&world, i))];
            assert_eq!(arrived[0], arrived[1]);
            block.u_direction[i] = stream.uniform2(0);
            block.cosine[i] = CosineHemisphere.map(block.u_direction[i]);
            // Half of them where the closure is likely to send light.
            let likely = closures.sample(i, &surface(&world, i), stream.uniform2(1), Vec3::Z).0.direction;
            directions.set(i, if i % 2 == 0 { likely } else { UniformSphere.map(stream.uniform2(2)) });
        }
        lanes.arrived(isa);
        let (mut scattered, mut on) = (Scattered::zeroed(), Continuations::zeroed());
        let (scattered_, on_) = (&mut scattered, &mut on);
        isa.run(Step { closures: &lanes, block: &block, directions: &directions, scattered: scattered_, on: on_ });
        let (mut lit, mut mirrored, mut gone) = (0, 0, 0);
        for i in 0..PATHS {
            let surface = surface(&world, i);
            let (f_cos, density) = closures.eval(i, &surface, directions.get(i));
            assert_eq!((scattered.f_cos.get(i), scattered.density[i]), (f_cos, density), "{isa:?}, {i}");
            lit += usize::from(density > 0.0);
            let (bounce, scatters) = closures.sample(i, &surface, block.u_direction[i], block.cosine[i]);
            assert_eq!(on.scatters[i] != 0, scatters, "{isa:?}, {i}");
            if !scatters {
                continue;
            }
            // Where two directions lead to one, sums are rounded otherwise.
            assert_eq!(on.direction.get(i), bounce.direction, "{isa:?}, {i}");
            let (weight, difference) = (on.weight.get(i), on.weight.get(i) - bounce.weight);
            assert!(difference.abs().max_element() <= 1e-5 * weight.max_element(), "{isa:?}, {i}: {bounce:?}");
            let is_delta = bounce.density == f32::INFINITY;
            let is_near = (on.density[i] - bounce.density).abs() <= 1e-5 * bounce.density;
            assert!(if is_delta { on.density[i] == f32::INFINITY } else { is_near }, "{isa:?}, {i}: {bounce:?}");
            mirrored += usize::from(is_delta);
            gone += 1;
        }
        assert!(lit > 30 && mirrored >= 4 && gone > 40, "{lit}, {mirrored}, {gone}");
    }
}
