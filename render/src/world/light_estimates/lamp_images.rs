//! Finds the [images of lamps](crate::light::LampImages) before tracing, and along rays. A lamp consists of the emissive
//! triangles that share corners.

use std::collections::{BTreeMap, HashMap};

use halfdome_kernel::{Ray, Triangle};

use crate::light::{LampImages, Light};
use crate::scene::UnionFind;
use crate::world::{Hit, MIDDLE, World};

impl World {
    /// All of them.
    pub(super) fn find_lamp_images(&self) -> LampImages {
        let emissive = self.emissive_triangles();
        let (hidden, mut images) = self.lamps_in_glass(&emissive);
        images.extend(self.lamps_in_mirrors(&emissive));
        LampImages::new(hidden, images, self.triangle_records.len() as u32)
    }

    /// The emissive triangles that stand still, ascending.
    pub(super) fn emissive_triangles(&self) -> Vec<u32> {
        let lights = self.lights.lights().iter();
        let mut emissive: Vec<u32> = lights
            .filter_map(|light| if let Light::Triangle(part) = light { Some(part.prim_id) } else { None })
            .filter(|&prim_id| (prim_id as usize) < self.still_records().len())
            .collect();
        emissive.sort_unstable();
        emissive.dedup();
        emissive
    }

    /// The image that a ray which has hit something meets straight behind glass or a mirror: the `prim_id` of its box's
    /// triangle, and the distance.
    #[inline(always)]
    pub(crate) fn image_behind(&self, ray: &Ray, hit: &Hit) -> Option<(u32, f32)> {
        let images = &self.lights.lamp_images;
        let is_mirror = || hit.is_hit() && images.are_mirrored_by(self.triangle_records[hit.prim_id as usize].material);
        let may_show = !images.is_empty() && (self.is_clear_glass(hit) || is_mirror());
        if may_show { images.beyond(ray, hit.t) } else { None }
    }

    /// The same along a ray.
    pub(super) fn image_along(&self, ray: &Ray) -> Option<(u32, f32)> {
        self.image_behind(ray, &self.intersect_at(ray, MIDDLE))
    }
}

/// The numbers of triangles that share corners, and of those that share some with these, ascending.
pub(super) fn connected<'a>(triangles: impl ExactSizeIterator<Item = &'a Triangle>) -> Vec<Vec<usize>> {
    let mut sets = UnionFind::new(triangles.len());
    let mut corners: HashMap<[u32; 3], u32> = HashMap::new();
    for (triangle, number) in triangles.zip(0..) {
        for corner in triangle {
            let first = *corners.entry(corner.to_array().map(f32::to_bits)).or_insert(number);
            sets.join(first, number);
        }
    }
    let mut groups: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (number, root) in sets.roots().into_iter().enumerate() {
        groups.entry(root).or_default().push(number);
    }
    groups.into_values().collect()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn triangles_that_share_corners_are_connected() {
        let triangle = |x: f32, y: f32| [Vec3::new(x, y, 0.0), Vec3::new(x + 1.0, y, 0.0), Vec3::new(x, y + 1.0, 0.0)];
        let triangles =
            [triangle(0.0, 0.0), triangle(9.0, 0.0), triangle(0.0, 1.0), triangle(1.0, 0.0), triangle(5.0, 5.0)];
        assert_eq!(connected(triangles.iter()), [vec![0, 2, 3], vec![1], vec![4]]);
        assert!(connected([].iter()).is_empty());
    }
}
