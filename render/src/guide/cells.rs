//! The cells of a guide: six binary trees over space, one for each side that surfaces face.

use std::collections::VecDeque;

use glam::Vec3;
use rayon::prelude::*;

use super::directions::{DirectionTrees, weighted};
use super::fraction::best_fraction;
use super::{GuideCell, GuideSample};

/// Bounces from which on a cell is cut in half.
const CUT_COUNT: usize = 512;
/// Bounces without which nothing is guided.
const MIN_COUNT: usize = 32;
/// A cell is cut so often at most.
const MAX_DEPTH: u32 = 40;

/// The axis that a normal is closest to, times two, plus one if it points against it.
pub(super) fn side(normal: Vec3) -> u8 {
    let size = normal.abs();
    let axis = match () {
        () if size.x >= size.y && size.x >= size.z => 0,
        () if size.y >= size.z => 1,
        () => 2,
    };
    2 * axis as u8 + u8::from(normal[axis] < 0.0)
}

#[derive(Debug)]
pub(super) struct Cells {
    nodes: Vec<Node>,
    cells: Vec<GuideCell>,
}

/// Half-spaces below and above a plane, or a cell.
#[derive(Clone, Copy, Debug)]
struct Node {
    at: f32,
    /// 3 for a cell.
    axis: u32,
    /// The nodes below and above, of which the second comes after the first; or the cell's index.
    first: u32,
}

const CELL: u32 = 3;

impl Cells {
    /// The cells for bounces that found light. The roots are the first six nodes.
    pub(super) fn build(samples: Vec<GuideSample>) -> (Self, DirectionTrees) {
        let mut sides: [Vec<GuideSample>; 6] = Default::default();
        for sample in samples {
            sides[usize::from(side(sample.normal))].push(sample);
        }
        let empty = Node { at: 0.0, axis: CELL, first: 0 };
        let (mut nodes, mut leaves) = (vec![empty; 6], Vec::new());
        let mut open: VecDeque<_> = sides.into_iter().enumerate().map(|(root, samples)| (root, samples, 0)).collect();
        // In the order of their indices.
        while let Some((number, samples, depth)) = open.pop_front() {
            let cut = (samples.len() >= CUT_COUNT && depth < MAX_DEPTH).then(|| middle(&samples)).flatten();
            let Some((axis, at)) = cut else {
                nodes[number].first = leaves.len() as u32;
                leaves.push(samples);
                continue;
            };
            let (below, above): (Vec<_>, Vec<_>) = samples.into_iter().partition(|s| s.position[axis] < at);
            let first = nodes.len();
            nodes[number] = Node { at, axis: axis as u32, first: first as u32 };
            nodes.extend([empty; 2]);
            open.push_back((first, below, depth + 1));
            open.push_back((first + 1, above, depth + 1));
        }
        let learned: Vec<_> = leaves.into_par_iter().map(cell).collect();
        let mut directions = DirectionTrees::default();
        let place = |(cell, trees): (GuideCell, DirectionTrees)| {
            let offset = directions.append(trees);
            GuideCell { tree: cell.tree + offset, ..cell }
        };
        let cells = learned.into_iter().map(place).collect();
        (Self { nodes, cells }, directions)
    }

    pub(super) fn find(&self, position: Vec3, normal: Vec3) -> GuideCell {
        self.cells[find(&self.nodes, side(normal), position)]
    }

    pub(super) fn guides_any(&self) -> bool {
        self.cells.iter().any(|cell| cell.fraction > 0.0)
    }
}

/// The index of the cell at this position.
fn find(nodes: &[Node], side: u8, position: Vec3) -> usize {
    let mut node = nodes[usize::from(side)];
    while node.axis != CELL {
        let is_above = position[node.axis as usize] >= node.at;
        node = nodes[node.first as usize + usize::from(is_above)];
    }
    node.first as usize
}

/// The box around these.
fn extent(samples: &[GuideSample]) -> (Vec3, Vec3) {
    samples.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), sample| {
        (low.min(sample.position), high.max(sample.position))
    })
}

/// A plane through the middle of the longest side of the box around these; `None` if they are all at one place.
fn middle(samples: &[GuideSample]) -> Option<(usize, f32)> {
    let (low, high) = extent(samples);
    let extent = high - low;
    let axis = match () {
        () if extent.x >= extent.y && extent.x >= extent.z => 0,
        () if extent.y >= extent.z => 1,
        () => 2,
    };
    let at = 0.5 * (low[axis] + high[axis]);
    (low[axis] < at && at <= high[axis]).then_some((axis, at))
}

/// The cell with these bounces, and its tree of directions.
fn cell(samples: Vec<GuideSample>) -> (GuideCell, DirectionTrees) {
    let mut directions = DirectionTrees::default();
    let Some(first) = samples.first().filter(|_| samples.len() >= MIN_COUNT) else {
        return (GuideCell::NONE, directions);
    };
    let side = side(first.normal);
    let fraction = best_fraction(&samples, side);
    if fraction == 0.0 {
        return (GuideCell::NONE, directions);
    }
    let tree = directions.add(&mut weighted(&samples, side));
    (GuideCell { fraction, tree, side }, directions)
}
