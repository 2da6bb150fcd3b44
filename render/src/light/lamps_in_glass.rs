//! Lamps in glass: emissive triangles that glass hides from light samples, such as the filament of a bulb, or a bulb in a
//! frosted globe.
//!
//! Paths aim at a box around each lamp as at [secondary lights](super::SecondaryLights): a ray that meets glass, and would
//! then meet the box if it went on straight, is about one that finds the lamp. The box is wider than the lamp, as rough
//! glass shows a larger one. From the glass on such a path continues as any other.

use glam::Vec3;
use halfdome_kernel::{Aabb, Bvh, Quality, Ray, Triangle, triangle_normal};

use super::area;
use super::cells::TrianglePart;
use super::secondary_lights::{LitPart, Reach};
use super::tree::leaf::TriangleLight;

/// The lamps in glass of a world.
#[derive(Debug, Default)]
pub(crate) struct LampsInGlass {
    /// The emissive triangles, ascending.
    triangles: Vec<u32>,
    /// The numbers of points and spots, ascending.
    points: Vec<u32>,
    /// The triangles of the boxes as secondary lights, whose `prim_id`s follow those of the scene.
    parts: Vec<LitPart>,
    tree: Option<Bvh>,
    first: u32,
}

/// A lamp in glass: the box to aim at, and the power per area of its surface, over π.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LampBox {
    pub bounds: Aabb,
    /// As luminance.
    pub radiance: f32,
}

impl LampsInGlass {
    /// These lamps, which consist of emissive triangles, and points and spots, by numbers that ascend, in a scene whose
    /// `prim_id`s are below `first`.
    pub(crate) fn new((triangles, points): (Vec<u32>, Vec<u32>), lamps: &[LampBox], first: u32) -> Self {
        let faces = lamps.iter().flat_map(|lamp| box_faces(&lamp.bounds).map(|corners| (corners, lamp.radiance)));
        let part = |(corners, radiance): (Triangle, f32), prim_id| {
            let normal = triangle_normal(&corners);
            let light = TriangleLight { corners, normal, radiance, area: area(&corners), both_sides: false };
            LitPart { cell: TrianglePart::whole(prim_id), light, reach: Reach::default() }
        };
        let parts: Vec<LitPart> = faces.zip(first..).map(|(face, prim_id)| part(face, prim_id)).collect();
        let corners: Vec<Triangle> = parts.iter().map(|part| part.light.corners).collect();
        let tree = Bvh::build(&corners, &Quality::Fast.into()).ok().map(|(tree, _)| tree);
        Self { triangles, points, tree: tree.filter(|_| !corners.is_empty()), parts, first }
    }

    /// Whether there are none.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.tree.is_none()
    }

    /// Whether an emissive triangle belongs to one.
    pub(crate) fn contain(&self, triangle: u32) -> bool {
        self.triangles.binary_search(&triangle).is_ok()
    }

    /// Whether a point or spot of this number does.
    pub(crate) fn contain_point(&self, light: u32) -> bool {
        self.points.binary_search(&light).is_ok()
    }

    /// The triangles of all boxes.
    pub(crate) fn parts(&self) -> &[LitPart] {
        &self.parts
    }

    /// Whether this is the `prim_id` of a box's triangle.
    pub(crate) fn are_known_as(&self, prim_id: u32) -> bool {
        !self.is_empty() && prim_id >= self.first
    }

    /// The `prim_id` of the first box's triangle that a ray meets beyond this distance, and its distance.
    #[inline]
    pub(crate) fn beyond(&self, ray: &Ray, distance: f32) -> Option<(u32, f32)> {
        let ray = Ray { t_min: distance, t_max: f32::INFINITY, ..*ray };
        self.tree.as_ref()?.view().intersect(&ray).map(|hit| (self.first + hit.prim_id, hit.t))
    }
}

/// The triangles of a box, counter-clockwise from outside.
pub(crate) fn box_faces(bounds: &Aabb) -> [Triangle; 12] {
    let corner = |number: u32| {
        let is_high = |axis: u32| number >> axis & 1 == 1;
        let at = |axis: u32| if is_high(axis) { bounds.max } else { bounds.min };
        Vec3::new(at(0).x, at(1).y, at(2).z)
    };
    // Each face by its corners, as bits of x, y and z.
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    std::array::from_fn(|number| {
        let [a, b, c, d] = quads[number / 2].map(corner);
        if number % 2 == 0 { [a, b, c] } else { [a, c, d] }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lamp(min: Vec3, max: Vec3) -> LampBox {
        LampBox { bounds: Aabb { min, max }, radiance: 2.0 }
    }

    #[test]
    fn boxes_have_six_faces_that_face_outwards() {
        let bounds = Aabb { min: Vec3::new(1.0, 2.0, 3.0), max: Vec3::new(2.0, 4.0, 6.0) };
        let middle = 0.5 * (bounds.min + bounds.max);
        let outwards = |face: &Triangle| triangle_normal(face).dot(face[0] - middle) > 0.0;
        assert!(box_faces(&bounds).iter().all(outwards));
        let all: f32 = box_faces(&bounds).iter().map(area).sum();
        assert!((all - 2.0 * (2.0 + 3.0 + 6.0)).abs() < 1e-5, "{all}");
    }

    #[test]
    fn rays_find_the_first_box_beyond_a_distance() {
        let lamps = [lamp(Vec3::splat(-1.0), Vec3::ONE), lamp(Vec3::new(-1.0, -1.0, 4.0), Vec3::new(1.0, 1.0, 6.0))];
        let lamps = LampsInGlass::new((vec![3, 8], vec![5]), &lamps, 100);
        let ray = Ray::new(Vec3::new(0.1, 0.2, -5.0), Vec3::Z);
        let box_of = |from: f32| lamps.beyond(&ray, from).map(|(id, distance)| ((id - 100) / 12, distance));
        assert_eq!([0.0, 7.0, 12.0].map(box_of), [Some((0, 4.0)), Some((1, 9.0)), None]);
        assert!(lamps.are_known_as(100) && !lamps.are_known_as(99));
        assert!(lamps.contain(8) && !lamps.contain(4) && lamps.contain_point(5) && !lamps.contain_point(8));
        assert!(lamps.parts().iter().all(|part| part.light.radiance == 2.0));
    }

    #[test]
    fn without_lamps_nothing_is_found() {
        for lamps in [LampsInGlass::default(), LampsInGlass::new((Vec::new(), Vec::new()), &[], 7)] {
            assert!(lamps.is_empty() && !lamps.are_known_as(7));
            assert_eq!(lamps.beyond(&Ray::new(Vec3::ZERO, Vec3::Z), 0.0), None);
        }
    }
}
