//! A light tree (Conty and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018): a light is
//! chosen by its estimated contribution to a point, in a time that grows with the logarithm of their number.
//!
//! Nodes have eight children, which are weighted in lanes, and leaves have up to eight lights. A child is chosen in
//! proportion to its weight by one random number, whose remainder chooses among the child's children; the probability
//! of a light is the product of the shares of its ancestors and itself. So [`Tree::probability`] needs no search: it
//! goes up from the light's leaf. Where all children have the weight 0, as a cluster's estimate may be positive
//! although its lights contribute nothing, their mean intensities are used instead: probabilities always add up to 1.
//!
//! Deviations: weights of clusters are estimates instead of bounds (see [`cluster`]), and a tree of few lights has only
//! leaves, which are weighted together.

mod build;
pub(crate) mod cluster;
mod frontier;
pub(crate) mod leaf;

use super::Receiver;
use cluster::{Clusters, Lane};
use leaf::LeafLights;

/// Children of a node, and lights of a leaf, at most.
pub(crate) const WIDTH: usize = 8;

/// A tree of lights of one kind.
#[derive(Clone, Debug)]
pub(crate) struct Tree<L> {
    /// One node or leaf, or a few leaves.
    roots: Vec<Child>,
    nodes: Vec<Node>,
    leaves: Vec<Leaf<L>>,
    /// For each light its leaf's index times eight, plus its place there.
    places: Vec<u32>,
}

#[derive(Clone, Debug)]
struct Node {
    clusters: Clusters,
    children: [Child; WIDTH],
    /// The parent's number, times eight, plus the place there; for roots see [`Tree::root_slot`].
    parent: u32,
}

#[derive(Clone, Debug)]
struct Leaf<L> {
    lights: L,
    indices: [u32; WIDTH],
    parent: u32,
}

/// A node, or a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Child(u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    const NONE: Self = Self(u32::MAX);

    fn node(number: usize) -> Self {
        Self(number as u32)
    }

    fn leaf(number: usize) -> Self {
        Self(number as u32 | Self::LEAF)
    }
}

/// The most roots.
pub(crate) const ROOTS: usize = 3;
/// Parents from this number on are none: what follows it is a root.
const NO_PARENT: u32 = u32::MAX - 8;

/// The weights of the children of all roots for a receiver.
pub(crate) type RootWeights = [Lane; ROOTS];

/// A light that was chosen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pick {
    pub index: u32,
    pub probability: f32,
    /// The rescaled remainder of the number that chose it, in [0, 1).
    pub rest: f64,
}

/// On the way to a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Descent {
    child: Child,
    /// The chosen grandchild.
    lane: usize,
    /// The rescaled remainder of the number.
    rest: f64,
    /// The probability with which it is chosen.
    probability: f32,
}

impl<L: LeafLights> Tree<L> {
    fn root_slot(root: usize) -> u32 {
        NO_PARENT + root as u32
    }

