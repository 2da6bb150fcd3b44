//! The occluders around a point: for each sector of azimuth, the distance along the surface to the nearest one.
//!
//! Radiance keeps 32 directions of nearby occluders with a record of its ambient cache, to know where the record's
//! light may not reach. Here a gather's own flat rays tell: an occluder is what they hit under less than 30 degrees
//! above the surface and what rises more steeply than a bowl would that the point lies in, whose slope at an elevation
//! of e is 2 e. As rays do not hit everything, an occluder counts as a plane that goes on through its sector and those
//! beside it, and a sector without a flat ray has the occluders of these.
//!
//! A surface that overhangs, facing the record's surface, is not an occluder, but the light below it differs: a
//! harmonic mean distance hardly changes before such a gap, and a record that reached into the gap would light it. A
//! point under a large plane at height h has a mean distance of 3/2 h, so that as its neighbour (Křivánek et al. 2006,
//! "neighbour clamping") a point at distance s from there has one of s + 3/2 h at most.

use glam::{Vec2, Vec3, Vec3Swizzles as _, vec2};

/// Sectors of azimuth, from the first tangent of the frame about the normal.
pub const SECTORS: usize = 16;

/// Sine of 30 degrees.
const MAX_SINE: f32 = 0.5;
/// Cosine and sine of 8 degrees, by which an occluder is steeper than a bowl.
const STEEPER: Vec2 = vec2(0.990_268_1, 0.139_173_1);
/// Cosine of the angle from the normal from which on a surface hangs over.
const OVERHANG: f32 = -0.5;
/// Cosines of the borders between sectors, from the first tangent to the second.
const BORDERS: [f32; 5] = [1.0, 0.923_879_5, 0.707_106_77, 0.382_683_43, 0.0];
/// The sectors on both sides of each, as they are numbered within quadrants.
const NEIGHBOURS: [[usize; 2]; SECTORS] = {
    const TURN: [usize; SECTORS] = [0, 1, 2, 3, 7, 6, 5, 4, 12, 13, 14, 15, 11, 10, 9, 8];
    let mut beside = [[0; 2]; SECTORS];
    let mut place = 0;
    while place < SECTORS {
        beside[TURN[place]] = [TURN[(place + SECTORS - 1) % SECTORS], TURN[(place + 1) % SECTORS]];
        place += 1;
    }
    beside
};

/// The occluders; all infinite where there are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OccluderSectors {
    /// The nearest occluder of each sector.
    occluders: [f32; SECTORS],
    /// The most that the mean distance may be, by what hangs over.
    pub(crate) clearance: f32,
    /// Whether a flat ray went that way.
    seen: [bool; SECTORS],
}

impl OccluderSectors {
    /// No occluders, nothing seen.
    pub(crate) const OPEN: Self =
        Self { occluders: [f32::INFINITY; SECTORS], clearance: f32::INFINITY, seen: [false; SECTORS] };

    /// Whether a ray in this local direction, z up, is used.
    pub(crate) fn is_flat(direction: Vec3) -> bool {
        direction.z < MAX_SINE
    }

    /// Takes note of a flat ray.
    pub(crate) fn mark_seen(&mut self, direction: Vec3) {
        self.seen[sector(direction.xy())] = true;
    }

    /// Adds the hit of a flat ray at a distance, with this unit normal, on the side that was hit. All vectors are
    /// local.
    pub(crate) fn add_hit(&mut self, direction: Vec3, distance: f32, normal: Vec3) {
        let along = distance * direction.xy().length();
        let (sin, cos) = (direction.z, (1.0 - direction.z * direction.z).max(0.0).sqrt());
        let bowl = STEEPER.x * (1.0 - 2.0 * sin * sin) - STEEPER.y * 2.0 * sin * cos;
        if normal.z >= bowl {
            return;
        }
        let number = sector(direction.xy());
        if normal.z <= OVERHANG {
            self.clearance = self.clearance.min(along + 1.5 * distance * sin);
        } else {
            self.occluders[number] = self.occluders[number].min(along);
        }
        // What hangs over at a slant comes down somewhere.
        if normal.xy().length() > STEEPER.y {
            let depth = -distance * normal.dot(direction);
            for number in [number, NEIGHBOURS[number][0], NEIGHBOURS[number][1]] {
                self.occluders[number] = self.occluders[number].min(nearest_of_plane(number, -normal.xy(), depth));
            }
        }
    }

