//! Irradiance of uniform lights with its exact derivatives, in `f64`: polygons and spheres, unoccluded and above the
//! receiver's horizon.
//!
//! A polygon's irradiance is the sum over its edges r → r' of (L/2) (n·c) I1, with e = r' - r, c = r × r' and
//!
//! ```text
//! I1 = ∫ dt / |r + te|²,   I2 = ∫ dt / |r + te|⁴,    J2 = ∫ t dt / |r + te|⁴,
//! I3 = ∫ dt / |r + te|⁶,   J3 = ∫ t dt / |r + te|⁶,  K3 = ∫ t² dt / |r + te|⁶
//! ```
//!
//! from 0 to 1, all of them in closed form. Differentiating it with respect to the receiver's place gives the gradient
//! and the Hessian.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

/// Irradiance and its derivatives with respect to the place of the receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derivatives {
    /// E.
    pub irradiance: f64,
    /// ∇E.
    pub gradient: DVec3,
    /// ∇∇E.
    pub hessian: DMat3,
}

impl Derivatives {
    /// The derivatives of no light.
    pub const ZERO: Self = Self { irradiance: 0.0, gradient: DVec3::ZERO, hessian: DMat3::ZERO };
}

/// Of the polygon light of unit radiance with these corners, anticlockwise as seen from the receiver at `x` with the
/// unit normal `n`. Negative if they are clockwise.
pub fn polygon(corners: &[DVec3], x: DVec3, n: DVec3) -> Derivatives {
    let ends = corners.iter().zip(corners.iter().cycle().skip(1));
    ends.fold(Derivatives::ZERO, |mut sum, (&v0, &v1)| {
        let edge = edge(v0 - x, v1 - x, n);
        sum.irradiance += edge.irradiance;
        sum.gradient += edge.gradient;
        sum.hessian += edge.hessian;
        sum
    })
}

