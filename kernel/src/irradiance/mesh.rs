//! The Hessian of a mesh of small lights, in lanes.
//!
//! Neighbouring hit points make triangles, and each triangle is a polygon light with the radiance of its farthest
//! vertex: what is nearer hides the light behind it, so that the edges of occluders are where the lights' edges are
//! (Schwarzhaupt, Wann Jensen and Jarosz 2012).
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
//! infinitely far. Gauss and Legendre's rule with two nodes integrates them, for neighbours are less than half a radian
//! apart; |v|² is the same at both nodes.
//!
//! # Deviations
//! The mesh is closed: the first ring's triangles meet in a point at the zenith, and the last ring's points are dropped
//! onto the tangent plane. So light that is the same everywhere has the Hessian zero, without the mean being subtracted.
//! The hundredth of the mean radiance that is added to each triangle (1 where all is black) ends at the last ring, as
//! published: it would have no Hessian if it did not.

use core::f32::consts::PI;

use glam::Vec3;

use super::Hessian;
use super::accumulate::{Above, Samples, bound, bound_lanes, sum};
use crate::simd::{Isa, Lanes, Simd, Work, dispatch};

/// Luminance of linear Rec. 709 radiance.
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);
/// The part of the mean radiance that is added to every light.
const BASE: f32 = 0.01;
/// The nodes of Gauss and Legendre's rule: ½ ± √3/6.
const NODES: [f32; 2] = [0.211_324_87, 0.788_675_1];
/// s (1 - s) at the nodes.
const NODE_PRODUCT: f32 = 1.0 / 6.0;

/// Points in rows and columns. Rows follow each other away from the zenith and columns with the azimuth, or the other
/// way round both ways.
#[derive(Clone, Copy)]
pub(super) struct Patch {
    pub(super) first: usize,
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Whether the patch goes around the zenith down to the horizon, with the last column beside the first. Else it
    /// is a rectangle of its own, with columns against the azimuth.
    pub(super) band: bool,
    /// What a band starts from.
    pub(super) above: Above,
}

/// The Hessian of the patches of a layout.
pub(super) fn hessian<const N: usize>(isa: Isa, patches: [Patch; N], directions: &[Vec3], samples: Samples) -> Hessian {
    dispatch(isa, Triangulate { patches, points: Points { directions, samples } })
}

struct Triangulate<'a, const N: usize> {
    patches: [Patch; N],
    points: Points<'a>,
}

impl<const N: usize> Work for Triangulate<'_, N> {
    type Output = Hessian;
    #[inline(always)]
    fn run<S: Simd>(self) -> Hessian {
        let (mut light, mut base) = (Terms::<S::F8>::zero(), Terms::zero());
        for patch in &self.patches {
            patch.add(&self.points, &mut light, &mut base);
        }
        let (irradiance, light) = light.total();
        let (_, base) = base.total();
        let (irradiance, ambient) = if irradiance > 0.0 { (irradiance, BASE / PI * irradiance) } else { (PI, 1.0) };
        Hessian {
            xx: light[0] + ambient * base[0],
            xy: light[1] + ambient * base[1],
            yy: light[2] + ambient * base[2],
            irradiance,
        }
    }
}

/// The hit points.
struct Points<'a> {
    directions: &'a [Vec3],
    samples: Samples<'a>,
}

/// Nine neighbours in a row, the ends of eight edges: x, y and z of their directions, distances and luminances.
#[derive(Clone, Copy)]
struct Corners([[f32; 9]; 5]);

impl Corners {
    #[inline(always)]
    fn set(&mut self, k: usize, direction: Vec3, distance: f32, luminance: f32) {
        (self.0[0][k], self.0[1][k], self.0[2][k]) = direction.into();
        (self.0[3][k], self.0[4][k]) = (distance, luminance);
    }

    /// Sets the first `count` to those of the cells that `cell` numbers.
    #[inline(always)]
    fn read(&mut self, points: &Points, count: usize, cell: impl Fn(usize) -> usize) {
        for k in 0..count.min(9) {
            let cell = cell(k);
            let luminance = points.samples.radiance[cell].dot(LUMINANCE);
            self.set(k, points.directions[cell], points.samples.distance[cell], luminance);
        }
    }

