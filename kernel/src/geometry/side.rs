//! From which side a ray meets a triangle.

use super::{Ray, Triangle, intersect_side, triangle_normal};

/// The surface at a hit: normal and side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// The unit normal of the side that the ray has hit; zero if the triangle's area vanishes.
    pub normal: glam::Vec3,
    /// Whether that is the front, from which the corners run counter-clockwise.
    pub is_front: bool,
}

impl Surface {
    /// The side of `triangle` that `ray` meets, and its geometric normal; `None` if it does not hit it.
    /// [`Facing`](crate::Facing) uses the same side: it is exact, however the ray grazes the triangle.
    pub fn of(ray: &Ray, triangle: &Triangle) -> Option<Self> {
        let (_, is_front) = intersect_side(ray, triangle)?;
        let front = triangle_normal(triangle);
        Some(Self { normal: if is_front { front } else { -front }, is_front })
    }
}

// Miri would take hours.
#[cfg(all(test, not(miri)))]
mod tests {
    use super::*;
    use crate::traverse::tests::{Random, rays_at, soup};
    use crate::{BuildOptions, Bvh, Facing};

    #[test]
    fn the_side_is_that_of_searches_by_side() {
        let mut random = Random(82);
        let triangles = soup(&mut random, 100, 0.5);
        let (tree, _) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
        let mut sides = [0, 0];
        for ray in rays_at(&triangles, &mut random, 60) {
            for (facing, is_front) in [(Facing::Front, true), (Facing::Back, false)] {
                let Some(hit) = tree.view().intersect_facing(&ray, facing) else { continue };
                let surface = Surface::of(&ray, &triangles[hit.prim_id as usize]).unwrap();
                assert_eq!(surface.is_front, is_front);
                // Towards where the ray comes from, but for a grazing ray's rounding.
                assert!(surface.normal.dot(ray.direction) <= 1e-5 * ray.direction.length(), "{ray:?}");
                sides[usize::from(is_front)] += 1;
            }
        }
        assert!(sides[0] > 100 && sides[1] > 100, "{sides:?}");
        let ray = Ray::new(glam::Vec3::ONE * 9.0, glam::Vec3::X);
        assert_eq!(Surface::of(&ray, &triangles[0]), None);
    }
}
