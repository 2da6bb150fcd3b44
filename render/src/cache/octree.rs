//! Finds the spheres that contain a point.
//!
//! A sphere is stored in all cells that its box overlaps, at the depth where half a cell would be narrower than its
//! radius. So a query descends one path and tests the spheres of its cells, four at a time; nothing is locked, as a
//! tree never changes after its build. (Ward, Rubinstein and Clear 1988 keep a sphere in one cell and search up to
//! eight.)

use glam::{Vec3, Vec4};

/// Spheres in a tree of cubes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Octree {
    /// The root first. Empty without spheres.
    nodes: Vec<Node>,
    /// The spheres of one cell after those of another.
    blocks: Vec<Block>,
    center: Vec3,
    /// Half the width of the root.
    half: f32,
}

/// A cell of the tree.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Indices of the cells in its octants; 0, which is the root, for none.
    children: [u32; 8],
    /// Its spheres are in these blocks.
    first: u32,
    end: u32,
}

/// Four spheres of one cell, or fewer: the rest are nowhere.
#[derive(Clone, Copy, Debug)]
struct Block {
    x: Vec4,
    y: Vec4,
    z: Vec4,
    squared_radius: Vec4,
    indices: [u32; 4],
}

/// A sphere, as the tree is built of it.
#[derive(Clone, Copy, Debug)]
struct Entry {
    center: Vec3,
    radius: f32,
    index: u32,
}

/// Deeper cells would be narrower than the spacing of floats.
const MAX_DEPTH: u32 = 22;

impl Octree {
    /// The tree of spheres with finite centres, numbered from 0. Those of radius 0 or less are nowhere.
    pub(crate) fn new(spheres: impl Iterator<Item = (Vec3, f32)>) -> Self {
        let numbered = (0..).zip(spheres).map(|(index, (center, radius))| Entry { center, radius, index });
        let entries: Vec<Entry> = numbered.filter(|entry| entry.radius > 0.0).collect();
        let Some(first) = entries.first() else { return Self::default() };
        let (lower, upper) = entries.iter().fold((first.center, first.center), |(lower, upper), entry| {
            (lower.min(entry.center), upper.max(entry.center))
        });
        let center = lower.midpoint(upper);
        // Wide enough for every point of a sphere that is not itself wider than the box of all centres.
        let half = (upper - lower).max_element().max(f32::MIN_POSITIVE);
        let mut tree = Self { nodes: Vec::new(), blocks: Vec::new(), center, half };
        tree.build(entries, center, half, 0);
        tree
    }

    /// Builds the cell about `center` and all below it; gives its index.
    fn build(&mut self, entries: Vec<Entry>, center: Vec3, half: f32, depth: u32) -> u32 {
        let number = self.nodes.len() as u32;
        // What is not at the root ends inside of its cube.
        let least = if depth == 0 { 0.5 * half } else { half };
        let (below, here): (Vec<_>, Vec<_>) =
            entries.into_iter().partition(|entry| entry.radius < least && depth < MAX_DEPTH);
        let first = self.blocks.len() as u32;
        self.blocks.extend(here.chunks(4).map(Block::new));
        self.nodes.push(Node { children: [0; 8], first, end: self.blocks.len() as u32 });
        if below.is_empty() {
            return number;
        }
        for octant in 0..8 {
            let center = octant_center(center, half, octant);
            let quarter = Vec3::splat(0.5 * half);
            let inside: Vec<_> = below
                .iter()
                .filter(|entry| (entry.center - center).abs().cmple(quarter + entry.radius).all())
                .copied()
                .collect();
            if !inside.is_empty() {
                self.nodes[number as usize].children[octant] = self.build(inside, center, 0.5 * half, depth + 1);
            }
        }
        number
    }

    /// Calls `visit` with the index of each sphere that `point` is inside of, in an order that depends on the spheres
    /// alone.
    #[inline]
    pub(crate) fn query(&self, point: Vec3, mut visit: impl FnMut(usize)) {
        let (mut center, mut half) = (self.center, self.half);
        let mut number = 0;
        let Some(mut node) = self.nodes.first() else { return };
        let outside = (point - center).abs().max_element() > half;
        loop {
            for block in &self.blocks[node.first as usize..node.end as usize] {
                let mut inside = block.inside(point);
                while inside != 0 {
                    visit(block.indices[inside.trailing_zeros() as usize] as usize);
                    inside &= inside - 1;
                }
            }
            let octant = octant_of(center, point);
            let child = node.children[octant];
            // Spheres that do not stay at the root are so small that they end inside of its cube.
            if child == 0 || outside {
                return;
            }
            debug_assert!(child > number);
            number = child;
            node = &self.nodes[number as usize];
            center = octant_center(center, half, octant);
            half *= 0.5;
        }
    }
}

