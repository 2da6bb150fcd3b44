//! Interpolation: the irradiance at a point from the records around it.

use glam::Vec3;

use super::weight::Weighting;
use super::{Cache, LookupPoint};
use crate::settings::Gradients;

/// The reconstruction at a point from the surrounding records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reading {
    /// Each by what its own gather says, as published.
    Alone(Gradients),
    /// Each by what its neighbours say as well, in a cache that has both gradients.
    Together,
}

/// Irradiance from the records around a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpolated {
    /// In W/m², linear sRGB; never negative.
    pub irradiance: Vec3,
    /// Records whose extrapolation had a negative channel, which counted as 0.
    pub negative: u32,
}

impl Cache {
    /// Whether a point needs no record of its own.
    pub(crate) fn covers(&self, point: &LookupPoint) -> bool {
        let weighting = self.weighting(1.0);
        let mut covered = false;
        self.tree.query(point.position, |i| {
            covered = covered || weighting.weight(&self.records[i], point) > 0.0;
        });
        covered
    }

    /// Calls `mix` with the index and the weight of each record that is valid at a point, in the order in which
    /// [`interpolate`](Self::interpolate) takes them.
    pub(crate) fn weigh(&self, point: &LookupPoint, mut mix: impl FnMut(usize, f32)) {
        let weighting = self.weighting(self.stretch());
        self.tree.query(point.position, |i| {
            let weight = weighting.weight(&self.records[i], point);
            if weight > 0.0 {
                mix(i, weight);
            }
        });
    }

    /// The irradiance at a point with a unit normal; `None` where no record is valid.
    pub fn interpolate(&self, position: Vec3, normal: Vec3) -> Option<Interpolated> {
        self.interpolate_by(self.reading(), position, normal)
    }

    /// The same with a reading that may not be that of the options.
    pub(crate) fn interpolate_by(&self, reading: Reading, position: Vec3, normal: Vec3) -> Option<Interpolated> {
        let point = LookupPoint { position, normal, clearance: None };
        self.mix(reading, &self.weighting(self.stretch()), &point, normal)
    }

    /// The irradiance at a point for the unit normal that a map tilts its own to.
    pub(crate) fn interpolate_tilted(&self, point: &LookupPoint, tilted: Vec3) -> Option<Interpolated> {
        self.mix(self.reading(), &self.weighting(self.stretch()), point, tilted)
    }

    /// The same, where surfaces turn so much that no record is valid by the published angles, from those up to 45°
    /// away.
    pub(crate) fn interpolate_wide(&self, point: &LookupPoint, tilted: Vec3) -> Option<Interpolated> {
        let strict = self.interpolate_tilted(point, tilted);
        strict.or_else(|| self.mix(self.reading(), &self.weighting(self.stretch()).wide(), point, tilted))
    }

    /// The reconstruction by the options.
    fn reading(&self) -> Reading {
        match self.options.gradients {
            Gradients::Both => Reading::Together,
            gradients => Reading::Alone(gradients),
        }
    }

    /// The irradiance of records at a point, for a tilted normal.
    #[inline]
    fn mix(&self, reading: Reading, weighting: &Weighting, point: &LookupPoint, tilted: Vec3) -> Option<Interpolated> {
        let LookupPoint { position, normal, .. } = *point;
        let gradients = match reading {
            Reading::Alone(gradients) => gradients,
            Reading::Together => Gradients::Both,
        };
        let rotation = gradients != Gradients::Off;
        let translation = gradients == Gradients::Both;
        let (mut sum, mut weights, mut negative) = (Vec3::ZERO, 0.0, 0);
        self.tree.query(position, |i| {
            let record = &self.records[i];
            let weight = weighting.weight(record, point);
            if weight > 0.0 {
                let irradiance = match self.polynomials.get(i) {
                    Some(polynomial) if reading == Reading::Together => {
                        polynomial.extrapolate(record, position, normal)
                    }
                    _ => record.extrapolate(position, normal, rotation, translation),
                };
                let irradiance = match tilted == normal {
                    true => irradiance,
                    false => record.tilt(irradiance, normal, tilted, rotation),
                };
                negative += u32::from(irradiance.min_element() < 0.0);
                sum += weight * irradiance.max(Vec3::ZERO);
                weights += weight;
            }
        });
        (weights > 0.0).then(|| Interpolated { irradiance: sum / weights, negative })
    }
}
