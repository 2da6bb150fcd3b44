//! A shaft that encloses the rays of a packet, and what they are traced through.
//!
//! The shaft (Haines and Wallace 1991) is swept by a box that grows or shrinks from around the rays' origins to around
//! their ends, which are at `t_max` or where they leave the scene: at the fraction `s` of their length all are in `(1 -
//! s) origins + s ends`. Where its sides cross a plane is one multiplication and one subtraction, as with a ray. It is
//! as tight for rays that converge at a light as for diverging ones.
//!
//! Positions are off by no more than what origins and ends are widened by: twice the pad of the nodes, of which a ray's
//! own box needs a quarter, and the rest leaves room for the rounding of ends, slopes and crossings, a few units each.

use glam::Vec3;

use super::Aabb;

/// What boxes are tested with for all rays at once. The upper side of the swept box passes a plane at
/// `plane * inverse - shift`, and so does the lower side.
#[derive(Clone, Copy)]
pub(crate) struct Shaft {
    /// The values of the upper sides along each axis, then of the lower ones.
    pub inverse: [[f32; 3]; 2],
    pub shift: [[f32; 3]; 2],
    /// Whether the side's coordinate increases along the rays.
    pub rises: [[bool; 3]; 2],
    /// What the box around the origins was widened by.
    pub pad: [f32; 3],
    /// Whether all rays start at one point: then the shaft is hardly wider than they are together.
    pub is_pointed: bool,
}

/// What rays are traced through.
pub(crate) struct Surroundings {
    /// The box around it.
    pub bounds: Aabb,
    /// What boxes in it are widened by, along each axis, besides the nodes' pad.
    pub pad: Vec3,
}

impl Surroundings {
    /// The greatest distances along each axis from a box of origins to anything in the bounds.
    #[inline(always)]
    pub(crate) fn reach(&self, origins: &Aabb) -> Vec3 {
        let Aabb { min, max } = self.bounds;
        let reach = (max - origins.min).abs().max((max - origins.max).abs());
        reach.max((min - origins.min).abs()).max((min - origins.max).abs())
    }
}
