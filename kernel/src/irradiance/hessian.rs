//! The translational Hessian of irradiance, and the ellipse in which a record may be used for it.
//!
//! Where gradients are used, the next term is the error: ½ Δxᵀ H Δx. With the radii
//!
//! (R_1, R_2) = (4 ε E / π)^¼ (|λ_1|^-¼, |λ_2|^-¼)
//!
//! along the eigenvectors of H it is ε E if integrated over a circle, and a quarter more over an ellipse twice as long
//! as it is wide
//! (Jarosz, Schönefeld, Kobbelt and Jensen, "Theory, analysis and applications of 2D global illumination", 2012;
//! Schwarzhaupt, Wann Jensen and Jarosz, "Practical Hessian-based error control for irradiance caching", 2012).

use core::f32::consts::PI;

use glam::Vec3;

use crate::sampling::Frame;

/// The second derivatives of the luminance of irradiance along the tangent plane, in local coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hessian {
    /// ∂²E/∂x², in W/m² a square world unit.
    pub xx: f32,
    /// ∂²E/∂x∂y.
    pub xy: f32,
    /// ∂²E/∂y².
    pub yy: f32,
    /// The luminance of E, in W/m², of the same light; π where all is black, for then the light is 1 everywhere.
    pub irradiance: f32,
}

/// The ellipse in which a record may be used: two directions of the tangent plane, each with a radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Unit vectors along which the radii are; orthogonal.
    pub axes: [Vec3; 2],
    /// The radii in world units, the smaller one first; +∞ where irradiance has no second derivative.
    pub radii: [f32; 2],
}

impl Hessian {
    /// The eigenvalues with their eigenvectors, orthogonal unit vectors of the tangent plane in local coordinates; the
    /// one of greater magnitude first. Of equal eigenvalues the vectors are x and y.
    pub fn eigen(&self) -> [(f32, Vec3); 2] {
        let (mean, half) = (0.5 * (self.xx + self.yy), 0.5 * (self.xx - self.yy));
        let radius = libm::hypotf(half, self.xy);
        if radius == 0.0 {
            return [(mean, Vec3::X), (mean, Vec3::Y)];
        }
        // Of the two forms of the eigenvector to mean + radius, that in which nothing cancels.
        let (x, y) = if half >= 0.0 { (half + radius, self.xy) } else { (self.xy, radius - half) };
        let length = libm::hypotf(x, y);
        let axis = Vec3::new(x / length, y / length, 0.0);
        let across = Vec3::new(-axis.y, axis.x, 0.0);
        let (upper, lower) = ((mean + radius, axis), (mean - radius, across));
        if mean >= 0.0 { [upper, lower] } else { [lower, upper] }
    }

    /// The ellipse over which extrapolation by the gradient errs by about `error` times E, integrated; at most twice as
    /// long as it is wide. Where H is zero both radii are +∞, and where E is zero but H is not they are zero.
    ///
    /// As it bounds an integral, `error` is a relative error times an area: it grows with the square of the scene's
    /// scale.
    pub fn radii(&self, error: f32) -> Ellipse {
        let [(greater, axis), (lesser, across)] = self.eigen();
        let radius = |eigenvalue: f32| {
            let eigenvalue = eigenvalue.abs();
            // Divided first: the quotient of two numbers of one scale neither overflows nor vanishes.
            if eigenvalue == 0.0 { f32::INFINITY } else { root4(4.0 / PI * error * (self.irradiance / eigenvalue)) }
        };
        let short = radius(greater);
        Ellipse { axes: [axis, across], radii: [short, radius(lesser).min(MAX_ANISOTROPY * short)] }
    }
}

/// How much longer than wide an ellipse may be.
const MAX_ANISOTROPY: f32 = 2.0;

fn root4(x: f32) -> f32 {
    libm::sqrtf(libm::sqrtf(x))
}

impl Ellipse {
    /// The ellipse in world coordinates.
    pub fn to_world(&self, frame: &Frame) -> Self {
        Self { axes: self.axes.map(|axis| frame.to_world(axis)), ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hessian(xx: f32, xy: f32, yy: f32) -> Hessian {
        Hessian { xx, xy, yy, irradiance: 2.0 }
    }

    #[test]
    fn eigenvectors_are_stretched_by_their_eigenvalues() {
        for h in [
            hessian(1.0, 0.0, 0.0),
            hessian(0.0, 0.0, -3.0),
            hessian(0.0, 1e-3, 0.0),
            hessian(2.0, 0.5, -7.0),
            hessian(-2.0, -0.5, 2.0),
            hessian(1.0, 1e-6, 1.0),
            hessian(1e-12, 3e-12, 5e-12),
        ] {
            let [(first, v1), (second, v2)] = h.eigen();
            assert!(first.abs() >= second.abs(), "{h:?}");
            assert!(v1.dot(v2).abs() < 1e-7 && (v1.length() - 1.0).abs() < 1e-6 && v1.z == 0.0 && v2.z == 0.0);
            for (value, v) in [(first, v1), (second, v2)] {
                let stretched = Vec3::new(h.xx * v.x + h.xy * v.y, h.xy * v.x + h.yy * v.y, 0.0);
                assert!((stretched - value * v).length() <= 2e-6 * first.abs(), "{h:?}: {stretched} {value} {v}");
            }
        }
    }

    #[test]
    fn radii_of_known_eigenvalues() {
        // (4 ε E / π)^¼ = 1 with ε = π/8 and E = 2: a radius is |λ|^-¼.
        let ellipse = hessian(0.0625, 0.0, -1.0).radii(PI / 8.0);
        assert_eq!(ellipse.axes[0].abs(), Vec3::Y);
        assert!((ellipse.radii[0] - 1.0).abs() < 1e-6 && (ellipse.radii[1] - 2.0).abs() < 1e-6);
        // An eigenvalue 81 times as small would be three times as far.
        assert_eq!(hessian(1.0, 0.0, 1.0 / 81.0).radii(PI / 8.0).radii[1], 2.0);
        assert_eq!(hessian(1.0, 0.0, 0.0).radii(PI / 8.0).radii, [1.0, 2.0]);
        assert_eq!(hessian(0.0, 0.0, 0.0).radii(0.1).radii, [f32::INFINITY; 2]);
    }

    #[test]
    fn ellipses_turn_with_the_frame() {
        let frame = Frame::from_normal(Vec3::Y);
        let ellipse = hessian(1.0, 0.0, 0.5).radii(1.0);
        let turned = ellipse.to_world(&frame);
        assert_eq!((turned.axes, turned.radii), ([frame.tangent, frame.bitangent], ellipse.radii));
    }
}
