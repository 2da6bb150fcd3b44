//! A queue of rays that are about to enter items, set up eight at a time.

use super::trees::MeshAt;
use crate::bvh::WIDTH;
use crate::geometry::box_lanes::BoxLanes;
use crate::geometry::setup_lanes::SetupLanes;
use crate::geometry::{Aabb, Ray};
use crate::simd::{Lanes, Simd};

/// Up to eight rays, each with the mesh that it enters.
pub(super) struct Entering<'a, S: Simd> {
    rays: [S::F8; WIDTH],
    /// The lower and the upper corners of the meshes' boxes, a row each.
    boxes: [S::F8; WIDTH],
    meshes: [MeshAt<'a>; WIDTH],
    places: [usize; WIDTH],
    items: [u32; WIDTH],
    pub(super) len: usize,
}

impl<'a, S: Simd> Entering<'a, S> {
    #[inline(always)]
    pub(super) fn none() -> Self {
        let nan = S::F8::splat(f32::NAN);
        let (rays, boxes, meshes) = ([nan; WIDTH], [nan; WIDTH], [MeshAt::NONE; WIDTH]);
        Self { rays, boxes, meshes, places: [0; WIDTH], items: [0; WIDTH], len: 0 }
    }

    /// Adds the ray at a place, in the space of the item that it enters. There must be room.
    #[inline(always)]
    pub(super) fn push(&mut self, place: usize, item: u32, mesh: MeshAt<'a>, ray: &Ray) {
        let lane = self.len % WIDTH;
        let Aabb { min, max } = mesh.bounds;
        self.rays[lane] = S::F8::load(bytemuck::cast_ref(ray));
        self.boxes[lane] = S::F8::load(&[min.x, min.y, min.z, 0.0, max.x, max.y, max.z, 0.0]);
        (self.places[lane], self.items[lane], self.meshes[lane]) = (place, item, mesh);
        self.len += 1;
    }

    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.len >= WIDTH
    }

    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    /// The setup of the rays, each within the box of its mesh.
    #[inline(always)]
    pub(super) fn set_up(&self) -> SetupLanes<WIDTH, S::F8> {
        SetupLanes::within(S::transpose(self.rays), &BoxLanes::from_rows::<S>(self.boxes))
    }

    /// The places of the rays, the items that they enter, and where these are.
    #[inline(always)]
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, u32, &MeshAt<'a>)> {
        let items = self.items.iter().zip(&self.meshes).take(self.len);
        self.places.iter().zip(items).map(|(&place, (&item, mesh))| (place, item, mesh))
    }
}