    /// The number of lights.
    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }

    /// Bytes of memory.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.leaves[..]) + size_of_val(&self.places[..])
    }

    #[inline(always)]
    fn weights(&self, child: Child, receiver: &Receiver) -> Lane {
        let number = (child.0 & !Child::LEAF) as usize;
        if child.0 & Child::LEAF == 0 {
            self.nodes[number].clusters.weights(receiver)
        } else {
            self.leaves[number].lights.weights(receiver)
        }
    }

    /// The weights of all lights for a receiver, by the children of the roots; their sum is an estimate of the
    /// irradiance.
    #[inline(always)]
    pub(crate) fn root_weights(&self, receiver: &Receiver) -> RootWeights {
        let mut weights = [[0.0; WIDTH]; ROOTS];
        for (weights, &root) in weights.iter_mut().zip(&self.roots) {
            *weights = self.weights(root, receiver);
        }
        weights
    }

    /// Chooses a light for a receiver for which roots have these weights, whose sum is not 0, by a number in [0, 1).
    #[inline(always)]
    pub(crate) fn choose(&self, receiver: &Receiver, roots: &RootWeights, u: f64) -> Pick {
        let mut descent = self.begin(roots, u);
        while self.descend(receiver, &mut descent) {}
        self.end(&descent)
    }

    /// The first step of [`choose`](Self::choose), among the children of the roots.
    #[inline(always)]
    pub(crate) fn begin(&self, roots: &RootWeights, u: f64) -> Descent {
        let sums = roots.each_ref().map(sum);
        let total = sums[0] + sums[1] + sums[2];
        let (mut root, mut place) = (0, u * f64::from(total));
        // Not to a root of no weight, where rounding led.
        let is_any_behind = |root: usize| sums[root + 1..].iter().any(|&sum| sum > 0.0);
        while root + 1 < self.roots.len() && place >= f64::from(sums[root]) && is_any_behind(root) {
            place -= f64::from(sums[root]);
            root += 1;
        }
        let (lane, rest) = pick(&roots[root], place);
        Descent { child: self.roots[root], lane, rest, probability: roots[root][lane] / total }
    }

    /// Goes on to a child's children, if it has any.
    #[inline(always)]
    pub(crate) fn descend(&self, receiver: &Receiver, descent: &mut Descent) -> bool {
        if descent.child.0 & Child::LEAF != 0 {
            return false;
        }
        let child = self.nodes[descent.child.0 as usize].children[descent.lane];
        let weights = self.nonzero_weights(child, receiver);
        let sums = Sums::of(&weights);
        let (lane, rest) = sums.pick(&weights, descent.rest * f64::from(sums.all));
        let probability = descent.probability * (weights[lane] / sums.all);
        *descent = Descent { child, lane, rest, probability };
        true
    }

    /// The light at which there was no way on.
    #[inline(always)]
    pub(crate) fn end(&self, &Descent { child, lane, rest, probability }: &Descent) -> Pick {
        let leaf = &self.leaves[(child.0 & !Child::LEAF) as usize];
        Pick { index: leaf.indices[lane], probability, rest }
    }

    /// The probability with which [`choose`](Self::choose) gives a light, times the sum of the roots' weights.
    #[inline(always)]
    pub(crate) fn weight(&self, index: u32, receiver: &Receiver) -> f32 {
        let place = self.places[index as usize];
        let (mut number, mut lane) = ((place / WIDTH as u32) as usize, place as usize % WIDTH);
        let mut child = Child::leaf(number);
        let mut parent = self.leaves[number].parent;
        let mut probability = 1.0;
        while parent < NO_PARENT {
            let weights = self.nonzero_weights(child, receiver);
            probability *= weights[lane] / sum(&weights);
            (number, lane) = ((parent / WIDTH as u32) as usize, parent as usize % WIDTH);
            child = Child::node(number);
            parent = self.nodes[number].parent;
        }
        probability * self.weights(child, receiver)[lane]
    }

    /// The weights of a child that was chosen: not all are 0.
    #[inline(always)]
    fn nonzero_weights(&self, child: Child, receiver: &Receiver) -> Lane {
        let weights = self.weights(child, receiver);
        if sum(&weights) > 0.0 { weights } else { self.sizes(child) }
    }

    /// The weights of a child's children if all estimates are 0.
    #[cold]
    fn sizes(&self, child: Child) -> Lane {
        let number = (child.0 & !Child::LEAF) as usize;
        if child.0 & Child::LEAF == 0 {
            return self.nodes[number].clusters.mean;
        }
        let mut sizes = [0.0; WIDTH];
        let leaf = (number * WIDTH) as u32;
        let is_used = |lane: usize| self.places.get(self.leaves[number].indices[lane] as usize);
        for (lane, size) in sizes.iter_mut().enumerate() {
            *size = f32::from(is_used(lane) == Some(&(leaf + lane as u32)));
        }
        sizes
    }
}

/// The sum of all weights of roots.
#[inline(always)]
pub(crate) fn total(roots: &RootWeights) -> f32 {
    sum(&roots[0]) + sum(&roots[1]) + sum(&roots[2])
}

/// The sum, always in the same order.
#[inline(always)]
pub(crate) fn sum(weights: &Lane) -> f32 {
    Sums::of(weights).all
}

/// See [`Sums::pick`].
#[inline(always)]
pub(crate) fn pick(weights: &Lane, place: f64) -> (usize, f64) {
    Sums::of(weights).pick(weights, place)
}

/// Sums of neighbouring weights.
struct Sums {
    pairs: [f32; 4],
    halves: [f32; 2],
    all: f32,
}

impl Sums {
    #[inline(always)]
    fn of(&[a, b, c, d, e, f, g, h]: &Lane) -> Self {
        let pairs = [a + b, c + d, e + f, g + h];
        let halves = [pairs[0] + pairs[1], pairs[2] + pairs[3]];
        Self { pairs, halves, all: halves[0] + halves[1] }
    }

    /// The lane in which a place lies if the weights lie side by side from 0 on, and how far into it, in [0, 1). One weight
    /// at least is not 0.
    #[inline(always)]
    fn pick(&self, weights: &Lane, place: f64) -> (usize, f64) {
        let mut place = place.max(0.0);
        let mut second = |[first, second]: [f32; 2]| {
            // Never to what is 0, where rounding led.
            let is_second = (place >= f64::from(first)) & (second > 0.0);
            place -= if is_second { f64::from(first) } else { 0.0 };
            usize::from(is_second)
        };
        let half = second(self.halves);
        let pair = 2 * half + second([self.pairs[2 * half], self.pairs[2 * half + 1]]);
        let lane = 2 * pair + second([weights[2 * pair], weights[2 * pair + 1]]);
        let rest = place / f64::from(weights[lane]);
        (lane, rest.clamp(0.0, 1.0 - f64::EPSILON / 2.0))
    }
}
