//! Boxes around the image of a mesh under a transform.
//!
//! The box around a rotated box is larger than necessary, for a ball by up to √3 along each axis, and rays enter items
//! that they miss. So the transform is applied to the boxes two levels down in the mesh's tree, about 64. Along an axis
//! with the matrix's row `m`, the greatest coordinate of the image of a box is `t + Σ_j max(m_j lower_j, m_j upper_j)`.

use core::array;

use glam::{Affine3A, Vec3};

use crate::bvh::{BvhView, Child, Node, WIDTH};
use crate::geometry::Aabb;
use crate::simd::{Lanes, Simd, Work, dispatch};

/// Rounding of three products and three sums, in units of the sum of their magnitudes.
const ROUNDING: f32 = 8.0 / (1u32 << 24) as f32;

/// A box around the image of a mesh's boxes, and so of its triangles.
pub(super) fn image_of_mesh(to_scene: &Affine3A, tree: &BvhView) -> Aabb {
    let Aabb { min, max } = tree.bounds();
    if tree.bounds().is_empty() {
        return Aabb::EMPTY;
    }
    let rows: [[f32; 3]; 3] = array::from_fn(|row| to_scene.matrix3.row(row).to_array());
    let translation = to_scene.translation.to_array();
    let image = dispatch(tree.isa(), Image { rows, translation, nodes: tree.nodes() });
    let reach = min.abs().max(max.abs()).to_array();
    let pads: [f32; 3] = array::from_fn(|k| {
        let products: f32 = (0..3).map(|j| rows[k][j].abs() * reach[j]).sum();
        ROUNDING * (products + translation[k].abs())
    });
    let pads = Vec3::from_array(pads);
    Aabb { min: image.min - pads, max: image.max + pads }
}

/// The box around the images of boxes, but for rounding.
struct Image<'a> {
    /// The rows of the matrix.
    rows: [[f32; 3]; 3],
    translation: [f32; 3],
    nodes: &'a [Node],
}

impl Work for Image<'_> {
    type Output = Aabb;

    #[inline(always)]
    fn run<S: Simd>(self) -> Aabb {
        let mut lower = [S::F8::splat(f32::INFINITY); 3];
        let mut upper = [S::F8::splat(f32::NEG_INFINITY); 3];
        let mut root = self.nodes[0];
        for slot in 0..WIDTH {
            if Child::is_node(root.children[slot]) {
                self.add::<S>(&self.nodes[root.children[slot] as usize], &mut lower, &mut upper);
                for [lower, upper] in &mut root.planes {
                    (lower[slot], upper[slot]) = (f32::INFINITY, f32::NEG_INFINITY);
                }
            }
        }
        self.add::<S>(&root, &mut lower, &mut upper);
        let least = |lanes: S::F8| lanes.store().into_iter().fold(f32::INFINITY, f32::min);
        let greatest = |lanes: S::F8| lanes.store().into_iter().fold(f32::NEG_INFINITY, f32::max);
        Aabb { min: Vec3::from_array(lower.map(least)), max: Vec3::from_array(upper.map(greatest)) }
    }
}

impl Image<'_> {
    /// Adds the boxes of a node. Empty slots have inverted boxes, whose images are inverted or NaN, which changes
    /// nothing.
    #[inline(always)]
    fn add<S: Simd>(&self, node: &Node, lower: &mut [S::F8; 3], upper: &mut [S::F8; 3]) {
        let planes = node.planes.each_ref().map(|sides| sides.each_ref().map(S::F8::load));
        for (k, row) in self.rows.iter().enumerate() {
            let (mut low, mut high) = (S::F8::splat(self.translation[k]), S::F8::splat(self.translation[k]));
            for (&element, [below, above]) in row.iter().zip(planes) {
                let (near, far) = if element >= 0.0 { (below, above) } else { (above, below) };
                low = low + S::F8::splat(element) * near;
                high = high + S::F8::splat(element) * far;
            }
            lower[k] = S::F8::select(low.lt(lower[k]), low, lower[k]);
            upper[k] = S::F8::select(upper[k].lt(high), high, upper[k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use glam::{Quat, vec3};

    use super::*;
    use crate::geometry::Triangle;
    use crate::scene::transform::Placement;
    use crate::traverse::tests::{Random, soup};
    use crate::{BuildOptions, Bvh};

    /// The box of corners in double precision.
    fn exact(to_scene: &Affine3A, triangles: &[Triangle]) -> Aabb {
        let transform = to_scene.as_daffine3();
        let corners = triangles.iter().flatten().map(|corner| transform.transform_point3(corner.as_dvec3()).as_vec3());
        corners.fold(Aabb::EMPTY, |sum, corner| sum.union(&Aabb { min: corner, max: corner }))
    }

    #[test]
    fn all_corners_are_in_it() {
        let mut random = Random(11);
        for (count, far) in [(1, 0.0), (3, 1.0), (200, 0.0), (500, 1e4), (40, -3e5)] {
            let mut triangles = soup(&mut random, count, 0.5);
            triangles.iter_mut().flatten().for_each(|corner| *corner += Vec3::splat(far));
            let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
            for i in 0..if cfg!(miri) { 3 } else { 200 } {
                let turn = if i % 3 == 0 {
                    Quat::from_rotation_y(i as f32 * core::f32::consts::FRAC_PI_2)
                } else {
                    Quat::from_scaled_axis(random.vector() * 3.0)
                };
                let scale = random.vector() * 10f32.powi(i % 5 - 2);
                let to_scene = Affine3A::from_scale_rotation_translation(scale, turn, random.vector() * far);
                let image = image_of_mesh(&to_scene, &bvh.view());
                let exact = exact(&to_scene, &triangles);
                assert!(image.min.cmple(exact.min).all() && image.max.cmpge(exact.max).all(), "{image:?}, {exact:?}");
            }
        }
        let (nothing, _) = Bvh::build(&[], &BuildOptions::default()).unwrap();
        assert!(image_of_mesh(&Affine3A::IDENTITY, &nothing.view()).is_empty());
    }

    /// A turned ball's image is much smaller than that of its box.
    #[test]
    fn turned_balls_stay_small() {
        let at = |i: usize, j: usize| {
            let (a, b) = (i as f32 * core::f32::consts::TAU / 64.0, j as f32 * core::f32::consts::PI / 32.0);
            vec3(a.cos() * b.sin(), b.cos(), a.sin() * b.sin())
        };
        let patches = (0..64).flat_map(|i| (0..32).map(move |j| (i, j)));
        let ball: Vec<Triangle> = patches.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1)]).collect();
        let (bvh, _) = Bvh::build(&ball, &BuildOptions::default()).unwrap();
        let turn = Affine3A::from_quat(Quat::from_axis_angle(vec3(1.0, 1.0, 0.0).normalize(), 0.9));
        let view = bvh.view();
        let (image, whole) = (image_of_mesh(&turn, &view), Placement::still(&turn).unwrap().aabb(0, &view.bounds()));
        let ratio = image.half_area() / whole.half_area();
        assert!((0.4..0.85).contains(&ratio), "{ratio}");
    }
}
