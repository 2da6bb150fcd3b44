//! All light paths of a few samples, as a tree: a path's state is its node, and the nodes above it are its events.
//!
//! It replaces the automaton of light path expressions, with a state of its own for each different path.

use std::sync::{Mutex, MutexGuard, PoisonError};

use glam::Vec3;

use crate::lpe::Event;

/// The tree.
pub(super) struct PathTree {
    /// Events by index.
    events: Vec<Event>,
    nodes: Mutex<Vec<Node>>,
}

/// Paths to which the same has happened so far.
#[derive(Clone, Copy)]
struct Node {
    parent: u32,
    /// The last event.
    event: u32,
    /// The light of the paths that ended here.
    light: Vec3,
}

impl PathTree {
    /// The state of a path that has left the camera.
    pub(super) const START: u32 = 0;

    /// A tree for these events, without paths.
    pub(super) fn new(events: Vec<Event>) -> Self {
        Self { events, nodes: Mutex::new(vec![Node::ROOT]) }
    }

    /// The state after an event.
    pub(super) fn next(&self, state: u32, event: u32) -> u32 {
        let mut nodes = self.nodes();
        // A child comes after its parent.
        let after = state as usize + 1;
        let known = nodes[after..].iter().position(|node| node.parent == state && node.event == event);
        known.map_or_else(
            || {
                nodes.push(Node { parent: state, event, light: Vec3::ZERO });
                nodes.len() as u32 - 1
            },
            |place| (after + place) as u32,
        )
    }

    /// Adds light that paths have found which have come to these states, one for each channel.
    pub(super) fn add(&self, states: [u32; 3], light: Vec3) {
        let mut nodes = self.nodes();
        for (c, state) in states.into_iter().enumerate() {
            nodes[state as usize].light[c] += light[c];
        }
    }

    /// Takes the paths that have found light, in the order in which they were first followed, and forgets all.
    pub(super) fn take(&self) -> Vec<(Vec<Event>, Vec3)> {
        let nodes = std::mem::replace(&mut *self.nodes(), vec![Node::ROOT]);
        let lit = (0..nodes.len()).filter(|&node| nodes[node].light != Vec3::ZERO);
        lit.map(|node| (self.path(&nodes, node), nodes[node].light)).collect()
    }

    fn path(&self, nodes: &[Node], mut node: usize) -> Vec<Event> {
        let mut events = Vec::new();
        while node != Self::START as usize {
            events.push(self.events[nodes[node].event as usize].clone());
            node = nodes[node].parent as usize;
        }
        events.reverse();
        events
    }

    /// No panic leaves them half changed.
    fn nodes(&self) -> MutexGuard<'_, Vec<Node>> {
        self.nodes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Node {
    const ROOT: Self = Self { parent: u32::MAX, event: 0, light: Vec3::ZERO };
}
