//! Building a light tree: a node's lights are divided, the most costly part first, until there are eight parts or all fit
//! into leaves.
//!
//! A part is divided across an axis where the sum of both sides' costs is least; the cost is power times squared extent, as
//! irradiance falls with the squared distance, times up to 2 for lights that face many ways (Conty and Kulla 2018 take the
//! area of the box, which is 0 for a row of lights). It depends on the lights and their order alone.

use glam::{DMat3, DVec3};

use super::cluster::Clusters;
use super::cluster::set;
use super::leaf::{Emits, LeafLights};
use super::{Child, Leaf, Node, Tree, WIDTH};

/// Places of planes that may divide a part, along each axis, less one.
const BINS: usize = 16;
/// As many leaves as a root may have instead of nodes: their lights are all weighed.
const MOST_LEAVES: usize = 3;

/// A light that is to have its place.
struct Item {
    index: u32,
    corners: [DVec3; 3],
    radius: f64,
    middle: DVec3,
    axis: DVec3,
    angle: f64,
    moments: [f64; 3],
}

/// The cost inputs of a part.
#[derive(Clone, Copy)]
struct Measure {
    min: DVec3,
    max: DVec3,
    mean: f64,
    vector: DVec3,
}

impl Measure {
    const NONE: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY, mean: 0.0, vector: DVec3::ZERO };

    fn of(items: &[Item]) -> Self {
        items.iter().fold(Self::NONE, |measure, item| measure.with(&Self::one(item)))
    }

    fn one(item: &Item) -> Self {
        let [a, b, c] = item.corners;
        let [mean, slope, _] = item.moments;
        let (min, max) = (a.min(b).min(c) - item.radius, a.max(b).max(c) + item.radius);
        Self { min, max, mean, vector: slope * item.axis }
    }

    fn with(self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            mean: self.mean + other.mean,
            vector: self.vector + other.vector,
        }
    }

    fn cost(&self) -> f64 {
        if self.mean == 0.0 {
            return 0.0;
        }
        // 2 for cosine lights that face one way.
        let alike = (self.vector.length() / (2.0 * self.mean)).min(1.0);
        self.mean * (self.max - self.min).length_squared() * (2.0 - alike)
    }
}

impl<L: LeafLights<Light: Emits>> Tree<L> {
    /// The tree of these lights; `None` without any.
    pub(crate) fn build(lights: &[L::Light]) -> Option<Self> {
        let item = |(index, light): (u32, &L::Light)| {
            let corners = light.corners().map(|corner| corner.as_dvec3());
            let (axis, angle) = light.cone();
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            Item { index, corners, radius: light.radius(), middle, axis, angle, moments: light.moments() }
        };
        let mut items: Vec<Item> = (0..).zip(lights).map(item).collect();
        if items.is_empty() {
            return None;
        }
        let mut tree = Self { roots: Vec::new(), nodes: Vec::new(), leaves: Vec::new(), places: vec![0; lights.len()] };
        if items.len() <= MOST_LEAVES * WIDTH {
            for items in items.chunks(WIDTH) {
                let root = tree.leaf(lights, items, Tree::<L>::root_slot(tree.roots.len()));
                tree.roots.push(root);
            }
        } else {
            let root = tree.node(lights, &mut items, Tree::<L>::root_slot(0));
            tree.roots.push(root);
        }
        Some(tree)
    }

    fn node(&mut self, lights: &[L::Light], items: &mut [Item], parent: u32) -> Child {
        let number = self.nodes.len();
        self.nodes.push(Node { clusters: Clusters::default(), children: [Child::NONE; WIDTH], parent });
        for (slot, part) in parts(items).into_iter().enumerate() {
            self.nodes[number].clusters.put(slot, part);
            let parent = (number * WIDTH + slot) as u32;
            let child =
                if part.len() <= WIDTH { self.leaf(lights, part, parent) } else { self.node(lights, part, parent) };
            self.nodes[number].children[slot] = child;
        }
        Child::node(number)
    }

    fn leaf(&mut self, lights: &[L::Light], items: &[Item], parent: u32) -> Child {
        let number = self.leaves.len();
        let mut leaf = Leaf { lights: L::default(), indices: [0; WIDTH], parent };
        for (place, item) in items.iter().enumerate() {
            leaf.lights.put(place, &lights[item.index as usize]);
            leaf.indices[place] = item.index;
            self.places[item.index as usize] = (number * WIDTH + place) as u32;
        }
        self.leaves.push(leaf);
        Child::leaf(number)
    }
}