    /// All at the zenith, in the mean of the points of a patch's first row.
    fn zenith(points: &Points, patch: &Patch) -> Self {
        let row = patch.first..patch.first + patch.columns;
        let inverses = points.samples.distance[row.clone()].iter().map(|&distance| 1.0 / bound(distance));
        let luminances = points.samples.radiance[row].iter().map(|radiance| radiance.dot(LUMINANCE));
        let count = patch.columns as f32;
        let (distance, luminance) = (count / inverses.sum::<f32>(), luminances.sum::<f32>() / count);
        let mut corners = Self([[0.0; 9]; 5]);
        for k in 0..9 {
            corners.set(k, Vec3::Z, distance, luminance);
        }
        corners
    }

    /// Moves the points along the normal onto the tangent plane.
    #[inline(always)]
    fn drop_to_horizon(&mut self) {
        let [x, y, z, distance, _] = &mut self.0;
        for k in 0..9 {
            let sine = libm::sqrtf(x[k] * x[k] + y[k] * y[k]).max(f32::MIN_POSITIVE);
            (x[k], y[k], z[k]) = (x[k] / sine, y[k] / sine, 0.0);
            distance[k] *= sine;
        }
    }

    /// In lanes: the eight that edges come from, and the eight that they go to.
    #[inline(always)]
    fn lanes<L: Lanes<8>>(&self) -> [Vertices<L>; 2] {
        [self.lanes_from::<0, L>(), self.lanes_from::<1, L>()]
    }

    #[inline(always)]
    fn lanes_from<const FIRST: usize, L: Lanes<8>>(&self) -> Vertices<L> {
        let [x, y, z, distance, luminance] = &self.0;
        Vertices {
            direction: [eight::<FIRST, L>(x), eight::<FIRST, L>(y), eight::<FIRST, L>(z)],
            inverse: L::splat(1.0) / bound_lanes(eight::<FIRST, L>(distance)),
            luminance: eight::<FIRST, L>(luminance),
        }
    }
}

/// Eight of nine.
#[inline(always)]
fn eight<const FIRST: usize, L: Lanes<8>>(values: &[f32; 9]) -> L {
    let mut lanes = [0.0; 8];
    lanes.copy_from_slice(&values[FIRST..FIRST + 8]);
    L::load(&lanes)
}

/// Eight vertices.
#[derive(Clone, Copy)]
struct Vertices<L> {
    direction: [L; 3],
    inverse: L,
    luminance: L,
}

impl Patch {
    #[inline(always)]
    fn add<L: Lanes<8>>(&self, points: &Points, light: &mut Terms<L>, base: &mut Terms<L>) {
        let quads = if self.band { self.columns } else { self.columns - 1 };
        let zenith = Corners::zenith(points, self);
        for first in (0..quads).step_by(8) {
            let count = 8.min(quads - first);
            // Lanes past the last quad weigh nothing, whatever their corners are.
            let mut weights = [0.0; 8];
            weights[..count].fill(if self.band { 1.0 } else { -1.0 });
            let weights = L::load(&weights);
            let column = |k: usize| if first + k == self.columns { 0 } else { first + k };
            let mut corners = zenith;
            if let Above::Rim(_) = self.above {
                corners.read(points, count + 1, |k| self.above.cell(column(k)).unwrap_or(0));
            }
            let mut upper = corners.lanes();
            for row in 0..self.rows {
                let start = self.first + row * self.columns;
                if count == 8 && first + 8 < self.columns {
                    corners.read(points, 9, |k| start + first + k);
                } else {
                    corners.read(points, count + 1, |k| start + column(k));
                }
                let lower = corners.lanes();
                if self.band || row > 0 {
                    *light = light.add_quads(&upper, &lower, weights);
                }
                upper = lower;
            }
            if self.band {
                corners.drop_to_horizon();
                *light = light.add_quads(&upper, &corners.lanes(), weights);
                *base = base.add(weights, &Terms::edge(&upper[0], &upper[1]));
            }
        }
    }
}