impl Block {
    /// A block of at most four spheres.
    fn new(entries: &[Entry]) -> Self {
        let of =
            |value: fn(&Entry) -> f32| Vec4::from_array(std::array::from_fn(|i| entries.get(i).map_or(0.0, value)));
        Self {
            x: of(|entry| entry.center.x),
            y: of(|entry| entry.center.y),
            z: of(|entry| entry.center.z),
            squared_radius: of(|entry| entry.radius * entry.radius),
            indices: std::array::from_fn(|i| entries.get(i).map_or(0, |entry| entry.index)),
        }
    }

    /// A bit for each sphere that a point is inside of.
    #[inline]
    fn inside(&self, point: Vec3) -> u32 {
        let [x, y, z] = [self.x - point.x, self.y - point.y, self.z - point.z];
        (x * x + y * y + z * z).cmplt(self.squared_radius).bitmask()
    }
}

/// The octant of the cell about `center` that `point` is in: a bit for each axis, x lowest.
#[inline]
fn octant_of(center: Vec3, point: Vec3) -> usize {
    point.cmpge(center).bitmask() as usize
}

/// The middle of an octant.
#[inline]
fn octant_center(center: Vec3, half: f32, octant: usize) -> Vec3 {
    let side = |axis: usize| if octant >> axis & 1 == 1 { 0.5 * half } else { -0.5 * half };
    center + Vec3::new(side(0), side(1), side(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;
    use halfdome_kernel::sampling::Stream;

    fn spheres(count: u32, radius: impl Fn(f32) -> f32) -> Vec<(Vec3, f32)> {
        let sphere = |i| {
            let [x, y, z, r] = Stream::new(5, i, 0).uniform4(0);
            (vec3(x * 4.0, y - 7.0, z * 0.1), radius(r))
        };
        (0..count).map(sphere).collect()
    }

    fn assert_like_brute_force(spheres: &[(Vec3, f32)]) {
        let tree = Octree::new(spheres.iter().copied());
        let mut hits = 0;
        for i in 0..2000 {
            let [x, y, z, _] = Stream::new(6, i, 0).uniform4(0);
            let point = vec3(x * 6.0 - 1.0, y * 3.0 - 8.0, z * 2.0 - 1.0);
            // Some points are centres.
            let point = if i % 4 == 0 { spheres[i as usize % spheres.len()].0 } else { point };
            let expected: Vec<_> =
                (0..spheres.len()).filter(|&i| spheres[i].0.distance_squared(point) < spheres[i].1.powi(2)).collect();
            let mut found = Vec::new();
            tree.query(point, |index| found.push(index));
            found.sort_unstable();
            assert_eq!(found, expected, "{point}");
            hits += found.len();
        }
        assert!(hits > 400, "{hits}");
    }

    #[test]
    fn queries_find_what_a_search_through_all_finds() {
        assert_like_brute_force(&spheres(500, |r| 0.5 * r));
        assert_like_brute_force(&spheres(500, |r| 3.0 * r * r * r * r));
        assert_like_brute_force(&spheres(300, |r| 1e-5 + 1e-4 * r));
        assert_like_brute_force(&spheres(1, |_| 2.0));
        let stacked: Vec<_> = (0..100).map(|i| (Vec3::ONE, 0.01 * i as f32)).collect();
        assert_like_brute_force(&stacked);
    }

    #[test]
    fn nothing_is_found_among_nothing() {
        for spheres in [vec![], vec![(Vec3::ZERO, 0.0), (Vec3::X, -1.0)]] {
            Octree::new(spheres.into_iter()).query(Vec3::ZERO, |_| panic!("there is no sphere"));
        }
    }

    /// The order of a query's sum must not depend on the point.
    #[test]
    fn a_query_keeps_the_order_of_the_spheres_of_a_cell() {
        let tree = Octree::new((0..50).map(|i| (vec3(0.001 * i as f32, 0.0, 0.0), 1.0)));
        let mut found = Vec::new();
        tree.query(Vec3::ZERO, |index| found.push(index));
        assert_eq!(found, (0..50).collect::<Vec<_>>());
    }
}