/// Up to eight parts of the lights, in their order in space.
fn parts(items: &mut [Item]) -> Vec<&mut [Item]> {
    let mut parts = vec![(Measure::of(items).cost(), items)];
    while parts.len() < WIDTH {
        let heavier = |best: Option<usize>, i: usize| match best {
            _ if parts[i].1.len() <= WIDTH => best,
            Some(best) if parts[best].0 >= parts[i].0 => Some(best),
            _ => Some(i),
        };
        let Some(next) = (0..parts.len()).fold(None, heavier) else { break };
        let (_, items) = parts.remove(next);
        let middle = divide(items);
        let (left, right) = items.split_at_mut(middle);
        parts.insert(next, (Measure::of(right).cost(), right));
        parts.insert(next, (Measure::of(left).cost(), left));
    }
    parts.into_iter().map(|(_, part)| part).collect()
}

/// Sorts lights into two parts; gives the number of those in the first, which is neither 0 nor all.
fn divide(items: &mut [Item]) -> usize {
    let (min, max) = items
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), item| (min.min(item.middle), max.max(item.middle)));
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        let extent = max[axis] - min[axis];
        if extent <= 0.0 {
            continue;
        }
        let mut bins = [Measure::NONE; BINS];
        for item in &*items {
            let bin = &mut bins[bin_of(item, axis, min[axis], extent)];
            *bin = bin.with(&Measure::one(item));
        }
        let mut above = [0.0; BINS];
        let mut sum = Measure::NONE;
        for i in (1..BINS).rev() {
            sum = sum.with(&bins[i]);
            above[i] = sum.cost();
        }
        let mut below = Measure::NONE;
        for i in 1..BINS {
            below = below.with(&bins[i - 1]);
            let cost = below.cost() + above[i];
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, i));
            }
        }
    }
    let Some((_, axis, plane)) = best else { return items.len() / 2 };
    let (min, extent) = (min[axis], max[axis] - min[axis]);
    items.sort_by_key(|item| bin_of(item, axis, min, extent) >= plane);
    let count = items.partition_point(|item| bin_of(item, axis, min, extent) < plane);
    // The first and the last bin have a light each, and so has either side.
    count.clamp(1, items.len() - 1)
}

fn bin_of(item: &Item, axis: usize, min: f64, extent: f64) -> usize {
    (((item.middle[axis] - min) / extent * BINS as f64) as usize).min(BINS - 1)
}

impl Clusters {
    /// Puts the cluster of some lights into place `i`.
    fn put(&mut self, i: usize, items: &[Item]) {
        let measure = Measure::of(items);
        let center = (0.5 * (measure.min + measure.max)).as_vec3();
        let (mut radius, mut angle, mut tensor) = (0.0_f64, 0.0_f64, DMat3::ZERO);
        let axis = measure.vector.try_normalize().unwrap_or(DVec3::Z).as_vec3();
        for item in items {
            for corner in item.corners {
                radius = radius.max(corner.distance(center.as_dvec3()) + item.radius);
            }
            angle = angle.max(item.angle + axis.as_dvec3().angle_between(item.axis));
            let outer = DMat3::from_cols(item.axis * item.axis.x, item.axis * item.axis.y, item.axis * item.axis.z);
            tensor += (outer * 1.5 - DMat3::IDENTITY * 0.5) * item.moments[2];
        }
        let angle = angle.min(std::f64::consts::PI);
        let far = center.abs().max_element();
        set(&mut self.center, i, center);
        // The distance to the centre will be rounded.
        self.radius[i] = radius as f32 + 4.0 * f32::EPSILON * (far + radius as f32);
        self.mean[i] = measure.mean as f32;
        set(&mut self.vector, i, measure.vector.as_vec3());
        let [x, y, z] = [tensor.x_axis, tensor.y_axis, tensor.z_axis];
        let six = [x.x, y.y, z.z, x.y, y.z, z.x];
        self.tensor.iter_mut().zip(six).for_each(|(lanes, value)| lanes[i] = value as f32);
        set(&mut self.axis, i, axis);
        (self.sin_cone[i], self.cos_cone[i]) = (angle.sin() as f32, angle.cos() as f32);
    }
}