fn edge(r: DVec3, r1: DVec3, n: DVec3) -> Derivatives {
    let (e, c) = (r1 - r, r.cross(r1));
    let (c2, e2, inverse, inverse1) =
        (c.length_squared(), e.length_squared(), 1.0 / r.length_squared(), 1.0 / r1.length_squared());
    // An edge that is a point, or seen end on, is no edge.
    if c2 == 0.0 {
        return Derivatives::ZERO;
    }
    let (along, along1) = (e.dot(r), e.dot(r1));
    let i1 = c.length().atan2(r.dot(r1)) / c.length();
    let i2 = (along1 * inverse1 - along * inverse + e2 * i1) / (2.0 * c2);
    let j2 = (0.5 * (inverse - inverse1) - along * i2) / e2;
    let i3 = (along1 * inverse1 * inverse1 - along * inverse * inverse + 3.0 * e2 * i2) / (4.0 * c2);
    let j3 = (inverse * inverse - inverse1 * inverse1) / (4.0 * e2) - along * i3 / e2;
    let k3 = (i2 - i3 / inverse - 2.0 * along * j3) / e2;
    let (normal_part, turned) = (n.dot(c), n.cross(e));
    let squares = i3 * outer(r, r) + j3 * symmetric(r, e) + k3 * outer(e, e);
    Derivatives {
        irradiance: 0.5 * normal_part * i1,
        gradient: 0.5 * (i1 * turned + 2.0 * normal_part * (i2 * r + j2 * e)),
        hessian: symmetric(turned, i2 * r + j2 * e)
            + normal_part * (4.0 * squares - DMat3::from_diagonal(DVec3::splat(i2))),
    }
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

fn symmetric(a: DVec3, b: DVec3) -> DMat3 {
    outer(a, b) + outer(b, a)
}

/// Irradiance and gradient of the sphere light of unit radiance with this centre and radius.
pub fn sphere(centre: DVec3, radius: f64, x: DVec3, n: DVec3) -> (f64, DVec3) {
    let d = centre - x;
    let (cube, fifth) = (d.length().powi(3), d.length().powi(5));
    let area = PI * radius * radius;
    (area * n.dot(d) / cube, area * (3.0 * n.dot(d) / fifth * d - n / cube))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Pcg;

    /// A random quad above z = 0.1, anticlockwise as seen from the origin.
    fn quad(random: &mut Pcg) -> [DVec3; 4] {
        loop {
            let centre = 2.0 * random.in_cube() + 3.0 * DVec3::Z;
            let (a, b) = (random.on_sphere(), random.on_sphere());
            let corners = [centre + a, centre + b, centre - a, centre - b];
            if corners.iter().all(|corner| corner.z > 0.1) {
                let facing = (corners[1] - corners[0]).cross(corners[2] - corners[1]).dot(centre);
                return if facing > 0.0 { corners } else { [corners[3], corners[2], corners[1], corners[0]] };
            }
        }
    }

    #[test]
    fn a_square_overhead_has_its_form_factor() {
        // A square of side 2 at height 1: four times the corner's factor of a unit square, 1/(2π)·2·(1/√2) atan(1/√2).
        let corners = [(1., 1.), (-1., 1.), (-1., -1.), (1., -1.)].map(|(x, y)| DVec3::new(x, y, 1.0));
        let square = polygon(&corners, DVec3::ZERO, DVec3::Z);
        let root = 0.5f64.sqrt();
        assert!((square.irradiance - 4.0 * root * root.atan()).abs() < 1e-12);
        assert!(square.gradient.truncate().length() < 1e-12);
        assert!((square.hessian.x_axis.x - square.hessian.y_axis.y).abs() < 1e-12 && square.hessian.x_axis.x < 0.0);
    }

    #[test]
    fn derivatives_are_those_of_the_irradiance() {
        let mut random = Pcg::new(4);
        let step = 1e-3;
        for _ in 0..200 {
            let corners = quad(&mut random);
            let at = |x: DVec3| polygon(&corners, x, DVec3::Z);
            let exact = at(DVec3::ZERO);
            assert!(exact.irradiance > 0.0);
            for axis in DVec3::AXES {
                let (ahead, behind) = (at(axis * step), at(-axis * step));
                let gradient = (ahead.irradiance - behind.irradiance) / (2.0 * step);
                let hessian = (ahead.gradient - behind.gradient) / (2.0 * step);
                let nearest = corners.iter().map(|corner| corner.length()).fold(f64::MAX, f64::min);
                let tolerance = 1e-5 * (1.0 + nearest.powi(-4));
                assert!((gradient - exact.gradient.dot(axis)).abs() < tolerance, "{gradient} {exact:?}");
                assert!((hessian - exact.hessian * axis).length() < 10.0 * tolerance, "{hessian} {exact:?}");
            }
        }
    }

    #[test]
    fn a_small_far_polygon_is_like_a_sphere() {
        // A regular polygon that faces the receiver and has the area of the sphere's disc.
        let (centre, radius, sides) = (DVec3::new(3.0, -4.0, 12.0), 0.01, 24);
        let (tangent, bitangent) = centre.normalize().any_orthonormal_pair();
        let area_ratio = (0.5 * sides as f64 * (2.0 * PI / sides as f64).sin() / PI).sqrt();
        let corner = |k: usize| {
            let (sin, cos) = (2.0 * PI * k as f64 / sides as f64).sin_cos();
            centre + radius / area_ratio * (cos * tangent + sin * bitangent)
        };
        let corners: Vec<_> = (0..sides).map(corner).collect();
        let signed = polygon(&corners, DVec3::ZERO, DVec3::Z).irradiance;
        let (irradiance, gradient) = sphere(centre, radius, DVec3::ZERO, DVec3::Z);
        assert!((signed.abs() / irradiance - 1.0).abs() < 1e-5, "{signed} {irradiance}");
        let step = 1e-4;
        for axis in DVec3::AXES {
            let at = |x| sphere(centre, radius, x, DVec3::Z).0;
            let difference = (at(axis * step) - at(-axis * step)) / (2.0 * step);
            assert!((difference - gradient.dot(axis)).abs() < 1e-6 * gradient.length());
        }
    }
}
