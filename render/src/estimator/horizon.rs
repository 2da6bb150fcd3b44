//! What stands around a point: for each sector of azimuth, how far away along the surface the nearest obstacle is.
//!
//! Radiance keeps 32 directions of nearby occluders with a record of its ambient cache, to know where light that the
//! record has seen may not reach. Here a gather's own flat rays tell: an obstacle is what they hit under less than 30
//! degrees above the surface and what faces another way than the surface does, which a bowl's own slope does not.
//!
//! What hangs over the surface, facing it, is no obstacle, but under it is another world: a harmonic mean distance hardly
//! notices a gap from outside of it, and a record that reached in would light it. A point under a large plane at height h
//! has a mean distance of 3/2 h, so that as its neighbour (Křivánek et al. 2006, "neighbour clamping") a point at distance
//! s from there has one of s + 3/2 h at most.

use glam::{Vec2, Vec3};

/// Sectors of azimuth, from the first tangent of the frame about the normal.
pub const SECTORS: usize = 16;

/// Sine of 30 degrees.
const FLAT: f32 = 0.5;
/// Cosine of the angle from which on a surface faces another way.
const FACING: f32 = 0.5;

/// What stands around; all infinite where nothing does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Horizon {
    /// The nearest obstacle of each sector.
    pub(crate) obstacles: [f32; SECTORS],
    /// The most that the mean distance may be, by what hangs over.
    pub(crate) clearance: f32,
}

impl Horizon {
    /// No obstacles.
    pub(crate) const OPEN: Self = Self { obstacles: [f32::INFINITY; SECTORS], clearance: f32::INFINITY };

    /// Whether a ray in this local direction, z up, could find something.
    pub(crate) fn is_flat(direction: Vec3) -> bool {
        direction.z < FLAT
    }

    /// Takes note of what a flat ray hit at a distance, `facing` being the cosine between the normals here and there, on
    /// the side that was hit.
    pub(crate) fn add(&mut self, direction: Vec3, distance: f32, facing: f32) {
        let along = distance * direction.truncate().length();
        if facing.abs() < FACING {
            let nearest = &mut self.obstacles[sector(direction.truncate())];
            *nearest = nearest.min(along);
        } else if facing < 0.0 {
            self.clearance = self.clearance.min(along + 1.5 * distance * direction.z);
        }
    }
}

/// The sector that a vector in the tangent plane points to.
#[inline]
pub(crate) fn sector(local: Vec2) -> usize {
    const { assert!(SECTORS == 16) };
    // Of 22.5, 45 and 67.5 degrees.
    const TANGENTS: [f32; 3] = [0.414_213_57, 1.0, 2.414_213_7];
    let (x, y) = (local.x.abs(), local.y.abs());
    let within_quadrant = TANGENTS.iter().filter(|&&tangent| y >= tangent * x).count();
    let quadrant = usize::from(local.x < 0.0) + 2 * usize::from(local.y < 0.0);
    4 * quadrant + within_quadrant
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    #[test]
    fn sectors_are_equal_and_all_there() {
        let mut counts = [0; SECTORS];
        for i in 0..1600 {
            let angle = std::f32::consts::TAU * (i as f32 + 0.5) / 1600.0;
            counts[sector(Vec2::from_angle(angle))] += 1;
        }
        assert_eq!(counts, [100; SECTORS]);
    }

    #[test]
    fn the_nearest_wall_of_a_sector_counts_and_floors_do_not() {
        let mut horizon = Horizon::OPEN;
        let direction = vec3(0.8, 0.1, 0.4);
        horizon.add(direction, 2.0, 0.0);
        horizon.add(direction, 1.0, 0.0);
        horizon.add(direction, 3.0, 0.3);
        horizon.add(direction, 0.1, 0.9);
        let expected = Vec2::new(0.8, 0.1).length();
        assert_eq!(horizon.obstacles[sector(Vec2::new(0.8, 0.1))], expected);
        assert_eq!(horizon.obstacles.iter().filter(|distance| distance.is_finite()).count(), 1);
        assert!(Horizon::is_flat(direction) && !Horizon::is_flat(Vec3::Z));
        assert_eq!(horizon.clearance, f32::INFINITY);
    }
    #[test]
    fn what_hangs_over_bounds_the_mean_distance() {
        let mut horizon = Horizon::OPEN;
        // A board 0.5 above, from 1.2 on.
        horizon.add(vec3(12.0, 0.0, 5.0) / 13.0, 1.3, -1.0);
        horizon.add(vec3(0.0, 24.0, 10.0) / 26.0, 2.6, -0.9);
        assert!((horizon.clearance - (1.2 + 1.5 * 0.5)).abs() < 1e-6, "{}", horizon.clearance);
        assert_eq!(horizon.obstacles, Horizon::OPEN.obstacles);
    }
}
