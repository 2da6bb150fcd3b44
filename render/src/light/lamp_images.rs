//! Images of lamps: where a lamp shows that light samples do not reach, through glass or in a flat mirror.
//!
//! Glass hides the filament of a bulb, and a bulb in a frosted globe; a bathroom's mirror shows the lamp above it a second
//! time. Bounces rarely find either, and each is a firefly in the picture. So paths aim at a box around each image as at
//! [secondary lights](super::SecondaryLights): a ray that meets glass or a mirror, and would then meet the box if it went
//! on straight, is about one that finds the lamp. The box is wider than the image if the glass or mirror is rough. From
//! there on such a path continues as any other.

use glam::Vec3;
use halfdome_kernel::{Aabb, Bvh, Quality, Ray, Triangle, triangle_normal};

use super::area;
use super::cells::TrianglePart;
use super::secondary_lights::{LitPart, Reach};
use super::tree::leaf::TriangleLight;

/// The images of a world's lamps.
#[derive(Debug, Default)]
pub(crate) struct LampImages {
    /// The lights that glass hides.
    hidden: HiddenLights,
    images: Vec<LampImage>,
    /// The triangles of the images' boxes as secondary lights, whose `prim_id`s follow those of the scene.
    parts: Vec<LitPart>,
    tree: Option<Bvh>,
    first: u32,
    /// By material, whether its faces mirror any.
    mirrors: Vec<bool>,
}

/// The lights that glass hides from light samples.
#[derive(Clone, Debug, Default)]
pub(crate) struct HiddenLights {
    /// The emissive triangles, ascending.
    pub triangles: Vec<u32>,
    /// The numbers of points and spots, ascending.
    pub points: Vec<u32>,
}

/// Where a lamp shows: the box to aim at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LampImage {
    pub bounds: Aabb,
    /// The mean radiance over the box, as luminance.
    pub radiance: f32,
    /// What shows it; `None` for glass.
    pub mirror: Option<MirrorPlane>,
}

/// The plane of a flat mirror: the points `p` with `normal · p = offset`. It reflects what is in front, where that is greater.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MirrorPlane {
    /// A unit vector.
    pub normal: Vec3,
    pub offset: f32,
    /// The material's number.
    pub material: u32,
}

impl MirrorPlane {
    /// The distance of a point in front of the plane, negative behind it.
    pub(crate) fn height(&self, point: Vec3) -> f32 {
        self.normal.dot(point) - self.offset
    }

    /// The mirror image of a point.
    pub(crate) fn image(&self, point: Vec3) -> Vec3 {
        point - 2.0 * self.height(point) * self.normal
    }

    /// A vector as the mirror reflects it.
    pub(crate) fn reflected(&self, vector: Vec3) -> Vec3 {
        vector - 2.0 * self.normal.dot(vector) * self.normal
    }
}

impl LampImages {
    /// These images, in a scene whose `prim_id`s are below `first`.
    pub(crate) fn new(hidden: HiddenLights, images: Vec<LampImage>, first: u32) -> Self {
        let faces = images.iter().flat_map(|image| box_faces(&image.bounds).map(|corners| (corners, image.radiance)));
        let part = |(corners, radiance): (Triangle, f32), prim_id| {
            let normal = triangle_normal(&corners);
            let light = TriangleLight { corners, normal, radiance, area: area(&corners), both_sides: false };
            LitPart { cell: TrianglePart::whole(prim_id), light, reach: Reach::default() }
        };
        let parts: Vec<LitPart> = faces.zip(first..).map(|(face, prim_id)| part(face, prim_id)).collect();
        let corners: Vec<Triangle> = parts.iter().map(|part| part.light.corners).collect();
        let tree = Bvh::build(&corners, &Quality::Fast.into()).ok().map(|(tree, _)| tree);
        let mut mirrors = Vec::new();
        for MirrorPlane { material, .. } in images.iter().filter_map(|image| image.mirror) {
            mirrors.resize(mirrors.len().max(material as usize + 1), false);
            mirrors[material as usize] = true;
        }
        Self { hidden, images, tree: tree.filter(|_| !corners.is_empty()), parts, first, mirrors }
    }

    /// The same without those in mirrors.
    pub(crate) fn without_mirrored(&self) -> Self {
        let images = self.images.iter().filter(|image| image.mirror.is_none()).copied().collect();
        Self::new(self.hidden.clone(), images, self.first)
    }

