//! Light from infinitely far away, weighted by its irradiance on a surface's normal: directional lights, and the sky in
//! patches.
//!
//! A patch of the flux `Φ` and the mean direction `D`, of which no direction is further away than `r`, is taken to be
//! spread evenly over heights from `n · D - r` to `n · D + r` (see [`height`]). So its weight is 0 only if all of it
//! lies below the horizon.

use super::Receiver;
use super::tree::WIDTH;
use super::tree::cluster::{Lane, at, finite_or_zero, height, set};
use glam::Vec3;

/// Lights or patches, eight in a row.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patches {
    rows: Vec<Row>,
    len: usize,
}

/// Up to eight.
#[derive(Clone, Debug, Default)]
struct Row {
    direction: [Lane; 3],
    radius: Lane,
    irradiance: Lane,
}

impl Patches {
    /// Adds a patch with this mean direction towards the light, from which none of its directions differs by more than
    /// `radius`, and which causes this irradiance on a surface that faces it, as luminance.
    pub(crate) fn push(&mut self, direction: Vec3, radius: f32, irradiance: f32) {
        let i = self.len % WIDTH;
        if i == 0 {
            self.rows.push(Row::default());
        }
        let row = &mut self.rows[self.len / WIDTH];
        set(&mut row.direction, i, direction);
        (row.radius[i], row.irradiance[i]) = (radius, irradiance);
        self.len += 1;
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// The mean direction towards a patch.
    pub(crate) fn direction(&self, index: usize) -> Vec3 {
        at(&self.rows[index / WIDTH].direction, index % WIDTH)
    }

    /// Lets a patch weigh less.
    pub(crate) fn scale(&mut self, index: usize, factor: f32) {
        self.rows[index / WIDTH].irradiance[index % WIDTH] *= factor;
    }

    /// The irradiance that one of them causes at the receiver if nothing is in between.
    pub(crate) fn weight(&self, index: usize, receiver: &Receiver) -> f32 {
        self.rows[index / WIDTH].weights(receiver)[index % WIDTH]
    }

    /// The irradiance that each row of them causes at the receiver if nothing is in between.
    #[inline(always)]
    pub(crate) fn rows<'a>(&'a self, receiver: &'a Receiver) -> impl Iterator<Item = Lane> + 'a {
        self.rows.iter().map(|row| row.weights(receiver))
    }
}

impl Row {
    #[inline(always)]
    fn weights(&self, receiver: &Receiver) -> Lane {
        let mut weights = [0.0; WIDTH];
        for (i, weight) in weights.iter_mut().enumerate() {
            let (z, radius) = (receiver.normal.dot(at(&self.direction, i)), self.radius[i]);
            let heights = height(z, radius) + height(-z, radius) * receiver.behind;
            *weight = finite_or_zero(self.irradiance[i] * heights);
        }
        weights
    }
}
