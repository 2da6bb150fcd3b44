//! Domains of warps, parametrised by the unit square independently of the warps.

use core::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec2, Vec3};

/// A parametrisation of a domain by the unit square in double precision, made independently of the warps.
pub(super) trait Chart: Copy {
    type Point: Copy + PartialEq + core::fmt::Debug;
    /// The point at (s, t) and the measure per ds dt there.
    fn at(self, s: f64, t: f64) -> (Self::Point, f64);
    /// The (s, t) of a point.
    fn of(self, point: Self::Point) -> [f64; 2];
    fn coordinates(point: Self::Point) -> [f32; 3];
    fn distance(a: Self::Point, b: Self::Point) -> f32;
    /// By how much the unit square shows rounding errors of the whole domain enlarged.
    fn magnification(self) -> f32 {
        1.0
    }
}

pub(super) fn turn(y: f64, x: f64) -> f64 {
    (y.atan2(x) / TAU).rem_euclid(1.0)
}

/// The directions with z ≥ 1 - `height`, by z and the azimuth.
#[derive(Clone, Copy)]
pub(super) struct Cap {
    pub(super) height: f64,
}

impl Chart for Cap {
    type Point = Vec3;
    fn at(self, s: f64, t: f64) -> (Vec3, f64) {
        let h = s * self.height;
        let r = (h * (2.0 - h)).sqrt();
        let (sin, cos) = (t * TAU).sin_cos();
        (DVec3::new(r * cos, r * sin, 1.0 - h).as_vec3(), TAU * self.height)
    }
    fn of(self, p: Vec3) -> [f64; 2] {
        let p = p.as_dvec3();
        let h = if p.z > 0.0 { (p.x * p.x + p.y * p.y) / (1.0 + p.z) } else { 1.0 - p.z };
        [h / self.height, turn(p.y, p.x)]
    }
    fn coordinates(p: Vec3) -> [f32; 3] {
        p.to_array()
    }
    // With z² for z: beside the horizon the cosine maps' z is a root, which rounding of u moves by far more than x and
    // y.
    fn distance(a: Vec3, b: Vec3) -> f32 {
        let flat = |p: Vec3| Vec3::new(p.x, p.y, p.z * p.z.abs());
        flat(a).distance(flat(b))
    }
}

/// A patch of the hemisphere between two heights and two azimuths, by these.
#[derive(Clone, Copy)]
pub(super) struct Patch {
    pub(super) z: [f64; 2],
    pub(super) turns: [f64; 2],
}

impl Chart for Patch {
    type Point = Vec3;
    fn at(self, s: f64, t: f64) -> (Vec3, f64) {
        let ([z0, z1], [t0, t1]) = (self.z, self.turns);
        let z = z0 + s * (z1 - z0);
        let (sin, cos) = ((t0 + t * (t1 - t0)) * TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        (DVec3::new(r * cos, r * sin, z).as_vec3(), (z1 - z0) * (t1 - t0) * TAU)
    }
    fn of(self, p: Vec3) -> [f64; 2] {
        let p = p.as_dvec3();
        let unit = |x: f64, [from, to]: [f64; 2]| (x - from) / (to - from);
        // Rounding may carry a direction a hair over the border.
        [unit(p.z, self.z), unit(turn(p.y, p.x), self.turns)].map(|x| if x.abs() < 1e-5 { x.max(0.0) } else { x })
    }
    fn coordinates(p: Vec3) -> [f32; 3] {
        p.to_array()
    }
    fn distance(a: Vec3, b: Vec3) -> f32 {
        Cap::distance(a, b)
    }
    fn magnification(self) -> f32 {
        (1.0 / (self.turns[1] - self.turns[0])) as f32
    }
}

/// The unit disc by radius and angle.
#[derive(Clone, Copy)]
pub(super) struct Disc;

impl Chart for Disc {
    type Point = Vec2;
    fn at(self, s: f64, t: f64) -> (Vec2, f64) {
        ((s * DVec2::from_angle(t * TAU)).as_vec2(), s * TAU)
    }
    fn of(self, p: Vec2) -> [f64; 2] {
        let p = p.as_dvec2();
        [p.length(), turn(p.y, p.x)]
    }
    fn coordinates(p: Vec2) -> [f32; 3] {
        [p.x, p.y, 0.0]
    }
    fn distance(a: Vec2, b: Vec2) -> f32 {
        a.distance(b)
    }
}

/// The triangle of barycentric coordinates by their sum and the second's share of it.
#[derive(Clone, Copy)]
pub(super) struct Barycentric;

impl Chart for Barycentric {
    type Point = Vec2;
    fn at(self, s: f64, t: f64) -> (Vec2, f64) {
        (DVec2::new(s * (1.0 - t), s * t).as_vec2(), s)
    }
    fn of(self, p: Vec2) -> [f64; 2] {
        let p = p.as_dvec2();
        [p.x + p.y, if p.y > 0.0 { p.y / (p.x + p.y) } else { 0.0 }]
    }
    fn coordinates(p: Vec2) -> [f32; 3] {
        [p.x, p.y, 1.0 - p.x - p.y]
    }
    fn distance(a: Vec2, b: Vec2) -> f32 {
        a.distance(b)
    }
}

/// The unit square itself.
#[derive(Clone, Copy)]
pub(super) struct Square;

impl Chart for Square {
    type Point = Vec2;
    fn at(self, s: f64, t: f64) -> (Vec2, f64) {
        (DVec2::new(s, t).as_vec2(), 1.0)
    }
    fn of(self, p: Vec2) -> [f64; 2] {
        p.as_dvec2().to_array()
    }
    fn coordinates(p: Vec2) -> [f32; 3] {
        [p.x, p.y, 0.0]
    }
    fn distance(a: Vec2, b: Vec2) -> f32 {
        a.distance(b)
    }
}
