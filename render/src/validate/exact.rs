//! Closed forms for the experiments' scenes.
//!
//! Emitters have radiance `L = 1` unless stated otherwise, so that irradiance is π times a form factor.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

/// Radiance in a closed room, all of whose surfaces emit `emission` and reflect `reflectance`, after `bounces`:
/// `L_e (1 - ρ^{k+1}) / (1 - ρ)`, whatever the room's shape.
pub(crate) fn furnace_after(emission: f64, reflectance: f64, bounces: u32) -> f64 {
    furnace(emission, reflectance) * (1.0 - furnace_residual(reflectance, bounces))
}

/// What is missing after `bounces`, relative to the whole: `ρ^{k+1}`.
pub(crate) fn furnace_residual(reflectance: f64, bounces: u32) -> f64 {
    reflectance.powi(bounces as i32 + 1)
}

/// Radiance in the room after all bounces: `L_e / (1 - ρ)`.
pub(crate) fn furnace(emission: f64, reflectance: f64) -> f64 {
    emission / (1.0 - reflectance)
}

/// Variance of one path in the room if it survives each surface with probability `p`, and finds light only by bounces:
/// `L_e² [(1+ρ) / ((1-ρ)(1-ρ²/p)) - 1/(1-ρ)²]`; infinite up to `p = ρ²`.
///
/// A path's value is `X = L_e + (B/p) ρ X'`, with `B` one if it survives and `X'` distributed like `X`. So `E X² =
/// L_e² + 2 ρ L_e E X + ρ²/p E X²`, which has a solution for `p > ρ²` alone.
pub(crate) fn roulette_variance(emission: f64, reflectance: f64, p: f64) -> f64 {
    let (rho, squares) = (reflectance, 1.0 - reflectance * reflectance / p);
    if squares <= 0.0 {
        return f64::INFINITY;
    }
    emission * emission * ((1.0 + rho) / ((1.0 - rho) * squares) - 1.0 / ((1.0 - rho) * (1.0 - rho)))
}

/// Irradiance from a point light of unit intensity that a surface sees in direction `to_light` (not normalised): `cos
/// θ/d²`.
pub(crate) fn point_irradiance(to_light: DVec3, normal: DVec3) -> f64 {
    normal.dot(to_light).max(0.0) / to_light.length().powi(3)
}

/// Irradiance from a sphere of radius `radius` whose centre is at `to_centre` from a point outside of it.
///
/// Above the horizon it is `π (R/d)² cos ω`. Where the horizon cuts the sphere it is Snyder's form ("Area Light Sources
/// for Real-Time Graphics", 1996) as Lagarde and de Rousiers print it ("Moving Frostbite to PBR", 2014, listing 10).
pub(crate) fn sphere_irradiance(to_centre: DVec3, normal: DVec3, radius: f64) -> f64 {
    let distance = to_centre.length();
    let cos = normal.dot(to_centre) / distance;
    let sin_squared = (radius / distance).powi(2);
    if cos * cos > sin_squared {
        return PI * sin_squared * cos.max(0.0);
    }
    let sin = (1.0 - cos * cos).sqrt();
    let x = (1.0 / sin_squared - 1.0).sqrt();
    let y = -x * cos / sin;
    let chord = sin * (1.0 - y * y).sqrt();
    (cos * y.acos() - x * chord) * sin_squared + (chord / x).atan()
}

/// Irradiance from a polygon wholly above the horizon: half the sum over edges of the angle that the edge subtends,
/// times the cosine between the normal and that of the edge's triangle with the point (Lambert, "Photometria", 1760).
/// Positive if the corners run counter-clockwise as the point sees them.
pub(crate) fn polygon_irradiance(point: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let edges = polygon.iter().zip(next).map(|(a, b)| (a - point, b - point));
    edges.map(|(a, b)| a.angle_between(b) * a.cross(b).normalize().dot(normal)).sum::<f64>() / 2.0
}

/// Irradiance from a sky of radiance one on level ground at distance `a` from an endless black wall of height `h`:
/// `π/2 (1 + a/√(a²+h²))`.
pub(crate) fn sky_beside_wall(a: f64, h: f64) -> f64 {
    FRAC_PI_2 * (1.0 + a / a.hypot(h))
}

/// Variance of the openness beside that wall by one ray: with a density in proportion to the cosine it is a coin with
/// the openness `V = E/π`, of `V (1 - V)`.
pub(crate) fn openness_variance(a: f64, h: f64) -> f64 {
    let open = sky_beside_wall(a, h) / PI;
    open * (1.0 - open)
}

/// The same by one uniform ray, which counts `2 cos θ`: `⟨4 cos² θ⟩ = 8/3π (φ/2 + π/4 + sin 2φ/4)` over the open
/// directions, which end at the angle `φ = atan(a/h)` from the normal.
pub(crate) fn uniform_openness_variance(a: f64, h: f64) -> f64 {
    let angle = (a / h).atan();
    let square = 8.0 / (3.0 * PI) * (angle / 2.0 + PI / 4.0 + (2.0 * angle).sin() / 4.0);
    square - (sky_beside_wall(a, h) / PI).powi(2)
}

