//! Triangles and rays, made of integers, sums, products, quotients and square roots: the same ones everywhere.

use crate::sampling::Stream;
use crate::{Ray, Triangle};
use glam::{Vec3, vec3};

/// Triangles, and rays at them.
pub(crate) struct Scene {
    pub(crate) name: &'static str,
    pub(crate) triangles: Vec<Triangle>,
    pub(crate) rays: Vec<Ray>,
}

impl Scene {
    /// All scenes.
    pub(crate) fn all() -> Vec<Self> {
        let meshes = [("soup", soup()), ("sphere", sphere()), ("grid", grid()), ("needles", needles()), ("raw", raw())];
        let numbered = (1..).zip(meshes);
        numbered.map(|(seed, (name, triangles))| Self { name, rays: rays_at(&triangles, seed), triangles }).collect()
    }
}

/// Random numbers of a seed, one after the other.
struct Random {
    stream: Stream,
    set: u32,
}

impl Random {
    fn new(seed: u64) -> Self {
        Self { stream: Stream::new(seed, 0, 0), set: 0 }
    }
    fn bits(&mut self) -> [u32; 4] {
        self.set += 1;
        self.stream.bits4(self.set)
    }
    fn below(&mut self, count: usize) -> usize {
        self.bits()[0] as usize % count
    }
    /// A point of the cube from -1 to 1.
    fn point(&mut self) -> Vec3 {
        let [x, y, z, _] = self.bits().map(|bits| (bits >> 8) as f32 / (1 << 24) as f32);
        vec3(x, y, z) * 2.0 - 1.0
    }
    /// Floats of any sign and exponent, NaN and infinity included.
    fn raw(&mut self) -> [f32; 4] {
        self.bits().map(f32::from_bits)
    }
    fn raw_point(&mut self) -> Vec3 {
        let [x, y, z, _] = self.raw();
        vec3(x, y, z)
    }
}

/// Triangles of all sizes through each other.
fn soup() -> Vec<Triangle> {
    let mut random = Random::new(11);
    let triangle = |i: u32| {
        let (center, size) = (random.point(), 1.0 / (1 + i % 20) as f32);
        [(); 3].map(|()| center + random.point() * size)
    };
    (0..600).map(triangle).collect()
}

/// A closed sphere far from the origin: an octahedron whose faces are quartered three times.
fn sphere() -> Vec<Triangle> {
    let mut faces = Vec::new();
    for octant in 0..8 {
        let sign = |bit: u32| if octant >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let (x, y, z) = (Vec3::X * sign(0), Vec3::Y * sign(1), Vec3::Z * sign(2));
        faces.push(if sign(0) * sign(1) * sign(2) > 0.0 { [x, y, z] } else { [x, z, y] });
    }
    for _ in 0..3 {
        let quarters = |&[a, b, c]: &Triangle| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(|p| p / p.length());
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.iter().flat_map(quarters).collect();
    }
    faces.iter().map(|face| face.map(|p| p * 3.0 + vec3(1483.0, 12.0, -2234.0))).collect()
}

/// Squares along the axes, on three levels, with a second sheet in the place of the first: ties, and flat boxes.
fn grid() -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for i in 0..200 {
        let p = |x: i32, y: i32| vec3((i % 10 + x) as f32, (i / 10 % 10 + y) as f32, (i % 3) as f32);
        triangles.push([p(0, 0), p(1, 0), p(1, 1)]);
        triangles.push([p(0, 0), p(1, 1), p(0, 1)]);
    }
    triangles
}

/// Long thin triangles.
fn needles() -> Vec<Triangle> {
    let mut random = Random::new(12);
    let needle = |_| {
        let (a, b) = (random.point() * 4.0, random.point() * 4.0);
        [a, b, (a + b) * 0.5 + random.point() * 1e-5]
    };
    (0..200).map(needle).collect()
}

/// Corners of any bits, most of them out of the limits, among some that are within.
fn raw() -> Vec<Triangle> {
    let mut random = Random::new(13);
    let triangle =
        |i: u32| [(); 3].map(|()| if i.is_multiple_of(4) { random.point() * 1e6 } else { random.raw_point() });
    (0..400).map(triangle).collect()
}

/// Rays at corners, edges, insides and past triangles; along axes, in bundles, bounded, and of any bits.
fn rays_at(triangles: &[Triangle], seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let corners = || triangles.iter().flatten().filter(|p| p.abs().max_element() <= 1e6);
    let (min, max) = corners().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), &p| (min.min(p), max.max(p)));
    let (center, size) = ((min + max) * 0.5, (max - min).max_element());
    let mut rays = Vec::new();
    for i in 0..300 {
        let [a, b, c] = triangles[random.below(triangles.len())];
        let target = match i % 4 {
            0 => a,
            1 => (b + c) * 0.5,
            2 => a * 0.25 + b * 0.5 + c * 0.25,
            _ => center + random.point() * size * 0.5,
        };
        let origin = center + random.point() * size * [0.5, 1.0, 40.0][i % 3];
        let direction = (target - origin) * [1.0, 1e-6, 3e7][i / 3 % 3];
        rays.push(Ray::new(origin, direction));
        rays.push(Ray { t_min: 0.25, t_max: 1.0, ..Ray::between(origin, target) });
        let axis = [Vec3::X, Vec3::NEG_Y, Vec3::Z, vec3(-0.0, 1.0, 1.0), vec3(1.0, 1.0, -1.0)][i % 5];
        rays.push(Ray { t_min: f32::NEG_INFINITY, ..Ray::new(target - axis * size, axis) });
        let [t_min, t_max, ..] = random.raw();
        rays.push(Ray { origin: random.raw_point(), t_min, direction: random.raw_point(), t_max });
        for _ in 0..8 {
            rays.push(Ray::new(origin, direction / direction.abs().max_element() + random.point() * 0.05));
        }
    }
    rays
}