    /// Whether there are none.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.tree.is_none()
    }

    /// Whether glass hides an emissive triangle.
    pub(crate) fn hide(&self, triangle: u32) -> bool {
        self.hidden.triangles.binary_search(&triangle).is_ok()
    }

    /// Whether glass hides a point or spot of this number.
    pub(crate) fn hide_point(&self, light: u32) -> bool {
        self.hidden.points.binary_search(&light).is_ok()
    }

    /// The triangles of all boxes, twelve of each.
    pub(crate) fn parts(&self) -> &[LitPart] {
        &self.parts
    }

    /// The image that a `prim_id` belongs to.
    pub(crate) fn image(&self, prim_id: u32) -> Option<&LampImage> {
        let number = prim_id.checked_sub(self.first)? as usize / FACES;
        self.images.get(number)
    }

    /// Whether faces of a material mirror any.
    #[inline(always)]
    pub(crate) fn are_mirrored_by(&self, material: u32) -> bool {
        self.mirrors.get(material as usize) == Some(&true)
    }

    /// Whether any mirror shows one.
    pub(crate) fn are_mirrored(&self) -> bool {
        !self.mirrors.is_empty()
    }

    /// The `prim_id` of the first box's triangle that a ray meets beyond this distance, and its distance.
    #[inline]
    pub(crate) fn beyond(&self, ray: &Ray, distance: f32) -> Option<(u32, f32)> {
        let ray = Ray { t_min: distance, t_max: f32::INFINITY, ..*ray };
        self.tree.as_ref()?.view().intersect(&ray).map(|hit| (self.first + hit.prim_id, hit.t))
    }
}

/// Triangles of a box.
const FACES: usize = 12;

/// The triangles of a box, counter-clockwise from outside.
pub(crate) fn box_faces(bounds: &Aabb) -> [Triangle; FACES] {
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

    fn in_glass(min: Vec3, max: Vec3) -> LampImage {
        LampImage { bounds: Aabb { min, max }, radiance: 2.0, mirror: None }
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
        let near = in_glass(Vec3::splat(-1.0), Vec3::ONE);
        let far = in_glass(Vec3::new(-1.0, -1.0, 4.0), Vec3::new(1.0, 1.0, 6.0));
        let hidden = HiddenLights { triangles: vec![3, 8], points: vec![5] };
        let lamps = LampImages::new(hidden, vec![near, far], 100);
        let ray = Ray::new(Vec3::new(0.1, 0.2, -5.0), Vec3::Z);
        let box_of = |from: f32| lamps.beyond(&ray, from).map(|(id, distance)| ((id - 100) / 12, distance));
        assert_eq!([0.0, 7.0, 12.0].map(box_of), [Some((0, 4.0)), Some((1, 9.0)), None]);
        assert_eq!([99, 100, 123, 124].map(|id| lamps.image(id).is_some()), [false, true, true, false]);
        assert!(lamps.hide(8) && !lamps.hide(4) && lamps.hide_point(5) && !lamps.hide_point(8));
        assert!(lamps.parts().iter().all(|part| part.light.radiance == 2.0));
    }

    #[test]
    fn without_lamps_nothing_is_found() {
        for lamps in [LampImages::default(), LampImages::new(HiddenLights::default(), Vec::new(), 7)] {
            assert!(lamps.is_empty() && lamps.image(7).is_none());
            assert_eq!(lamps.beyond(&Ray::new(Vec3::ZERO, Vec3::Z), 0.0), None);
        }
    }

    /// A mirror in the plane z = 1, of material 2.
    const MIRROR: MirrorPlane = MirrorPlane { normal: Vec3::Z, offset: 1.0, material: 2 };

    #[test]
    fn mirrors_show_what_is_in_front_as_far_behind() {
        let point = Vec3::new(3.0, 4.0, 6.0);
        assert_eq!((MIRROR.height(point), MIRROR.image(point)), (5.0, Vec3::new(3.0, 4.0, -4.0)));
        assert_eq!(MIRROR.reflected(point), Vec3::new(3.0, 4.0, -6.0));
    }

    #[test]
    fn images_in_mirrors_can_be_left_out() {
        let [low, high] = [Vec3::ZERO, Vec3::splat(4.0)].map(|min| in_glass(min, min + 1.0));
        let mirrored = LampImage { mirror: Some(MIRROR), ..low };
        let hidden = HiddenLights { triangles: vec![1], points: Vec::new() };
        let images = LampImages::new(hidden, vec![mirrored, high], 10);
        assert!(images.are_mirrored() && images.are_mirrored_by(2));
        assert!(![0, 1, 3].into_iter().any(|material| images.are_mirrored_by(material)));
        let images = images.without_mirrored();
        assert!(!images.are_mirrored() && !images.are_mirrored_by(2) && images.hide(1));
        assert_eq!(images.parts().len(), FACES);
        assert_eq!(images.image(10).map(|image| image.bounds.min), Some(high.bounds.min));
    }
}