/// The form factor from a sphere of radius `r1` to one of radius `r2` with its centre at distance `d > r1 + r2`: the
/// mean of [`sphere_irradiance`] over the first, by Simpson's rule in the cosine to the axis.
pub(crate) fn sphere_form_factor(r1: f64, r2: f64, d: f64) -> f64 {
    const STEPS: u32 = 4096;
    let at = |cos: f64| {
        let normal = DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
        sphere_irradiance(DVec3::Z * d - normal * r1, normal, r2)
    };
    let sum: f64 = (0..=STEPS)
        .map(|i| {
            let weight = if i == 0 || i == STEPS { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
            weight * at(2.0 * f64::from(i) / f64::from(STEPS) - 1.0)
        })
        .sum();
    sum * (2.0 / f64::from(STEPS)) / 3.0 / (2.0 * PI)
}

/// Radiance of the inner and the outer of two concentric spheres that face each other, of the inner's `area` relative
/// to the outer's: the solution of `B₁ = e₁ + ρ₁ B₂`, `B₂ = e₂ + ρ₂ (F B₁ + (1 - F) B₂)` with `F` that area.
pub(crate) fn concentric_spheres(area: f64, emission: [f64; 2], reflectance: [f64; 2]) -> [f64; 2] {
    let ([e1, e2], [rho1, rho2]) = (emission, reflectance);
    let outer = (e2 + rho2 * area * e1) / (1.0 - rho2 * (1.0 - area) - rho2 * area * rho1);
    [e1 + rho1 * outer, outer]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: f64, expected: f64, tolerance: f64) {
        assert!((value - expected).abs() <= tolerance * expected.abs(), "{value}, not {expected}");
    }

    /// ∫ L cos θ dω over the hemisphere about z by the midpoint rule in sin² θ and φ, where the cosine is the density.
    fn quadrature(radiance: impl Fn(DVec3) -> f64) -> f64 {
        const RINGS: u32 = 1500;
        const SECTORS: u32 = 3000;
        let middle = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
        let ring = |j: u32| -> f64 {
            let sin_squared = middle(j, RINGS);
            let (sin, cos) = (sin_squared.sqrt(), (1.0 - sin_squared).sqrt());
            let at = |k: u32| {
                let phi = 2.0 * PI * middle(k, SECTORS);
                radiance(DVec3::new(sin * phi.cos(), sin * phi.sin(), cos))
            };
            (0..SECTORS).map(at).sum()
        };
        PI * (0..RINGS).map(ring).sum::<f64>() / f64::from(RINGS * SECTORS)
    }

    #[test]
    fn furnaces_are_the_sums_of_their_bounces() {
        let mut sum = 0.0;
        for bounces in 0..60 {
            sum += 1.5 * 0.7f64.powi(bounces);
            near(furnace_after(1.5, 0.7, bounces as u32), sum, 1e-12);
        }
        near(furnace(1.5, 0.7), sum, 1e-8);
    }

    /// A path of `n` surfaces has the value `Σ (ρ/p)^i` and the probability `p^{n-1} (1 - p)`.
    #[test]
    fn roulette_has_the_variance_of_the_lengths_of_paths() {
        for (rho, p) in [(0.5, 0.3), (0.5, 0.5), (0.5, 0.8), (0.5, 0.95), (0.2, 0.5), (0.9, 0.85)] {
            let (mut mean, mut square, mut value, mut term, mut probability) = (0.0, 0.0, 0.0, 1.0, 1.0);
            for _ in 0..500 {
                value += term;
                mean += probability * (1.0 - p) * value;
                square += probability * (1.0 - p) * value * value;
                (term, probability) = (term * rho / p, probability * p);
            }
            near(mean, furnace(1.0, rho), 1e-9);
            near(roulette_variance(1.0, rho, p), square - mean * mean, 1e-6);
        }
        near(roulette_variance(1.0, 0.5, 0.3), 14.0, 1e-12);
        near(roulette_variance(3.0, 0.5, 0.5), 9.0 * 2.0, 1e-12);
        assert_eq!(roulette_variance(1.0, 0.5, 0.25), f64::INFINITY);
        assert_eq!(roulette_variance(1.0, 0.5, 0.2), f64::INFINITY);
    }

    /// High above the horizon, low, cut by it above and below the centre, and wholly beneath.
    #[test]
    fn spheres_are_worth_what_they_cover() {
        for angle in [0.0f64, 40.0, 70.0, 80.0, 90.0, 100.0, 130.0] {
            let (angle, radius) = (angle.to_radians(), 0.4);
            let to_centre = 1.3 * DVec3::new(angle.sin(), 0.0, angle.cos());
            let covers = |direction: DVec3| {
                let along = direction.dot(to_centre);
                along > 0.0 && (to_centre - direction * along).length() < radius
            };
            let expected = quadrature(|direction| f64::from(u8::from(covers(direction))));
            let value = sphere_irradiance(to_centre, DVec3::Z, radius);
            assert!((value - expected).abs() < 1e-3 * expected + 1e-5, "{angle}: {value}, not {expected}");
        }
    }

    /// A small sphere is a point light of intensity `π R²`.
    #[test]
    fn points_are_the_limit_of_spheres() {
        let to_light = DVec3::new(1.0, 2.0, 3.0);
        let normal = DVec3::new(0.6, 0.0, 0.8);
        near(PI * 1e-6 * point_irradiance(to_light, normal), sphere_irradiance(to_light, normal, 1e-3), 1e-12);
        assert_eq!(point_irradiance(-to_light, normal), 0.0);
    }

    #[test]
    fn polygons_are_worth_their_surface_integral() {
        let [a, b, c] = [[-0.4, 0.1, 0.9], [0.5, 1.2, 1.6], [1.3, -0.7, 0.8]].map(DVec3::from);
        let (point, normal) = (DVec3::new(0.3, -0.2, 0.1), DVec3::new(0.2, -0.3, 1.0).normalize());
        let (across, down) = (b - a, c - a);
        let cross = across.cross(down);
        const STEPS: u32 = 1000;
        let mut sum = 0.0;
        for i in 0..STEPS {
            for j in 0..STEPS - i {
                // The two halves of a small parallelogram, of which the diagonal has one.
                for (third, inside) in [(1.0, true), (2.0, i + j + 1 < STEPS)] {
                    let [u, v] = [i, j].map(|k| (f64::from(k) + third / 3.0) / f64::from(STEPS));
                    let ray = a + across * u + down * v - point;
                    let cosines = ray.dot(normal) * ray.dot(cross.normalize()).abs();
                    sum += if inside { cosines / ray.length().powi(4) } else { 0.0 };
                }
            }
        }
        let expected = sum * 0.5 * cross.length() / f64::from(STEPS).powi(2);
        near(polygon_irradiance(point, normal, &[a, b, c]).abs(), expected, 1e-5);
        near(polygon_irradiance(point, normal, &[a, b, c]), -polygon_irradiance(point, normal, &[c, b, a]), 1e-12);
    }

    #[test]
    fn walls_hide_what_they_cover() {
        for (a, h) in [(0.1, 1.0), (1.0, 1.0), (3.0, 0.5)] {
            let open = |direction: DVec3| direction.x <= 0.0 || direction.z / direction.x > h / a;
            let seen = |direction: DVec3| f64::from(u8::from(open(direction)));
            near(sky_beside_wall(a, h), quadrature(seen), 1e-3);
            // A ray of density d counts cos θ/(π d): cosine-weighted means of its square over d.
            let mean = quadrature(seen) / PI;
            near(openness_variance(a, h), mean - mean * mean, 2e-3);
            let square = quadrature(|direction| 2.0 * direction.z * seen(direction)) / PI;
            near(uniform_openness_variance(a, h), square - mean * mean, 2e-3);
        }
    }

    /// Far apart a sphere sees `r₂²/(4 d²)` of the other, near by more; and what one sends the other gets.
    #[test]
    fn form_factors_of_spheres_are_reciprocal() {
        near(sphere_form_factor(1.0, 1.0, 100.0), 0.25e-4, 1e-3);
        for (r1, r2, d) in [(1.0, 0.3, 1.4), (1.0, 1.0, 2.1), (0.5, 2.0, 3.0)] {
            near(r1 * r1 * sphere_form_factor(r1, r2, d), r2 * r2 * sphere_form_factor(r2, r1, d), 1e-6);
        }
        // Two equal spheres that all but touch: 0.0756 (Juul, "On the prediction of radiation view factors between
        // spheres", 1976).
        near(sphere_form_factor(1.0, 1.0, 2.0 + 1e-6), 0.0756, 2e-3);
    }

    #[test]
    fn concentric_spheres_agree_with_their_bounces() {
        let (area, emission, reflectance) = (0.25, [1.0, 0.2], [0.6, 0.9]);
        let mut sum = emission;
        for _ in 0..500 {
            let received = [sum[1], area * sum[0] + (1.0 - area) * sum[1]];
            sum = [0, 1].map(|i| emission[i] + reflectance[i] * received[i]);
        }
        let [inner, outer] = concentric_spheres(area, emission, reflectance);
        near(inner, sum[0], 1e-12);
        near(outer, sum[1], 1e-12);
        assert_eq!(concentric_spheres(1.0, [0.5, 0.5], [0.5, 0.5]), [1.0, 1.0]);
    }
}
