//! Filter importance sampling: samples are placed as the filter is shaped, so that each belongs to one pixel only.
//!
//! `pixel = Σ w L / Σ w`, where an offset from the pixel's centre is drawn with a density `p` proportional to the
//! filter's magnitude `|f|`, and `w = f / p`. No sample is shared between pixels, so a picture cannot depend on
//! its tiles or threads. The expectation of `w` is one, and `|w|` is constant: the integral of `|f|`, which is 1 for a
//! filter without negative lobes.
//!
//! Sources: Ernst, Stamminger and Greiner, "Filter Importance Sampling", 2006; Pharr, Jakob and Humphreys, "Physically
//! Based Rendering", 4th edition, 8.8.
//!
//! Deviation: the Gaussian and Mitchell's cubic are drawn as polylines through [`CELLS`] + 1 of their values from the
//! centre to the border, off the curve by less than 10⁻⁴ of its peak. Polylines have an exact inverse, and an exact
//! constant for a weight even where the filter crosses zero.

use crate::settings::Filter;

/// Cells of equal width between the centre of a tabulated filter and its border.
const CELLS: usize = 256;

/// Draws offsets from a pixel's centre by a [`Filter`].
#[derive(Clone, Debug)]
pub struct FilterSampler {
    /// Half the filter's width, in pixels.
    radius: f32,
    profile: Profile,
}

/// The position and the weight of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSample {
    /// Pixels from the pixel's centre: right and down.
    pub offset: [f32; 2],
    /// Filter over density; its expectation is 1, and it is negative in Mitchell's lobes.
    pub weight: f32,
}

#[derive(Clone, Debug)]
enum Profile {
    Box,
    Tent,
    Polyline(Polyline),
}

impl FilterSampler {
    /// Prepares to draw from `filter`, which has passed [`Filter::validate`].
    pub fn new(filter: &Filter) -> Self {
        let profile = match filter {
            Filter::Box { .. } => Profile::Box,
            Filter::Tent { .. } => Profile::Tent,
            Filter::Gaussian { .. } | Filter::Mitchell { .. } => Profile::Polyline(Polyline::new(filter)),
        };
        Self { radius: 0.5 * filter.width(), profile }
    }

    /// Maps `u` in [0, 1)² to a sample. Each axis is monotonic in its number, so that stratified numbers stay so.
    pub fn sample(&self, u: [f32; 2]) -> FilterSample {
        let [(x, weight_x), (y, weight_y)] = u.map(|u| self.sample_axis(u));
        FilterSample { offset: [x, y], weight: weight_x * weight_y }
    }

    /// Offset and weight along one axis. The filters are even: the distance from the centre comes from [0, 1), and its
    /// side from the half of [0, 1) that `u` lies in.
    fn sample_axis(&self, u: f32) -> (f32, f32) {
        let signed = 2.0 * u - 1.0;
        let v = signed.abs();
        let (distance, weight) = match &self.profile {
            Profile::Box => (v, 1.0),
            // The inverse of 2t - t², in a form that does not cancel.
            Profile::Tent => (v / (1.0 + (1.0 - v).sqrt()), 1.0),
            Profile::Polyline(polyline) => polyline.sample(v),
        };
        (self.radius * distance.copysign(signed), weight)
    }
}

/// A filter's profile from its centre (0) to its border (1), linear between the nodes.
#[derive(Clone, Debug)]
struct Polyline {
    nodes: Vec<Node>,
    /// The integral of the profile's magnitude over the integral of the profile.
    weight: f32,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    /// Distance from the centre.
    position: f32,
    /// Profile over the integral of its magnitude.
    value: f32,
    /// The probability to lie closer to the centre.
    cdf: f32,
}

impl Polyline {
    fn new(filter: &Filter) -> Self {
        let value = |cell: usize| filter.profile(cell as f64 / CELLS as f64);
        let step = 1.0 / CELLS as f64;
        let mut points = vec![(0.0, value(0))];
        for cell in 0..CELLS {
            let (left, right) = (value(cell), value(cell + 1));
            // A node where the line crosses zero: between two nodes the sign is constant.
            if left * right < 0.0 {
                points.push(((cell as f64 + left / (left - right)) * step, 0.0));
            }
            points.push(((cell + 1) as f64 * step, right));
        }

        let areas = points.windows(2).map(|line| 0.5 * (line[0].1 + line[1].1) * (line[1].0 - line[0].0));
        let integral: f64 = areas.clone().sum();
        let magnitude: f64 = areas.clone().map(f64::abs).sum();
        let cdf = areas.scan(0.0, |sum, area| {
            *sum += area.abs() / magnitude;
            Some(*sum)
        });
        let nodes = points.iter().zip(core::iter::once(0.0).chain(cdf)).map(|(&(position, value), cdf)| Node {
            position: position as f32,
            value: (value / magnitude) as f32,
            cdf: cdf as f32,
        });
        Self { nodes: nodes.collect(), weight: (magnitude / integral) as f32 }
    }

