//! T-junctions: corners that lie in the middle of another triangle's side, as where pieces of a level of different
//! sizes meet.
//!
//! A corner lies on a side if it is as close as the rounding of the side's ends allows. Pieces of a side between such
//! corners end at the corners themselves, so that pieces that lie on one another have ends that are equal bit for bit.

use glam::Vec3;
use rayon::prelude::*;

use crate::scene::key;

/// How far from a side a corner may be, over the greatest coordinate of the side's ends: some units in the last place.
const SLACK: f64 = 8.0 * f32::EPSILON as f64;

/// For each of `sides` the ends of others that lie between its own ends, from its start on: how far from the start, as
/// a part of its length, and the point.
pub(super) fn corners_on(sides: &[[Vec3; 2]]) -> Vec<Vec<(f64, Vec3)>> {
    let mut corners: Vec<Vec3> = sides.iter().flatten().copied().collect();
    corners.sort_unstable_by_key(|corner| key(*corner));
    corners.dedup_by_key(|corner| key(*corner));
    let along = |axis: usize| {
        let mut corners = corners.clone();
        // Stable, so that the order is always the same.
        corners.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
        corners
    };
    let lists = [0, 1, 2].map(along);
    let on = |&[start, end]: &[Vec3; 2]| {
        let slack = SLACK * f64::from(start.abs().max(end.abs()).max_element());
        let (low, high) = (start.min(end).as_dvec3() - slack, start.max(end).as_dvec3() + slack);
        // Those that lie within the side's extent along the axis where they are fewest.
        let within = |axis: usize| {
            let before = |limit: f64| lists[axis].partition_point(|corner| f64::from(corner[axis]) < limit);
            &lists[axis][before(low[axis])..before(high[axis])]
        };
        let near = [1, 2].map(within).into_iter().fold(within(0), |a, b| if b.len() < a.len() { b } else { a });
        let origin = start.as_dvec3();
        let extent = end.as_dvec3() - origin;
        let length = extent.length();
        let place = |corner: &Vec3| {
            let offset = corner.as_dvec3() - origin;
            let distance = offset.dot(extent) / length;
            let is_inside = distance > slack && length - distance > slack;
            let is_on = (offset - extent * (distance / length)).length() <= slack;
            (is_inside && is_on).then_some((distance / length, *corner))
        };
        let mut found: Vec<(f64, Vec3)> = near.iter().filter_map(place).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found
    };
    sides.par_iter().map(on).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    #[test]
    fn corners_are_found_on_sides_and_not_beside_them() {
        // Diagonally through space, far from the origin.
        let (start, extent) = (vec3(100.0, -300.0, 50.0), vec3(3.0, 5.0, -7.0));
        let at = |part: f32| start + extent * part;
        let aside = at(0.5) + vec3(0.01, 0.0, 0.0);
        let sides = [[at(0.0), at(1.0)], [at(0.25), vec3(1.0, 2.0, 3.0)], [aside, at(0.75)], [at(1.0), at(2.0)]];
        let found = corners_on(&sides);
        let places: Vec<f64> = found[0].iter().map(|(place, _)| *place).collect();
        assert_eq!(places.len(), 2, "{places:?}");
        assert!((places[0] - 0.25).abs() < 1e-5 && (places[1] - 0.75).abs() < 1e-5, "{places:?}");
        assert_eq!(found[0][1].1, at(0.75), "the corner itself");
        assert!(found[1..].iter().all(Vec::is_empty), "{found:?}");
    }
}