    /// The occluders, also of sectors without a ray.
    pub(crate) fn occluders(&self) -> [f32; SECTORS] {
        std::array::from_fn(|number| match self.seen[number] {
            true => self.occluders[number],
            false => NEIGHBOURS[number]
                .iter()
                .fold(self.occluders[number], |least, &beside| least.min(self.occluders[beside])),
        })
    }
}

/// The least distance of a plane in a sector, along the surface: it is `depth` away, and its normal points away from
/// `towards`.
fn nearest_of_plane(number: usize, towards: Vec2, depth: f32) -> f32 {
    let [first, second] = borders(number);
    // Where its normal points from, if that is within the sector, or else at one of the borders.
    let within = first.perp_dot(towards) * towards.perp_dot(second) >= 0.0 && first.dot(towards) > 0.0;
    let slope = if within { towards.length() } else { first.dot(towards).max(second.dot(towards)) };
    if slope > 0.0 && depth >= 0.0 { depth / slope } else { f32::INFINITY }
}

/// Unit vectors along the borders of a sector.
fn borders(number: usize) -> [Vec2; 2] {
    let (quadrant, first) = (number / 4, number % 4);
    let sign = |bit: usize| if quadrant & bit == 0 { 1.0 } else { -1.0 };
    [first, first + 1].map(|border| vec2(BORDERS[border] * sign(1), BORDERS[4 - border] * sign(2)))
}

