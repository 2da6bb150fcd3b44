//! The shared code of the fuzzers: triangles and rays from bytes, and all ways to trace compared.
#![forbid(unsafe_code)]

#[path = "../../src/check.rs"]
pub mod check;
#[path = "../../src/scenes.rs"]
pub mod scenes;
#[path = "../../src/ways.rs"]
pub mod ways;

use glam::Vec3;
use halfdome_kernel::{Ray, Sphere, Triangle};

/// Bytes that are taken from the front; at their end all are zero.
pub struct Bytes<'a>(pub &'a [u8]);

impl Bytes<'_> {
    /// Whether nothing is left.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    /// An index below `count`, at most 65536.
    pub fn below(&mut self, count: usize) -> usize {
        usize::from(u16::from_le_bytes([self.byte(), self.byte()])) % count
    }

    /// 32 bits.
    pub fn word(&mut self) -> u32 {
        u32::from_le_bytes([0; 4].map(|_| self.byte()))
    }

    /// A float: often of a small grid, so that there are ties, else of any bits, NaN and infinity included.
    pub fn float(&mut self) -> f32 {
        match self.byte() {
            small @ 0..=127 => (f32::from(small) - 64.0) / 8.0,
            128..=159 => f32::from(self.below(1 << 16) as u16 as i16) / 1024.0,
            _ => f32::from_bits(self.word()),
        }
    }

    /// Three floats.
    pub fn vector(&mut self) -> Vec3 {
        Vec3::from([0; 3].map(|_| self.float()))
    }

    /// Up to `most` triangles over a pool of points, so that they share corners and edges.
    pub fn triangles(&mut self, most: usize) -> Vec<Triangle> {
        let count = self.below(most + 1);
        let pool: Vec<Vec3> = (0..1 + self.below(24)).map(|_| self.vector()).collect();
        (0..count).map(|_| [0; 3].map(|_| pool[usize::from(self.byte()) % pool.len()])).collect()
    }

    /// A sphere of any bits, or around a point.
    pub fn sphere(&mut self, near: Vec3) -> Sphere {
        match self.byte() % 4 {
            0 => Sphere::new(self.vector(), self.float()),
            1 => Sphere::new(near, self.float().abs()),
            _ => Sphere::new(near + self.vector() * 0.01, self.float().abs() * 0.01),
        }
    }

    /// A ray: of any bits, or aimed at the corners of a triangle.
    pub fn ray(&mut self, triangles: &[Triangle]) -> Ray {
        let kind = self.byte();
        let origin = self.vector();
        let (t_min, t_max) = if kind & 1 == 0 { (0.0, f32::INFINITY) } else { (self.float(), self.float()) };
        let direction = match triangles {
            _ if kind & 6 == 0 => self.vector(),
            [] => self.vector(),
            triangles => {
                let [a, b, c] = triangles[self.below(triangles.len())];
                match kind >> 1 & 3 {
                    1 => a - origin,
                    2 => (a + b) * 0.5 - origin,
                    _ => (a + b + c) / 3.0 - origin,
                }
            }
        };
        Ray { origin, t_min, direction, t_max }
    }

    /// One to `most` rays, as many as there are bytes for.
    pub fn rays(&mut self, triangles: &[Triangle], most: usize) -> Vec<Ray> {
        let mut rays = vec![self.ray(triangles)];
        while rays.len() < most && !self.is_empty() {
            rays.push(self.ray(triangles));
        }
        rays
    }
}
