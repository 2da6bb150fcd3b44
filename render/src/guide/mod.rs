//! Path guiding: directions for bounces, learned from paths that were traced before.
//!
//! BSDF sampling does not know where light comes from. In a room that is lit through a narrow opening, few samples find
//! the opening. Practical path guiding (Müller, Gross and Novák 2017) learns `f L cos θ` over the scene, and mixes its
//! directions with those of the closure: the density is `p = a p_guide + (1 - a) p_closure`, for bounces and for
//! multiple importance sampling alike, so that there is no bias.
//!
//! Space is cut into [cells](cells), by the side that a surface faces and then by halves, each with about as many
//! bounces that found light; a cell has a [quadtree of directions](directions).
//!
//! Deviations from the paper: paths to learn from are traced before the picture, in rounds of fixed size, so that the
//! picture does not depend on how its samples are split up. The learned distribution includes the cosine, as a cell's
//! surfaces face one side. The [fraction](fraction) `a` is each cell's own, chosen by cross-validation: the one whose
//! density has the least Kullback-Leibler divergence from what bounces find; 0 where guiding does not help. It applies
//! to the diffuse part of a closure alone, so that mirrors and gloss keep their own samples.

mod cells;
mod directions;
mod fraction;

use glam::{Vec2, Vec3};

use directions::{DirectionTrees, to_square};

/// A bounce of a path, and what it found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GuideSample {
    /// Where it left a surface, and that surface's unit normal.
    pub position: Vec3,
    pub normal: Vec3,
    /// Unit vector.
    pub direction: Vec3,
    /// All that the path found from there on, by its throughput before: estimates the integral of `f L cos θ`.
    pub light: f32,
    /// The density per solid angle with which the closure alone gives this direction; infinite for a delta function.
    pub closure_density: f32,
    /// The part of the guide's fraction that counts for the closure.
    pub share: f32,
}

/// The learned distribution.
#[derive(Debug)]
pub(crate) struct Guide {
    cells: cells::Cells,
    directions: DirectionTrees,
}

/// The part of a guide that counts at a place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GuideCell {
    /// The fraction of bounces that are guided there; 0 if there are none.
    pub fraction: f32,
    tree: u32,
    side: u8,
}

impl GuideCell {
    /// A place without guiding.
    pub(crate) const NONE: Self = Self { fraction: 0.0, tree: 0, side: 0 };

    /// The same for a closure to which a part of the fraction applies.
    pub(crate) fn for_share(self, share: f32) -> Self {
        Self { fraction: self.fraction * share, ..self }
    }
}

impl Guide {
    /// Learns from bounces that found light, in their order; `None` if guiding helps nowhere.
    pub(crate) fn learn(samples: Vec<GuideSample>) -> Option<Self> {
        let (cells, directions) = cells::Cells::build(samples);
        cells.guides_any().then_some(Self { cells, directions })
    }

    /// The cell at a place of a surface with this unit normal.
    pub(crate) fn cell(&self, position: Vec3, normal: Vec3) -> GuideCell {
        self.cells.find(position, normal)
    }

    /// The density per solid angle with which [`sample`](Self::sample) gives this unit vector, in a cell that guides.
    pub(crate) fn density(&self, cell: &GuideCell, direction: Vec3) -> f32 {
        let (place, per_angle) = to_square(direction, cell.side);
        self.directions.density(cell.tree, place) * per_angle
    }

    /// A direction by numbers in [0, 1), in a cell that guides.
    pub(crate) fn sample(&self, cell: &GuideCell, u: Vec2) -> Vec3 {
        directions::from_square(self.directions.sample(cell.tree, u), cell.side)
    }
}

#[cfg(test)]
mod tests;