    /// Distance from the centre in [0, 1], and the weight there, for `v` in [0, 1].
    fn sample(&self, v: f32) -> (f32, f32) {
        let next = self.nodes.partition_point(|node| node.cdf <= v).clamp(1, self.nodes.len() - 1);
        let (left, right) = (self.nodes[next - 1], self.nodes[next]);
        let (a, b) = (left.value.abs(), right.value.abs());
        let width = right.position - left.position;
        // a s + (b - a) s² / (2 width) = v - cdf, solved for s in a form that does not cancel and holds for a = b.
        let mass = (v - left.cdf).max(0.0);
        let root = (a * a + 2.0 * mass * (b - a) / width).max(0.0).sqrt();
        let s = (2.0 * mass / (a + root).max(f32::MIN_POSITIVE)).min(width);
        (left.position + s, self.weight.copysign(left.value + right.value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILTERS: [Filter; 7] = [
        Filter::Box { width: 1.0 },
        Filter::Box { width: 2.5 },
        Filter::Tent { width: 2.0 },
        Filter::Gaussian { width: 3.0 },
        Filter::Mitchell { width: 4.0, sharpness: 0.0 },
        Filter::Mitchell { width: 4.0, sharpness: 2.0 / 3.0 },
        Filter::Mitchell { width: 3.0, sharpness: 1.0 },
    ];

    /// The additive recurrence of the plastic number (Roberts 2018): plain, even, and not the renderer's own numbers.
    fn points(count: u32) -> impl Iterator<Item = [f32; 2]> {
        (0..count).map(|i| {
            [0.754_877_666_246_692_8, 0.569_840_290_998_053_3].map(|a| (0.5 + a * f64::from(i)).fract() as f32)
        })
    }

    /// xorshift64*, for the test that wants independent numbers.
    fn random(state: &mut u64) -> f32 {
        *state ^= *state >> 12;
        *state ^= *state << 25;
        *state ^= *state >> 27;
        (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 40) as f32 / (1 << 24) as f32
    }

    /// The integral of `g(t)` over `from..to`, by Simpson's rule on small cells.
    fn integrate(from: f64, to: f64, g: impl Fn(f64) -> f64) -> f64 {
        let cells = 64;
        let h = (to - from) / f64::from(cells);
        let cell = |i: i32| {
            let left = from + h * f64::from(i);
            (g(left) + 4.0 * g(left + 0.5 * h) + g(left + h)) * h / 6.0
        };
        (0..cells).map(cell).sum()
    }

    #[test]
    fn offsets_are_distributed_by_the_magnitude_of_the_filter() {
        // χ² with 24 × 24 bins; the sign of the weight must be the filter's.
        const BINS: usize = 24;
        for filter in FILTERS {
            let sampler = FilterSampler::new(&filter);
            let (count, mut state) = (400_000, 0x9e37_79b9_7f4a_7c15);
            let mut histogram = [[0_u32; BINS]; BINS];
            for _ in 0..count {
                let FilterSample { offset, weight } = sampler.sample([random(&mut state), random(&mut state)]);
                let [i, j] = offset.map(|x| ((x / filter.width() + 0.5) * BINS as f32).min(BINS as f32 - 1.0) as usize);
                histogram[i][j] += 1;
                let value = filter.value(offset[0], offset[1]);
                assert!(
                    value * weight > 0.0 || value.abs() < 1e-3,
                    "{filter:?} at {offset:?}: {value}, weight {weight}"
                );
            }
            let edge = |i: usize| 2.0 * i as f64 / BINS as f64 - 1.0;
            let masses: Vec<f64> =
                (0..BINS).map(|i| integrate(edge(i), edge(i + 1), |t| filter.profile(t).abs())).collect();
            let total: f64 = masses.iter().sum();
            let (mut chi_squared, mut degrees, mut rest) = (0.0, -1.0, (0.0, 0.0));
            for (i, row) in histogram.iter().enumerate() {
                for (j, &observed) in row.iter().enumerate() {
                    let expected = f64::from(count) * masses[i] * masses[j] / (total * total);
                    if expected < 10.0 {
                        rest = (rest.0 + f64::from(observed), rest.1 + expected);
                    } else {
                        chi_squared += (f64::from(observed) - expected).powi(2) / expected;
                        degrees += 1.0;
                    }
                }
            }
            if rest.1 > 0.0 {
                chi_squared += (rest.0 - rest.1).powi(2) / rest.1;
                degrees += 1.0;
            }
            // χ² has the mean n and the variance 2n: five deviations.
            assert!(chi_squared < degrees + 5.0 * (2.0_f64 * degrees).sqrt(), "{filter:?}: {chi_squared} of {degrees}");
        }
    }

    #[test]
    fn weighted_moments_are_those_of_the_filter() {
        for filter in FILTERS {
            let sampler = FilterSampler::new(&filter);
            let radius = 0.5 * f64::from(filter.width());
            let count = 1 << 18;
            let mut sums = [0.0_f64; 6];
            for u in points(count) {
                let FilterSample { offset: [x, y], weight } = sampler.sample(u);
                let ([x, y], weight) = ([x, y].map(f64::from), f64::from(weight));
                let terms = [1.0, x, y, x * x, y * y, x * x * y * y];
                sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term / f64::from(count));
            }
            let second = radius * radius * 2.0 * integrate(0.0, 1.0 - 1e-13, |t| t * t * filter.profile(t));
            let expected = [1.0, 0.0, 0.0, second, second, second * second];
            for (sum, expected) in sums.into_iter().zip(expected) {
                assert!((sum - expected).abs() < 2e-3, "{filter:?}: {sums:?}, second moment {second}");
            }
        }
    }

    #[test]
    fn weights_are_exactly_one_without_negative_lobes_and_constant_with_them() {
        for filter in FILTERS {
            let sampler = FilterSampler::new(&filter);
            let constant = sampler.sample([0.5, 0.5]).weight;
            match filter {
                Filter::Mitchell { sharpness, .. } if sharpness > 0.0 => assert!(constant > 1.05),
                _ => assert_eq!(constant, 1.0),
            }
            assert!(points(10_000).all(|u| sampler.sample(u).weight.abs() == constant));
        }
    }

    #[test]
    fn the_map_is_monotonic_odd_and_finite_up_to_the_ends() {
        let ends = [0.0, f32::MIN_POSITIVE, 0.25, 0.5, 0.75, 1.0 - f32::EPSILON, 1.0 - 0.5 * f32::EPSILON];
        for filter in FILTERS {
            let sampler = FilterSampler::new(&filter);
            let radius = 0.5 * filter.width();
            let at = |u: f32| sampler.sample([u, 0.5]).offset[0];
            // Up to the last cell: its mass may be less than the spacing of 32-bit floats at 1.
            assert!(at(0.0) <= -radius * (1.0 - 1.0 / CELLS as f32));
            assert_eq!(at(0.5), 0.0);
            let mut numbers: Vec<f32> = (0..5000).map(|i| i as f32 / 5000.0).chain(ends).collect();
            numbers.sort_by(f32::total_cmp);
            for pair in numbers.windows(2) {
                assert!(at(pair[0]) <= at(pair[1]), "{filter:?} at {pair:?}");
                assert!(at(pair[1]).abs() <= radius);
            }
            for u in [0.125, 0.25, 0.4375] {
                assert_eq!(at(u), -at(1.0 - u));
            }
        }
    }

    #[test]
    fn the_simple_filters_are_inverted_analytically() {
        let at = |filter, u| FilterSampler::new(&filter).sample([u, 0.5]).offset[0];
        assert_eq!(at(Filter::Box { width: 3.0 }, 0.75), 0.75);
        // Half a side's mass of a tent lies within 1 - √½ of the centre.
        assert!((at(Filter::Tent { width: 2.0 }, 0.75) - (1.0 - 0.5_f32.sqrt())).abs() < 1e-7);
        assert!((at(Filter::Tent { width: 2.0 }, 0.25) + (1.0 - 0.5_f32.sqrt())).abs() < 1e-7);
    }
}
