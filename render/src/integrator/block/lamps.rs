//! Triangles that emit light, one for each path of a block, and the points of them that are sampled.

use glam::{Vec2, Vec3};
use halfdome_kernel::Triangle;
use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, Warp};

use super::columns::{Column, LANES, Vectors};
use crate::estimator::prospect;
use crate::world::{Surface, interpolate};

/// A triangle that emits light to the side of its normal.
pub(super) struct Lamp {
    pub corners: Triangle,
    pub normal: Vec3,
    pub offset: f32,
    pub emission: Vec3,
    /// The density per area of its points, if those were all alike.
    pub area_density: f32,
}

/// Such triangles, with numbers that say where on each.
pub(super) struct Lamps {
    corners: [Vectors; 3],
    normal: Vectors,
    offset: Column,
    emission: Vectors,
    /// The density per area of their points, if those were all alike.
    area_density: Column,
    on_lamp: [Column; 2],
    /// Whether there is one.
    pub is_there: [u32; LANES],
}

impl Lamps {
    pub(super) const NONE: Self = Self {
        corners: [Vectors::ZERO; 3],
        normal: Vectors::ZERO,
        offset: [0.0; LANES],
        emission: Vectors::ZERO,
        area_density: [0.0; LANES],
        on_lamp: [[0.0; LANES]; 2],
        is_there: [0; LANES],
    };

    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, lamp: &Lamp, u: Vec2) {
        for (corners, corner) in self.corners.iter_mut().zip(lamp.corners) {
            corners.set(i, corner);
        }
        self.normal.set(i, lamp.normal);
        self.offset[i] = lamp.offset;
        self.emission.set(i, lamp.emission);
        self.area_density[i] = lamp.area_density;
        (self.on_lamp[0][i], self.on_lamp[1][i]) = (u.x, u.y);
        self.is_there[i] = 1;
    }

    /// The point of lamp `i` that is sampled from `surface`, and its density per area.
    #[inline(always)]
    pub(super) fn point<'w>(&self, i: usize, surface: &Surface<'w>) -> (Surface<'w>, f32) {
        let corners = [self.corners[0].get(i), self.corners[1].get(i), self.corners[2].get(i)];
        let prospect = prospect(surface.position, surface.normal, &corners);
        let u = prospect.map(Vec2::new(self.on_lamp[0][i], self.on_lamp[1][i]));
        let point = TriangleWarp.map(u);
        let normal = self.normal.get(i);
        let lamp = Surface {
            position: interpolate(corners, [1.0 - point.x - point.y, point.x, point.y]),
            normal,
            shading_normal: normal,
            diffuse: Vec3::ZERO,
            emission: self.emission.get(i),
            offset: self.offset[i],
            prim_id: 0,
            is_back: false,
            material: surface.material,
        };
        (lamp, self.area_density[i] * prospect.density(u))
    }
}
