//! Finds the least `radius + slope * distance` over many points, for each of them: the lower envelope of cones.
//!
//! The points lie along a space-filling curve, so that eight neighbours in their order are near each other, as are
//! eight such groups, and so on: a tree without pointers. A group is skipped by its least radius and the distance of
//! its box; few groups remain where radii do not grow faster than the cones.

use glam::Vec3;

/// Points, or groups, in a group.
const WIDTH: usize = 8;

/// Points with radii.
pub(super) struct Cones {
    points: Vec<(Vec3, f32)>,
    /// Groups of points, groups of those, up to one alone.
    levels: Vec<Vec<Group>>,
}

/// The bounds of a group of points.
#[derive(Clone, Copy)]
struct Group {
    lower: Vec3,
    upper: Vec3,
    least_radius: f32,
}

impl Group {
    fn of(points: &[(Vec3, f32)]) -> Self {
        let all = points.iter().map(|&(point, radius)| Self { lower: point, upper: point, least_radius: radius });
        all.reduce(Self::join).unwrap_or(Self { lower: Vec3::ZERO, upper: Vec3::ZERO, least_radius: f32::INFINITY })
    }

    fn join(self, other: Self) -> Self {
        Self {
            lower: self.lower.min(other.lower),
            upper: self.upper.max(other.upper),
            least_radius: self.least_radius.min(other.least_radius),
        }
    }

    /// No cone of the group is lower than this.
    fn bound(&self, point: Vec3, slope: f32) -> f32 {
        // A little less, for what rounding does.
        self.least_radius + 0.999_999 * slope * point.distance(point.clamp(self.lower, self.upper))
    }
}

impl Cones {
    /// The tree of points along a curve, with finite positions.
    pub(super) fn new(points: Vec<(Vec3, f32)>) -> Self {
        let mut levels: Vec<Vec<Group>> = vec![points.chunks(WIDTH).map(Group::of).collect()];
        while let Some(last) = levels.last().filter(|last| last.len() > 1) {
            let next = last.chunks(WIDTH).filter_map(|groups| groups.iter().copied().reduce(Group::join)).collect();
            levels.push(next);
        }
        Self { points, levels }
    }

    /// The least of `radius + slope * distance` of all points and `most`.
    pub(super) fn least(&self, point: Vec3, slope: f32, most: f32) -> f32 {
        let top = self.levels.len() - 1;
        self.search(top, 0..self.levels[top].len(), point, slope, most)
    }

    fn search(&self, level: usize, groups: std::ops::Range<usize>, point: Vec3, slope: f32, most: f32) -> f32 {
        groups.fold(most, |least, number| {
            if self.levels[level][number].bound(point, slope) >= least {
                return least;
            }
            let below = |len: usize| number * WIDTH..((number + 1) * WIDTH).min(len);
            match level.checked_sub(1) {
                Some(level) => self.search(level, below(self.levels[level].len()), point, slope, least),
                None => self.points[below(self.points.len())]
                    .iter()
                    .fold(least, |least, (other, radius)| least.min(radius + slope * point.distance(*other))),
            }
        })
    }
}