/// Irradiance and Hessian, eight of each: what edges add for unit radiance, or sums of it.
#[derive(Clone, Copy)]
struct Terms<L> {
    irradiance: L,
    hessian: [L; 3],
}

impl<L: Lanes<8>> Terms<L> {
    #[inline(always)]
    fn zero() -> Self {
        Self { irradiance: L::splat(0.0), hessian: [L::splat(0.0); 3] }
    }

    /// Those of eight edges.
    #[inline(always)]
    fn edge(from: &Vertices<L>, to: &Vertices<L>) -> Self {
        let ([x0, y0, z0], [x1, y1, z1]) = (from.direction, to.direction);
        let (one, two, four) = (L::splat(1.0), L::splat(2.0), L::splat(4.0));
        let kappa = x0 * y1 - y0 * x1;
        let (g_x, g_y) = (from.inverse * x1 - to.inverse * x0, from.inverse * y1 - to.inverse * y0);
        let cosine = x0 * x1 + y0 * y1 + z0 * z1;
        // 1/|v|², as |v|² = 1 - 2 s (1 - s) (1 - cos).
        let u = one / (one - L::splat(2.0 * NODE_PRODUCT) * (one - cosine));
        let (mut xx, mut xy, mut yy) = (L::splat(0.0), L::splat(0.0), L::splat(0.0));
        for node in NODES {
            let (s, t) = (L::splat(node), L::splat(1.0 - node));
            let (v_x, v_y, w) = (t * x0 + s * x1, t * y0 + s * y1, t * from.inverse + s * to.inverse);
            let (w_kappa, four_u) = (w * kappa, four * u);
            xx = xx + w * (w_kappa * (four_u * v_x * v_x - one) - two * g_y * v_x);
            xy = xy + w * (w_kappa * (four_u * v_x * v_y) + g_x * v_x - g_y * v_y);
            yy = yy + w * (w_kappa * (four_u * v_y * v_y - one) + two * g_x * v_y);
        }
        // Each node has the weight ½.
        let weight = L::splat(0.5) * u * u;
        Self { irradiance: L::splat(0.5) * kappa * u, hessian: [weight * xx, weight * xy, weight * yy] }
    }

    /// `self + factor * other`.
    #[inline(always)]
    fn add(&self, factor: L, other: &Self) -> Self {
        let mut sum = *self;
        sum.irradiance = sum.irradiance + factor * other.irradiance;
        for k in 0..3 {
            sum.hessian[k] = sum.hessian[k] + factor * other.hessian[k];
        }
        sum
    }

    /// With the triangles of the quads between two rows added: a, d, c and a, c, b, where a and b are above d and c.
    #[inline(always)]
    fn add_quads(&self, upper: &[Vertices<L>; 2], lower: &[Vertices<L>; 2], weights: L) -> Self {
        let ([a, b], [d, c]) = (upper, lower);
        let (plus, minus) = (L::splat(1.0), L::splat(-1.0));
        let diagonal = Self::edge(a, c);
        let first = Self::edge(a, d).add(plus, &Self::edge(d, c)).add(minus, &diagonal);
        let second = diagonal.add(plus, &Self::edge(c, b)).add(plus, &Self::edge(b, a));
        self.add(weights * farthest(a, d, c), &first).add(weights * farthest(a, c, b), &second)
    }

    /// The sums of the lanes: of the irradiance, and of xx, xy and yy.
    #[inline(always)]
    fn total(&self) -> (f32, [f32; 3]) {
        let [xx, xy, yy] = self.hessian;
        (sum(self.irradiance), [sum(xx), sum(xy), sum(yy)])
    }
}

/// The luminance of the farthest of three vertices.
#[inline(always)]
fn farthest<L: Lanes<8>>(a: &Vertices<L>, b: &Vertices<L>, c: &Vertices<L>) -> L {
    let b_is_farther = b.inverse.lt(a.inverse);
    let (inverse, luminance) =
        (L::select(b_is_farther, b.inverse, a.inverse), L::select(b_is_farther, b.luminance, a.luminance));
    L::select(c.inverse.lt(inverse), c.luminance, luminance)
}
