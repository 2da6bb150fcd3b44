//! Clusters about a receiver, for estimates that have more time than a light sample: a cluster near the receiver is replaced by
//! its children, as its own estimate does not tell how near each light is (Conty and Kulla 2018, "adaptive tree splitting").

use super::leaf::LeafLights;
use super::{Child, Descent, Pick, Tree};
use crate::light::Receiver;

/// Children of nodes and leaves that together have all lights.
pub(crate) struct Frontier {
    /// A node or leaf, the place of a child of it or light in it, and its weight, which is not 0.
    parts: Vec<(Child, usize, f32)>,
    /// The sum of weights: an estimate of the irradiance.
    pub total: f32,
}

impl<L: LeafLights> Tree<L> {
    /// The frontier for a receiver.
    pub(crate) fn frontier(&self, receiver: &Receiver) -> Frontier {
        let mut frontier = Frontier { parts: Vec::new(), total: 0.0 };
        let mut rest = self.roots.clone();
        while let Some(child) = rest.pop() {
            let weights = self.weights(child, receiver);
            for (lane, &weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
                let is_leaf = child.0 & Child::LEAF != 0;
                match self.nodes.get(child.0 as usize).filter(|_| !is_leaf) {
                    Some(node) if node.clusters.is_near(lane, receiver.position) => rest.push(node.children[lane]),
                    _ => {
                        frontier.parts.push((child, lane, weight));
                        frontier.total += weight;
                    }
                }
            }
        }
        frontier
    }

    /// Chooses a light by the weights of a frontier, which has any, by a number in [0, 1).
    pub(crate) fn choose_beyond(&self, receiver: &Receiver, frontier: &Frontier, u: f32) -> Pick {
        let mut place = u * frontier.total;
        let is_here = |&&(_, _, weight): &&(Child, usize, f32)| {
            place -= weight;
            place < 0.0
        };
        let last = frontier.parts.len() - 1;
        let &(child, lane, weight) = frontier.parts.iter().find(is_here).unwrap_or(&frontier.parts[last]);
        let rest = f64::from(1.0 + place.min(0.0) / weight).clamp(0.0, 1.0 - f64::EPSILON);
        let mut descent = Descent { child, lane, rest, probability: weight / frontier.total };
        while self.descend(receiver, &mut descent) {}
        self.end(&descent)
    }
}