/// The sector that a vector in the tangent plane points to.
#[inline]
pub(crate) fn sector(local: Vec2) -> usize {
    const { assert!(SECTORS == 16) };
    // Tangents of 22.5, 45 and 67.5 degrees.
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

    /// The normal of a wall that a direction meets under a right angle.
    fn wall(towards: Vec2) -> Vec3 {
        -towards.normalize().extend(0.0)
    }

    #[test]
    fn the_nearest_wall_of_a_sector_counts_and_floors_do_not() {
        let mut occluders = OccluderSectors::OPEN;
        let towards = Vec2::from_angle(0.2);
        let direction = towards.extend(0.3).normalize();
        for (distance, normal) in [(2.0, wall(towards)), (1.0, wall(towards)), (3.0, wall(towards)), (0.1, Vec3::Z)] {
            occluders.add_hit(direction, distance, normal);
        }
        let expected = direction.xy().length();
        assert!((occluders.occluders[sector(towards)] / expected - 1.0).abs() < 1e-6);
        assert_eq!(occluders.occluders.iter().filter(|distance| distance.is_finite()).count(), 3);
        assert!(OccluderSectors::is_flat(direction) && !OccluderSectors::is_flat(Vec3::Z));
        assert_eq!(occluders.clearance, f32::INFINITY);
    }

    /// Whatever a plane's slope and wherever a ray meets it: no point of its foot in the sector is nearer than the occluder,
    /// and some point there, or the hit itself, is as near.
    #[test]
    fn a_plane_goes_on_through_its_sector() {
        for i in 0..500 {
            let random = |k: i32| (0.618_034 * (7 * i + k) as f32).fract();
            let towards = Vec2::from_angle(std::f32::consts::TAU * random(1));
            let normal = (wall(towards) + Vec3::Z * (0.8 * random(2))).normalize();
            let direction =
                Vec2::from_angle(towards.to_angle() + 2.4 * (random(3) - 0.5)).extend(0.4 * random(4)).normalize();
            // The foot of the plane is 1.5 away.
            let distance = 1.5 * normal.xy().length() / -normal.dot(direction);
            if distance <= 0.0 || normal.z >= 0.6 {
                continue;
            }
            let mut occluders = OccluderSectors::OPEN;
            occluders.add_hit(direction, distance, normal);
            for turn in [-1.0, 0.0, 1.0] {
                let number = sector(direction.xy().rotate(Vec2::from_angle(turn * std::f32::consts::TAU / 16.0)));
                let feet = (0..20_000).map(|k| Vec2::from_angle(std::f32::consts::TAU * k as f32 / 20_000.0));
                let feet = feet.filter(|&foot| sector(foot) == number && foot.dot(towards) > 0.0);
                let nearest = feet.map(|foot| 1.5 / foot.dot(towards)).fold(f32::INFINITY, f32::min);
                let hit = if turn == 0.0 { distance * direction.xy().length() } else { f32::INFINITY };
                let (found, expected) = (occluders.occluders[number], nearest.min(hit));
                // Reciprocals are as exact as the steps are narrow, also nearly parallel to the plane.
                let close = (1.0 / found - 1.0 / expected).abs() < 5e-4;
                assert!(close, "{i}, {turn}: {found} {expected}");
            }
        }
    }

    /// Spheres seen from inside are no occluders to themselves; tents of more than 20 degrees are.
    #[test]
    fn bowls_are_no_obstacles_and_slopes_are() {
        for degrees in [1.0f32, 10.0, 20.0, 29.0] {
            let elevation = degrees.to_radians();
            let direction = vec3(elevation.cos(), 0.0, elevation.sin());
            let mut occluders = OccluderSectors::OPEN;
            occluders.add_hit(direction, 1.0, vec3(-(2.0 * elevation).sin(), 0.0, (2.0 * elevation).cos()));
            assert_eq!(occluders, OccluderSectors::OPEN, "{degrees}");
        }
        for degrees in [20.0f32, 45.0, 80.0] {
            let slope = degrees.to_radians();
            let mut occluders = OccluderSectors::OPEN;
            occluders.add_hit(Vec3::X, 2.0, vec3(-slope.sin(), 0.0, slope.cos()));
            assert!((occluders.occluders[sector(Vec2::X)] - 2.0).abs() < 1e-5, "{degrees}");
        }
    }

    #[test]
    fn sectors_that_nobody_saw_are_like_their_neighbours() {
        let mut occluders = OccluderSectors::OPEN;
        let at = |number: usize| Vec2::from_angle(std::f32::consts::TAU * (number as f32 + 0.5) / 16.0);
        // Nobody looks into three sectors; there is a wall in a fourth, which reaches into those beside it.
        for number in (0..16).filter(|number| ![3, 11, 12].contains(number)) {
            occluders.mark_seen(at(number).extend(0.1));
        }
        occluders.add_hit(at(5).extend(0.0), 1.0, wall(at(5)));
        let occluders = occluders.occluders();
        let of = |number: usize| occluders[sector(at(number))];
        assert!((of(5) - 1.0).abs() < 1e-6 && of(4) > 1.0 && of(4) == of(6) && of(3) == of(4));
        assert!([2, 7, 11, 12].map(of).iter().all(|distance| distance.is_infinite()));
    }

    #[test]
    fn what_hangs_over_bounds_the_mean_distance() {
        let mut occluders = OccluderSectors::OPEN;
        // A board 0.5 above, from 1.2 on.
        occluders.add_hit(vec3(12.0, 0.0, 5.0) / 13.0, 1.3, Vec3::NEG_Z);
        occluders.add_hit(vec3(0.0, 24.0, 10.0) / 26.0, 2.6, Vec3::NEG_Z);
        assert!((occluders.clearance - (1.2 + 1.5 * 0.5)).abs() < 1e-6, "{}", occluders.clearance);
        assert_eq!(occluders.occluders, OccluderSectors::OPEN.occluders);
        // A roof of 45 degrees 0.5 above that comes down at 1.7.
        occluders.add_hit(vec3(12.0, 0.0, 5.0) / 13.0, 1.3, vec3(-1.0, 0.0, -1.0).normalize());
        assert!((occluders.occluders[sector(Vec2::X)] - 1.7).abs() < 1e-5, "{:?}", occluders.occluders);
    }
}
