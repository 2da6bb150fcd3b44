//! Distributions of directions: quadtrees over a square that stands for the sphere.
//!
//! A square's first coordinate is the cosine with the axis that surfaces of the cell face, so that it keeps areas; the
//! second is the angle about that axis, by `y / (|x| + |y|)` in each quadrant: no trigonometry, and a density that
//! differs from an even one by a factor of two at most.

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::ONE_MINUS_EPSILON;

use super::GuideSample;

/// The part of a tree's light from which on a square is cut into four.
const CUT_FROM: f32 = 0.01;
/// Bounces that a square must have to be cut.
const CUT_COUNT: usize = 4;
/// A square is cut so often at most.
const MAX_DEPTH: u32 = 10;

/// A bounce is spread over an area of up to this part of its square's side.
const BLUR: f32 = 1.0;
/// The part of a square that each quarter of it has at least.
const MIN_PART: f32 = 0.01;

/// A bounce: the position of its direction in the square, and the light that it found.
pub(super) type Weighted = (Vec2, f32);

/// What of bounces a tree of directions is made from. Delta functions cannot be guided, and gloss is not.
pub(super) fn weighted<'a>(samples: impl IntoIterator<Item = &'a GuideSample>, side: u8) -> Vec<Weighted> {
    let smooth = samples.into_iter().filter(|sample| sample.closure_density.is_finite());
    smooth.map(|sample| (to_square(sample.direction, side).0, sample.light * sample.share)).collect()
}

/// All trees of a guide.
#[derive(Debug, Default)]
pub(super) struct DirectionTrees {
    nodes: Vec<Node>,
}

/// A square that is cut into four: the parts of its light that these have, and the numbers of their nodes; 0 for one
/// that is not cut.
#[derive(Clone, Copy, Debug)]
struct Node {
    parts: [f32; 4],
    children: [u32; 4],
}

impl DirectionTrees {
    /// Adds the tree of these bounces, of which one has found light at least; gives its index. They are put into
    /// another order.
    pub(super) fn add(&mut self, samples: &mut [Weighted]) -> u32 {
        let total = samples.iter().map(|(_, light)| light).sum();
        let tree = self.cut(samples, total, 0);
        let nodes = &mut self.nodes[tree as usize..];
        nodes.iter_mut().for_each(|node| node.parts = [0.0; 4]);
        for &(place, light) in &*samples {
            let reach = BLUR * size_at(nodes, tree, place);
            for (x, y) in [-1.0, 0.0, 1.0].into_iter().flat_map(|x| [-1.0, 0.0, 1.0].map(|y| (x, y))) {
                let place = place + reach * Vec2::new(x, y);
                let place =
                    Vec2::new(place.x.clamp(0.0, ONE_MINUS_EPSILON), place.y.rem_euclid(1.0).min(ONE_MINUS_EPSILON));
                blur(nodes, tree, place, light);
            }
        }
        for node in nodes {
            let all: f32 = node.parts.iter().sum();
            let part = |part: f32| if all > 0.0 { MIN_PART + (1.0 - 4.0 * MIN_PART) * part / all } else { 0.25 };
            node.parts = node.parts.map(part);
        }
        tree
    }

    fn cut(&mut self, samples: &mut [Weighted], total: f32, depth: u32) -> u32 {
        let number = self.nodes.len();
        self.nodes.push(Node { parts: [0.0; 4], children: [0; 4] });
        let size = (-(depth as f32)).exp2();
        let quadrant = |place: Vec2| {
            let within = (place / size).fract();
            usize::from(within.x >= 0.5) + 2 * usize::from(within.y >= 0.5)
        };
        // Stable, and so the same everywhere.
        samples.sort_by_key(|&(place, _)| quadrant(place));
        let mut first = 0;
        let ends = [0, 1, 2, 3].map(|number| {
            first += samples[first..].iter().take_while(|(place, _)| quadrant(*place) == number).count();
            first
        });
        let starts = [0, ends[0], ends[1], ends[2]];
        let parts: [f32; 4] = std::array::from_fn(|i| samples[starts[i]..ends[i]].iter().map(|(_, light)| light).sum());
        for i in 0..4 {
            let samples = &mut samples[starts[i]..ends[i]];
            if parts[i] > CUT_FROM * total && samples.len() >= CUT_COUNT && depth + 1 < MAX_DEPTH {
                self.nodes[number].children[i] = self.cut(samples, total, depth + 1);
            }
        }
        number as u32
    }

    /// The density in the square, 1 on average.
    pub(super) fn density(&self, tree: u32, mut place: Vec2) -> f32 {
        let (mut node, mut density) = (&self.nodes[tree as usize], 1.0);
        loop {
            let quadrant = descend(&mut place);
            density *= 4.0 * node.parts[quadrant];
            match node.children[quadrant] {
                0 => return density,
                child => node = &self.nodes[child as usize],
            }
        }
    }

