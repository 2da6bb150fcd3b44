//! Long emissive triangles, such as those of LED strips and fluorescent tubes, as several lights: slices across their length.
//!
//! A surface close to one gets most light from the part nearby. The light tree finds that part, the
//! [light-sample warp](crate::estimator) of a whole triangle does not, as it knows what comes from the corners alone.

use halfdome_kernel::Triangle;

use super::area;
use super::cells::{Division, TrianglePart};
use super::emitters::EmissiveParts;

/// A slice is at least this multiple of the triangle's width long. Of shorter ones the tree's time is more than they save.
const LENGTH: f32 = 8.0;
/// The most slices of a triangle.
const MOST: u32 = 8;
/// Slices of all triangles, at most.
const OF_ALL: usize = 1 << 15;

/// The most slices for each of so many triangles.
pub(crate) fn most_slices(triangles: usize) -> u32 {
    MOST.min((OF_ALL / triangles.max(1)) as u32)
}

/// The parts of a triangle that emits this radiance everywhere, as luminance; `None` if it is not long.
pub(crate) fn slices(prim_id: u32, triangle: &Triangle, radiance: f32, most: u32) -> Option<EmissiveParts> {
    let edges = [1, 2, 0].map(|from| triangle[(from + 1) % 3].distance(triangle[from]));
    // The corner opposite the shortest edge.
    let corner = (0..3).min_by(|&a, &b| edges[a].total_cmp(&edges[b]))?;
    let length = edges[(corner + 1) % 3].max(edges[(corner + 2) % 3]);
    let width = 2.0 * area(triangle) / length;
    let count = ((length / (LENGTH * width)) as u32).min(most);
    if count < 2 {
        return None;
    }
    let division = Division::Slices { corner: corner as u32, count };
    let parts = division.corners().into_iter().map(|places| (TrianglePart { prim_id, places }, radiance)).collect();
    Some(EmissiveParts { division, parts })
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;

    /// The halves of a strip of a metre.
    fn strip(width: f32) -> [Triangle; 2] {
        let corner = |x: f32, y: f32| Vec3::new(0.3 * x, 5.0 - y, 0.954 * x);
        let [a, b, c, d] = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, width), corner(0.0, width)];
        [[a, b, c], [c, d, a]]
    }

    #[test]
    fn slices_follow_the_length() {
        for turned in 0..3 {
            for mut triangle in strip(0.02) {
                triangle.rotate_left(turned);
                let EmissiveParts { division, parts } = slices(7, &triangle, 3.0, MOST).unwrap();
                assert_eq!((division.count(), parts.len()), (11, 11), "six slices");
                let corners: Vec<Triangle> = parts.iter().map(|(part, _)| part.corners(&triangle)).collect();
                let all: f32 = corners.iter().map(area).sum();
                assert!((all / area(&triangle) - 1.0).abs() < 1e-3, "they cover it");
                for (corners, (part, radiance)) in corners.iter().zip(&parts) {
                    let edges = [0, 1, 2].map(|from| corners[from].distance(corners[(from + 1) % 3]));
                    assert!(edges.iter().all(|edge| *edge < 0.175), "{edges:?}");
                    assert_eq!((part.prim_id, *radiance), (7, 3.0));
                }
            }
        }
    }

    #[test]
    fn only_long_triangles_have_slices_and_very_many_have_none() {
        let [triangle, _] = strip(0.1);
        assert!(slices(0, &triangle, 1.0, MOST).is_none());
        let [triangle, _] = strip(1e-5);
        assert_eq!(slices(0, &triangle, 1.0, MOST).unwrap().division.count(), 2 * MOST - 1);
        assert!(slices(0, &triangle, 1.0, most_slices(30_000)).is_none());
        assert_eq!((most_slices(0), most_slices(OF_ALL / 4)), (MOST, 4));
        // Of no width, and of no size.
        for corners in [[Vec3::ZERO, Vec3::X, 3.0 * Vec3::X], [Vec3::ONE; 3]] {
            let count = slices(0, &corners, 1.0, MOST).map_or(1, |parts| parts.division.count());
            assert!(count < 2 * MOST, "{count}");
        }
    }

    #[test]
    fn points_of_a_strip_are_found_in_their_slices() {
        let [triangle, _] = strip(0.02);
        let EmissiveParts { division, parts } = slices(0, &triangle, 1.0, MOST).unwrap();
        for (number, (part, _)) in (0..).zip(&parts) {
            assert_eq!(division.cell_at(part.place(Vec2::new(0.3, 0.3))), number);
        }
    }
}
