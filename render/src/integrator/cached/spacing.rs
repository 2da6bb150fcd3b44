//! The spacing of given points.
//!
//! The requested points may fill a small part of a wide scene, such as a room on a plain. The least distance of records
//! then cannot follow from the scene's extent; but no two need to be closer than the points are.

use glam::Vec3;

use crate::cache::sort_by_morton_code;

/// Points before and after one in their order that are looked at.
const WINDOW: usize = 8;

/// The distance of each point, with its unit normal, from the nearest others that face alike: the one of this number, from
/// 1, or the last there is; infinite if there is none. Points at the same place count as one. It is found among neighbours
/// along a space-filling curve, and so may be somewhat too large.
pub(super) fn spacings(points: &[(Vec3, Vec3)], number: usize) -> Vec<f32> {
    let mut spacings = vec![f32::INFINITY; points.len()];
    for facing in 0..6 {
        let mut order: Vec<usize> = (0..points.len()).filter(|&i| side(points[i].1) == facing).collect();
        sort_by_morton_code(&mut order, |&i| points[i].0, |&i| i);
        for (place, &i) in order.iter().enumerate() {
            let around = place.saturating_sub(WINDOW)..(place + WINDOW + 1).min(order.len());
            let distances = order[around].iter().map(|&j| points[i].0.distance(points[j].0));
            let mut distances: Vec<f32> = distances.filter(|&distance| distance > 0.0).collect();
            distances.sort_unstable_by(f32::total_cmp);
            spacings[i] = distances.get(number - 1).or(distances.last()).copied().unwrap_or(f32::INFINITY);
        }
    }
    spacings
}

/// Which of six ways a normal points most.
fn side(normal: Vec3) -> usize {
    let axis = normal.abs().max_position();
    2 * axis + usize::from(normal[axis] < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    #[test]
    fn grids_have_their_step_and_lonely_points_none() {
        let mut points: Vec<(Vec3, Vec3)> =
            (0..900).map(|i| (vec3((i % 30) as f32, 0.0, (i / 30) as f32) * 0.1, Vec3::Y)).collect();
        // Another side of the same places, a point far away, twice, and one that faces another way.
        let below: Vec<(Vec3, Vec3)> = points.iter().step_by(2).map(|&(point, _)| (point, Vec3::NEG_Y)).collect();
        points.extend(below);
        points.extend([(vec3(50.0, 0.0, 0.0), Vec3::Y); 2]);
        points.push((Vec3::ZERO, Vec3::X));
        let found = spacings(&points, 1);
        let near = |value: f32, expected: f32| (value / expected - 1.0).abs() < 1e-3;
        let near_step = found[..900].iter().filter(|&&spacing| near(spacing, 0.1)).count();
        assert!(near_step > 890, "{near_step}");
        assert!(found[..900].iter().all(|&spacing| (0.099..0.3).contains(&spacing)));
        assert!(found[900..1350].iter().all(|&spacing| (0.099..0.5).contains(&spacing)));
        assert!(near(found[1350], 50.0 - 2.9) || found[1350] > 40.0);
        assert_eq!(found[1352], f32::INFINITY);
        // The second of three.
        let line = [0.0, 1.0, 3.0].map(|x| (vec3(x, 0.0, 0.0), Vec3::Z));
        assert_eq!(spacings(&line, 1), [1.0, 1.0, 2.0]);
        assert_eq!(spacings(&line, 4), [3.0, 2.0, 3.0]);
    }
}
