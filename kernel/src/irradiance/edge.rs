//! Contributions of polygon lights' edges to irradiance and to its Hessian, in lanes.
//!
//! # The Hessian of an edge
//! The irradiance of a polygon light is an integral around it, and so are its derivatives. An edge goes from d_0/i_0 to
//! d_1/i_1: d are the unit directions of its ends, and i their reciprocal distances, zero for a miss. Along it, with
//! s from 0 to 1, v = (1 - s) d_0 + s d_1 is in the direction of a point at the reciprocal distance w/|v|, with
//! w = (1 - s) i_0 + s i_1. With g = i_0 d_1 - i_1 d_0 and κ = n·(d_0 × d_1) the edge adds to the irradiance and to
//! the Hessian
//!
//! ```text
//! L/2 ∫ κ ds / |v|²
//! L ∫ { w [(n × g) ⊗ v + v ⊗ (n × g)] / |v|⁴ + w² κ [4 v ⊗ v / |v|⁶ - 1/|v|⁴] } ds
//! ```
//!
//! These are the closed forms of polygon lights (Holzschuch and Sillion, "An exhaustive error-bounding algorithm for
//! hierarchical radiosity", 1998, derive such), written so that nothing is divided by what may vanish and points may be
//! infinitely far. Gauss and Legendre's rule with two nodes, s = ½ ± √3/6, integrates them, for neighbours are less
//! than half a radian apart.
//!
//! # The rule in terms of the ends
//! At both nodes |v|² = (2 + cos)/3, where cos = d_0·d_1. What is left are means over the nodes of p = w v, which is
//! quadratic, of its products, and of w². With P = i d at the ends, S = 2 P_0 + 2 P_1 + i_0 d_1 + i_1 d_0 and
//! D = 2 P_1 - 2 P_0 they are
//!
//! ```text
//! mean p     = S/6
//! mean p ⊗ p = (S ⊗ S + ¾ D ⊗ D)/36
//! mean w²    = (i_0² + i_0 i_1 + i_1²)/3
//! ```

use super::strip::sum;
use crate::simd::Lanes;

/// The ends of edges.
#[derive(Clone, Copy)]
pub(super) struct Ends<const N: usize, L> {
    direction: [L; 3],
    inverse: L,
    /// 2 P, x and y.
    doubled: [L; 2],
    /// i².
    squared: L,
}

impl<const N: usize, L: Lanes<N>> Ends<N, L> {
    /// The ends in these unit directions at these reciprocal distances.
    #[inline(always)]
    pub(super) fn new(direction: [L; 3], inverse: L) -> Self {
        let [x, y, _] = direction;
        let double = inverse + inverse;
        Self { direction, inverse, doubled: [double * x, double * y], squared: inverse * inverse }
    }
}

/// Sums over edges, in lanes: of irradiance times ⅔, and of the Hessian's xx, yy and doubled xy times ⅓.
#[derive(Clone, Copy)]
pub(super) struct Sums<const N: usize, L> {
    irradiance: L,
    hessian: [L; 3],
}

impl<const N: usize, L: Lanes<N>> Sums<N, L> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Self { irradiance: L::splat(0.0), hessian: [L::splat(0.0); 3] }
    }

    /// The sums with added edges, whose radiance to the left, seen from below, exceeds that to the right by these
    /// values.
    #[inline(always)]
    pub(super) fn add(&self, from: &Ends<N, L>, to: &Ends<N, L>, radiance: L) -> Self {
        let ([x0, y0, z0], [x1, y1, z1]) = (from.direction, to.direction);
        let (i0, i1) = (from.inverse, to.inverse);
        let kappa = x0 * y1 - y0 * x1;
        let ([x01, y01], [x10, y10]) = ([i0 * x1, i0 * y1], [i1 * x0, i1 * y0]);
        let (g_x, g_y) = (x01 - x10, y01 - y10);
        let s_x = from.doubled[0] + to.doubled[0] + (x01 + x10);
        let s_y = from.doubled[1] + to.doubled[1] + (y01 + y10);
        let (d_x, d_y) = (to.doubled[0] - from.doubled[0], to.doubled[1] - from.doubled[1]);
        let (e_x, e_y) = (L::splat(0.75) * d_x, L::splat(0.75) * d_y);
        let squares = from.squared + i0 * i1 + to.squared;
        let cosine = x0 * x1 + y0 * y1 + z0 * z1;
        let third = L::splat(1.0) / (L::splat(2.0) + cosine);
        let solid = kappa * third;
        let flat = kappa * squares;
        let xx = solid * (s_x * s_x + e_x * d_x) - flat - g_y * s_x;
        let yy = solid * (s_y * s_y + e_y * d_y) - flat + g_x * s_y;
        let xy = (solid + solid) * (s_x * s_y + e_x * d_y) + (g_x * s_x - g_y * s_y);
        let weight = radiance * third * third;
        Self {
            irradiance: self.irradiance + radiance * solid,
            hessian: [self.hessian[0] + weight * xx, self.hessian[1] + weight * yy, self.hessian[2] + weight * xy],
        }
    }

    /// The totals of all columns: irradiance, and xx, xy and yy.
    #[inline(always)]
    pub(super) fn total(all: &[Self]) -> (f32, [f32; 3]) {
        let hessian = |part: usize| sum(all.iter().map(|sums| sums.hessian[part]));
        let irradiance = sum(all.iter().map(|sums| sums.irradiance));
        (1.5 * irradiance, [3.0 * hessian(0), 1.5 * hessian(2), 3.0 * hessian(1)])
    }
}
