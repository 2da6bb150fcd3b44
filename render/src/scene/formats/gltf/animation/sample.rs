//! What a channel says at a time.

use glam::DQuat;

use super::{Channel, Interpolation, Property};

impl Channel {
    /// Numbers `part` of a cubic's key: 0 the in-tangent, 1 the value, 2 the out-tangent.
    fn part(&self, key: usize, part: usize) -> &[f32] {
        &self.values[(3 * key + part) * self.width..][..self.width]
    }

    /// The value at a key.
    pub(super) fn value(&self, key: usize) -> &[f32] {
        match self.interpolation {
            Interpolation::CubicSpline => self.part(key, 1),
            _ => &self.values[key * self.width..][..self.width],
        }
    }

    /// The property at a time in seconds: three numbers, a quaternion, not always of length 1, or a weight for each
    /// target.
    pub(crate) fn at(&self, time: f64) -> Vec<f64> {
        // Keys are single precision: a frame must be at its key, not just before it.
        let time = time as f32;
        let value = |key: usize| self.value(key).iter().map(|&number| f64::from(number));
        let after = self.times.partition_point(|&key| key <= time);
        if after == 0 || after == self.times.len() {
            return value(after.saturating_sub(1)).collect();
        }
        let (before, [from, to]) = (after - 1, [after - 1, after].map(|key| f64::from(self.times[key])));
        let t = (f64::from(time) - from) / (to - from);
        match self.interpolation {
            Interpolation::Step => value(before).collect(),
            Interpolation::Linear if self.property == Property::Rotation => {
                let [from, to] = [before, after].map(|key| {
                    let turn = DQuat::from_slice(&value(key).collect::<Vec<_>>());
                    turn.normalize()
                });
                from.slerp(to, t).to_array().to_vec()
            }
            Interpolation::Linear => value(before).zip(value(after)).map(|(from, to)| from + (to - from) * t).collect(),
            Interpolation::CubicSpline => {
                let (t2, t3, d) = (t * t, t * t * t, to - from);
                let factors = [
                    (before, 1, 2.0 * t3 - 3.0 * t2 + 1.0),
                    (before, 2, d * (t3 - 2.0 * t2 + t)),
                    (after, 1, 3.0 * t2 - 2.0 * t3),
                    (after, 0, d * (t3 - t2)),
                ];
                let number =
                    |slot| factors.iter().map(|&(key, part, f)| f * f64::from(self.part(key, part)[slot])).sum();
                (0..self.width).map(number).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(
        property: Property,
        interpolation: Interpolation,
        times: &[f32],
        values: &[f32],
        width: usize,
    ) -> Channel {
        Channel { node: 0, property, interpolation, times: times.to_vec(), values: values.to_vec(), width }
    }

    #[test]
    fn steps_and_lines_hold_outside_of_their_keys() {
        let values = [1.0, 2.0, 5.0];
        let step = channel(Property::Weights, Interpolation::Step, &[1.0, 2.0, 4.0], &values, 1);
        let linear = channel(Property::Weights, Interpolation::Linear, &[1.0, 2.0, 4.0], &values, 1);
        for (time, stepped, even) in [
            (0.0, 1.0, 1.0),
            (1.0, 1.0, 1.0),
            (1.5, 1.0, 1.5),
            (2.0, 2.0, 2.0),
            (3.5, 2.0, 4.25),
            (4.0, 5.0, 5.0),
            (9.0, 5.0, 5.0),
        ] {
            assert_eq!((step.at(time), linear.at(time)), (vec![stepped], vec![even]), "{time}");
        }
        // One third is not a number of single precision: the frame has the key's value all the same.
        let third = channel(Property::Weights, Interpolation::Step, &[0.0, (1.0_f64 / 24.0) as f32], &[1.0, 2.0], 1);
        assert_eq!(third.at(1.0 / 24.0), [2.0]);
        let twice = channel(Property::Weights, Interpolation::Linear, &[0.0, 1.0, 1.0, 2.0], &[0.0, 1.0, 3.0, 4.0], 1);
        assert_eq!([twice.at(0.5), twice.at(1.0), twice.at(1.5)].concat(), [0.5, 3.0, 3.5]);
    }

    #[test]
    fn rotations_take_the_shorter_arc() {
        let turn = |angle: f32| glam::Quat::from_rotation_z(angle).to_array();
        let quarter = turn(core::f32::consts::FRAC_PI_2).map(|number| -number);
        let values = [turn(0.0), quarter].concat();
        let channel = channel(Property::Rotation, Interpolation::Linear, &[0.0, 1.0], &values, 4);
        let third = DQuat::from_slice(&channel.at(1.0 / 3.0));
        let expected = DQuat::from_rotation_z(core::f64::consts::FRAC_PI_6);
        assert!(third.dot(expected).abs() > 1.0 - 1e-12, "{third}");
    }

    #[test]
    fn splines_pass_their_values_along_their_tangents() {
        // v = 1 + 2s - s² + s³ for s from 0.5 to 2.5 is a cubic, so its Hermite spline is itself.
        let v = |s: f64| 1.0 + 2.0 * s - s * s + s * s * s;
        let slope = |s: f64| 2.0 - 2.0 * s + 3.0 * s * s;
        let key = |s: f64| [slope(s), v(s), slope(s)].map(|number| number as f32);
        let values = [key(0.5), key(2.5)].concat();
        let spline = channel(Property::Weights, Interpolation::CubicSpline, &[0.5, 2.5], &values, 1);
        for s in [0.5, 0.75, 1.5, 2.25, 2.5] {
            assert!((spline.at(s)[0] - v(s)).abs() < 1e-5, "{s}: {}", spline.at(s)[0]);
        }
        assert_eq!((spline.at(0.0)[0], spline.at(3.0)[0]), (f64::from(v(0.5) as f32), f64::from(v(2.5) as f32)));
    }
}
