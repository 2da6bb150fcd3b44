//! The light-sample warp: warps the unit square so that points of a triangle light near the surface are sampled about in
//! proportion to what they contribute.
//!
//! Light from the point `y` of an even triangle reaches a surface at `x` in proportion to `cos θ cos θ_y / |y - x|²`, which
//! over a light nearby varies by orders of magnitude, so that samples spread evenly over its area are noisy. Its values at
//! the light's corners, of which `cos θ_y / |y - x|` is the same but for a factor that all have, weight the square that is
//! mapped to the triangle; two of its corners are those of an edge, one the third corner and one the other edge's middle
//! (as Pharr, Jakob and Humphreys, "Physically Based Rendering", 6.5.4, do for the receiver's cosine alone). No light is
//! left out: a part of the weight is the same everywhere.

use glam::Vec3;
use halfdome_kernel::Triangle;
use halfdome_kernel::sampling::warp::Bilinear;

use crate::light::Receiver;
use crate::settings::LightSampling;

/// The part of the sum of all weights that every corner has at least, where bounces find the light too …
const FLOOR_WITH_BOUNCES: f32 = 0.05;
/// … and where they do not: samples are then at most twice as noisy as even ones.
const FLOOR_ALONE: f32 = 0.25;
/// The least cosine of a corner, where samples are alone. Lower ones may belong to an edge shared by the surface and
/// the light: the light is brightest near it, which corners do not show.
const MIN_COSINE: f32 = 0.1;

/// The weights of the square that [`Triangle`](halfdome_kernel::sampling::warp::Triangle) maps to a light with these
/// corners, for a receiver, if light is found by `lights`. Without a branch,
/// so that loops over it become lanes.
#[inline(always)]
pub(crate) fn light_warp(receiver: &Receiver, &[a, b, c]: &Triangle, lights: LightSampling) -> Bilinear {
    let is_alone = lights != LightSampling::Mis;
    let is_grazing = is_grazing(receiver, a) | is_grazing(receiver, b) | is_grazing(receiver, c);
    let m = 0.5 * (b + c);
    let [a, b, c, m] = [
        corner_weight(receiver, a),
        corner_weight(receiver, b),
        corner_weight(receiver, c),
        corner_weight(receiver, m),
    ];
    let sum = a + b + c + m;
    // Nothing is seen, or the square of what is does not fit into numbers.
    let fits = (sum > 1e-16) & (sum < 1e16) & !(is_alone & is_grazing);
    let floor = sum * if is_alone { FLOOR_ALONE } else { FLOOR_WITH_BOUNCES };
    Bilinear {
        weights: [
            if fits { a + floor } else { 1.0 },
            if fits { b + floor } else { 1.0 },
            if fits { c + floor } else { 1.0 },
            if fits { m + floor } else { 1.0 },
        ],
    }
}

/// `cos θ / |y - x|³` of a corner `y`.
#[inline(always)]
fn corner_weight(receiver: &Receiver, corner: Vec3) -> f32 {
    let way = corner - receiver.position;
    let squared = way.length_squared();
    receiver.height(way) / (squared * squared)
}

#[inline(always)]
fn is_grazing(receiver: &Receiver, corner: Vec3) -> bool {
    let way = corner - receiver.position;
    let height = receiver.height(way);
    height * height < MIN_COSINE * MIN_COSINE * way.length_squared()
}

#[cfg(test)]
mod tests {
    use glam::Vec2;
    use halfdome_kernel::sampling::Stream;
    use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, Warp};

    use super::*;

    const LIGHT: Triangle = [Vec3::new(0.0, 0.0, 0.2), Vec3::new(1.0, 0.0, 0.2), Vec3::new(0.0, 1.0, 0.2)];

    /// Mean and variance of an estimate of the light's form factor from the origin, whose normal is `normal`.
    fn form_factor(normal: Vec3, warp: &Bilinear) -> (f64, f64) {
        let count = 200_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for i in 0..count {
            let u = warp.map(Stream::new(3, i, 0).uniform2(0));
            let point = TriangleWarp.map(u);
            let y = LIGHT[0] + (LIGHT[1] - LIGHT[0]) * point.x + (LIGHT[2] - LIGHT[0]) * point.y;
            let transfer = normal.dot(y).max(0.0) * y.z / y.length_squared().powi(2);
            let value = f64::from(0.5 * transfer / (warp.density(u) * std::f32::consts::PI));
            sum += value;
            squares += value * value;
        }
        let mean = sum / f64::from(count);
        (mean, squares / f64::from(count) - mean * mean)
    }

    /// Lambert's formula: the edges' angles times the normal's part of their directions, over 2π. The light must be above
    /// the horizon.
    fn lambert(normal: Vec3) -> f64 {
        let corners = LIGHT.map(|corner| corner.as_dvec3().normalize());
        let edges = (0..3).map(|i| {
            let (from, to) = (corners[i], corners[(i + 1) % 3]);
            from.angle_between(to) * from.cross(to).normalize().dot(normal.as_dvec3())
        });
        edges.sum::<f64>() / std::f64::consts::TAU
    }

    #[test]
    fn form_factors_are_exact_and_less_noisy() {
        let even = Bilinear { weights: [1.0; 4] };
        for normal in [Vec3::Z, Vec3::new(0.4, 0.3, 0.9).normalize(), Vec3::new(0.05, 0.02, 1.0).normalize()] {
            let weighted = light_warp(&Receiver::new(Vec3::ZERO, normal, false), &LIGHT, LightSampling::Mis);
            let ((mean, variance), (_, evenly)) = (form_factor(normal, &weighted), form_factor(normal, &even));
            let standard_error = (variance / 200_000.0).sqrt();
            assert!((mean - lambert(normal)).abs() < 4.0 * standard_error, "{mean}, not {}", lambert(normal));
            assert!(variance < 0.5 * evenly, "{variance} of {evenly}");
        }
    }

    #[test]
    fn without_bounces_every_part_of_a_light_is_looked_at_half_as_often_as_evenly_at_least() {
        for k in 1..200u32 {
            // On walls that meet the light along an edge, or nearly.
            let [x, height] = [k as f32 / 200.0, 2f32.powi(-(k as i32 % 20))];
            let position = LIGHT[0] + Vec3::new(x, 0.0, -height);
            for normal in [Vec3::Y, Vec3::new(0.0, 0.99, 0.1).normalize(), Vec3::Z] {
                let warp = light_warp(&Receiver::new(position, normal, false), &LIGHT, LightSampling::Direct);
                for corner in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE] {
                    let density = warp.density(corner);
                    assert!(density > 0.499, "{density} from {position}, {normal}");
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_weighted_is_even() {
        let warp = |position, normal| light_warp(&Receiver::new(position, normal, false), &LIGHT, LightSampling::Mis);
        let below = warp(Vec3::ZERO, Vec3::NEG_Z);
        let on_a_corner = warp(LIGHT[1], Vec3::X);
        let far = warp(Vec3::splat(1e15), Vec3::NEG_Z);
        for warp in [below, on_a_corner, far] {
            assert_eq!((warp.weights, warp.density(Vec2::splat(0.3))), ([1.0; 4], 1.0));
        }
    }
}
