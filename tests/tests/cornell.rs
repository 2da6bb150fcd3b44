//! The Cornell box against an independent path tracer: in `f64`, over all triangles at every step, with another random
//! generator, direct light by uniform points of the lamp alone, and no weights between strategies.

use std::f64::consts::PI;

use glam::DVec3;
use halfdome::scene::{CameraPose, Scene, cornell_box};
use halfdome::settings::Settings;
use halfdome_tests::random::Pcg;
use halfdome_tests::render::{Estimate, pixels, render, view};

const SIDE: u32 = 16;
/// Regions along a side of the picture.
const REGIONS: usize = 4;
/// Independent pictures of either renderer.
const BATCHES: u64 = 32;
/// Cells along a side of a pixel, in which the other renderer's samples are.
const GRID: u32 = 16;
const SAMPLES: u32 = GRID * GRID;

/// A triangle with all that the tracer asks of it.
struct Face {
    corner: DVec3,
    edges: [DVec3; 2],
    normal: DVec3,
    area: f64,
    reflectance: DVec3,
    emission: DVec3,
}

struct Tracer {
    faces: Vec<Face>,
    camera: CameraPose,
}

impl Tracer {
    fn new(scene: &Scene) -> Self {
        let mut faces = Vec::new();
        for mesh in &scene.meshes {
            let material = &scene.materials[mesh.material];
            for corners in &mesh.triangles {
                let [a, b, c] = corners.map(|i| mesh.positions[i as usize].as_dvec3());
                let cross = (b - a).cross(c - a);
                faces.push(Face {
                    corner: a,
                    edges: [b - a, c - a],
                    normal: cross.normalize(),
                    area: cross.length() / 2.0,
                    reflectance: material.inputs.base_color.as_dvec3(),
                    emission: material.emission.as_dvec3(),
                });
            }
        }
        Self { faces, camera: scene.camera.unwrap() }
    }

    /// The nearest face along a ray, before `end`, and its distance.
    fn trace(&self, origin: DVec3, direction: DVec3, end: f64) -> Option<(f64, &Face)> {
        let mut nearest = None;
        let mut end = end;
        for face in &self.faces {
            // Möller and Trumbore 1997.
            let [ab, ac] = face.edges;
            let p = direction.cross(ac);
            let inverse = 1.0 / ab.dot(p);
            let s = origin - face.corner;
            let u = s.dot(p) * inverse;
            let q = s.cross(ab);
            let v = direction.dot(q) * inverse;
            let t = ac.dot(q) * inverse;
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-9 && t < end {
                end = t;
                nearest = Some((t, face));
            }
        }
        nearest
    }