    /// A place of the square by numbers in [0, 1).
    pub(super) fn sample(&self, tree: u32, mut u: Vec2) -> Vec2 {
        let (mut node, mut corner, mut size) = (&self.nodes[tree as usize], Vec2::ZERO, 1.0);
        loop {
            size *= 0.5;
            let [a, b, c, d] = node.parts;
            let (up, y) = choose(a + b, c + d, u.y);
            let (left, right) = if up { (c, d) } else { (a, b) };
            let (right, x) = choose(left, right, u.x);
            u = Vec2::new(x, y);
            corner += size * Vec2::new(f32::from(right), f32::from(up));
            match node.children[usize::from(right) + 2 * usize::from(up)] {
                0 => return (corner + size * u).min(Vec2::splat(ONE_MINUS_EPSILON)),
                child => node = &self.nodes[child as usize],
            }
        }
    }

    /// Adds other trees; gives what is added to their indices.
    pub(super) fn append(&mut self, other: Self) -> u32 {
        let offset = self.nodes.len() as u32;
        self.nodes.extend(other.nodes.into_iter().map(|node| {
            let children = node.children.map(|child| if child == 0 { 0 } else { child + offset });
            Node { children, ..node }
        }));
        offset
    }
}

/// The quarter that a place is in; the place becomes that in the quarter.
fn descend(place: &mut Vec2) -> usize {
    *place *= 2.0;
    let (right, up) = (place.x >= 1.0, place.y >= 1.0);
    *place -= Vec2::new(f32::from(right), f32::from(up));
    usize::from(right) + 2 * usize::from(up)
}

/// The side of the square that is not cut here, in a tree whose nodes these are.
fn size_at(nodes: &[Node], tree: u32, mut place: Vec2) -> f32 {
    let (mut node, mut size) = (&nodes[0], 0.5);
    loop {
        match node.children[descend(&mut place)] {
            0 => return size,
            child => node = &nodes[(child - tree) as usize],
        }
        size *= 0.5;
    }
}

/// Adds light at a place to a tree whose nodes these are.
fn blur(nodes: &mut [Node], tree: u32, mut place: Vec2, light: f32) {
    let mut number = 0;
    loop {
        let (quadrant, node) = (descend(&mut place), &mut nodes[number]);
        node.parts[quadrant] += light;
        match node.children[quadrant] {
            0 => return,
            child => number = (child - tree) as usize,
        }
    }
}

/// Whether a number in [0, 1) chooses the second of two parts, and the rescaled remainder.
fn choose(first: f32, second: f32, u: f32) -> (bool, f32) {
    let from = first / (first + second);
    let (is_second, rest) = if u < from { (false, u / from) } else { (true, (u - from) / (1.0 - from)) };
    (is_second, rest.clamp(0.0, ONE_MINUS_EPSILON))
}

/// The coordinates of a vector whose last one is along the axis of a [side](super::cells::side).
fn turned(v: Vec3, side: u8) -> Vec3 {
    let sign = if side.is_multiple_of(2) { 1.0 } else { -1.0 };
    match side / 2 {
        0 => Vec3::new(v.y, v.z, sign * v.x),
        1 => Vec3::new(v.z, v.x, sign * v.y),
        _ => Vec3::new(v.x, v.y, sign * v.z),
    }
}

/// The vector with these coordinates.
fn turned_back(v: Vec3, side: u8) -> Vec3 {
    let sign = if side.is_multiple_of(2) { 1.0 } else { -1.0 };
    match side / 2 {
        0 => Vec3::new(sign * v.z, v.x, v.y),
        1 => Vec3::new(v.y, sign * v.z, v.x),
        _ => Vec3::new(v.x, v.y, sign * v.z),
    }
}

/// Where a unit vector is in the square, and by what a density in the square is multiplied to be one per solid angle.
pub(super) fn to_square(direction: Vec3, side: u8) -> (Vec2, f32) {
    let v = turned(direction, side);
    let sum = (v.x.abs() + v.y.abs()).max(f32::MIN_POSITIVE);
    let along = v.y / sum;
    // Quadrants in order around the axis, so that neighbours stay neighbours.
    let angle = match (v.x < 0.0, v.y < 0.0) {
        (false, false) => along,
        (true, false) => 2.0 - along,
        (true, true) => 2.0 - along,
        (false, true) => 4.0 + along,
    };
    let place = Vec2::new(0.5 + 0.5 * v.z, 0.25 * angle).clamp(Vec2::ZERO, Vec2::splat(ONE_MINUS_EPSILON));
    let squared = (v.x * v.x + v.y * v.y).max(f32::MIN_POSITIVE);
    (place, 0.125 * squared / (sum * sum).max(f32::MIN_POSITIVE))
}

/// The unit vector at this place.
pub(super) fn from_square(place: Vec2, side: u8) -> Vec3 {
    let z = (2.0 * place.x - 1.0).clamp(-1.0, 1.0);
    let angle = 4.0 * place.y;
    let quadrant = angle as u32;
    let along = angle - quadrant as f32;
    let (x, y) = match quadrant {
        0 => (1.0 - along, along),
        1 => (-along, 1.0 - along),
        2 => (along - 1.0, -along),
        _ => (along, along - 1.0),
    };
    let radius = ((1.0 - z * z).max(0.0) / (x * x + y * y)).sqrt();
    turned_back(Vec3::new(x * radius, y * radius, z).normalize(), side)
}