    /// A sample of the light that reaches a point from a uniform point of all emitters; their fronts alone emit.
    fn direct(&self, point: DVec3, normal: DVec3, random: &mut Pcg) -> DVec3 {
        let emitters = || self.faces.iter().filter(|face| face.emission != DVec3::ZERO);
        let total: f64 = emitters().map(|face| face.area).sum();
        let mut rest = random.unit() * total;
        let chosen = emitters().find(|face| {
            rest -= face.area;
            rest < 0.0
        });
        let Some(face) = chosen else { return DVec3::ZERO };
        // A point of the parallelogram, folded into the triangle.
        let (mut u, mut v) = (random.unit(), random.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let to_light = face.corner + face.edges[0] * u + face.edges[1] * v - point;
        let distance = to_light.length();
        let direction = to_light / distance;
        let cosines = normal.dot(direction).max(0.0) * (-face.normal.dot(direction)).max(0.0);
        if cosines == 0.0 || self.trace(point, direction, distance * (1.0 - 1e-9)).is_some() {
            return DVec3::ZERO;
        }
        face.emission * (cosines * total / (distance * distance))
    }

    /// A sample of the radiance along a ray.
    fn radiance(&self, mut origin: DVec3, mut direction: DVec3, random: &mut Pcg) -> DVec3 {
        let mut sum = DVec3::ZERO;
        let mut throughput = DVec3::ONE;
        for bounce in 0.. {
            let Some((t, face)) = self.trace(origin, direction, f64::INFINITY) else { break };
            let front = face.normal.dot(direction) < 0.0;
            // Light that hits the eye is seen; light that a bounce finds is what `direct` has sampled before.
            if bounce == 0 && front {
                sum += face.emission;
            }
            let normal = if front { face.normal } else { -face.normal };
            origin += direction * t;
            throughput *= face.reflectance;
            sum += throughput / PI * self.direct(origin, normal, random);
            if bounce >= 2 {
                const SURVIVAL: f64 = 0.7;
                if random.unit() >= SURVIVAL {
                    break;
                }
                throughput /= SURVIVAL;
            }
            // A point of the sphere that touches the surface lies in a direction with the density cos θ / π.
            direction = (normal + random.on_sphere()).normalize();
        }
        sum
    }

    fn picture(&self, seed: u64) -> Vec<DVec3> {
        let mut random = Pcg::new(seed);
        let mut pixel = |x: u32, y: u32| {
            // One sample for each cell of a grid in the pixel: else the lamp's edges make most of the noise.
            let samples = (0..SAMPLES).map(|i| {
                let place = |cell: u32, random: &mut Pcg| (f64::from(cell) + random.unit()) / f64::from(GRID);
                let x = f64::from(x) + place(i % GRID, &mut random);
                let y = f64::from(y) + place(i / GRID, &mut random);
                let direction = view(&self.camera, (SIDE, SIDE), x, y);
                self.radiance(self.camera.eye.as_dvec3(), direction, &mut random)
            });
            samples.sum::<DVec3>() / f64::from(SAMPLES)
        };
        (0..SIDE * SIDE).map(|i| pixel(i % SIDE, i / SIDE)).collect()
    }
}

/// The means of the regions, row by row, and last that of the whole picture.
fn regions(pixels: &[DVec3]) -> Vec<DVec3> {
    let side = SIDE as usize;
    let mut means = vec![DVec3::ZERO; REGIONS * REGIONS];
    for (i, pixel) in pixels.iter().enumerate() {
        let (column, row) = (i % side * REGIONS / side, i / side * REGIONS / side);
        means[row * REGIONS + column] += pixel * (REGIONS * REGIONS) as f64 / pixels.len() as f64;
    }
    means.push(pixels.iter().sum::<DVec3>() / pixels.len() as f64);
    means
}

fn estimates(pictures: impl Iterator<Item = Vec<DVec3>>) -> Vec<Estimate> {
    let all: Vec<_> = pictures.map(|picture| regions(&picture)).collect();
    (0..=REGIONS * REGIONS).map(|i| Estimate::of(&all.iter().map(|means| means[i]).collect::<Vec<_>>())).collect()
}

#[test]
fn two_path_tracers_agree_on_the_cornell_box() {
    let scene = cornell_box();
    let settings = |seed| Settings { width: SIDE, height: SIDE, spp: SAMPLES, seed, ..Settings::default() };
    let ours = estimates((0..BATCHES).map(|seed| pixels(&render(&scene, &settings(seed)))));
    let tracer = Tracer::new(&scene);
    let theirs = estimates((0..BATCHES).map(|seed| tracer.picture(seed)));
    for (region, (ours, theirs)) in ours.iter().zip(&theirs).enumerate() {
        let z = ours.z(theirs, 1e-5);
        assert!(z.max_element() < 4.0, "region {region}: {ours:?}, not {theirs:?}; z {z}");
    }
    let (ours, theirs) = (ours[REGIONS * REGIONS], theirs[REGIONS * REGIONS]);
    // Both are good enough for the comparison to mean something: half a per cent is three of their standard errors.
    assert!((ours.error / ours.mean).max_element() < 0.001 && (theirs.error / theirs.mean).max_element() < 0.0015);
    assert!(((ours.mean - theirs.mean) / theirs.mean).abs().max_element() < 0.005, "{ours:?}, not {theirs:?}");
}
