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
use super::accumulate::{Above, LEAST_DISTANCE, Samples, sum};
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

/// A vertex: where it is, and how bright.
#[derive(Clone, Copy)]
struct Point {
    direction: Vec3,
    inverse: f32,
    luminance: f32,
}

impl Points<'_> {
    #[inline(always)]
    fn cell(&self, cell: usize) -> Point {
        let distance = self.samples.distance[cell];
        let distance = if distance > LEAST_DISTANCE { distance } else { LEAST_DISTANCE };
        let luminance = self.samples.radiance[cell].dot(LUMINANCE);
        Point { direction: self.directions[cell], inverse: 1.0 / distance, luminance }
    }

    /// The mean of a ring's points, at the zenith.
    fn zenith(&self, patch: &Patch) -> Point {
        let (mut inverse, mut luminance) = (0.0, 0.0);
        for cell in patch.first..patch.first + patch.columns {
            let point = self.cell(cell);
            inverse += point.inverse;
            luminance += point.luminance;
        }
        let count = patch.columns as f32;
        Point { direction: Vec3::Z, inverse: inverse / count, luminance: luminance / count }
    }
}

/// Eight vertices.
#[derive(Clone, Copy)]
struct Vertices<L> {
    direction: [L; 3],
    inverse: L,
    luminance: L,
}

/// Eight vertices of a row and those after each of them.
#[derive(Clone, Copy)]
struct Row<L>([Vertices<L>; 2]);

impl<L: Lanes<8>> Row<L> {
    /// The first `count` lanes from nine points, lane `k` and the one after it.
    #[inline(always)]
    fn new(points: &[Point; 9], count: usize) -> Self {
        let mut rows = [[[0.0; 8]; 5]; 2];
        for (after, parts) in rows.iter_mut().enumerate() {
            for lane in 0..count {
                let Point { direction, inverse, luminance } = points[lane + after];
                (parts[0][lane], parts[1][lane], parts[2][lane]) = (direction.x, direction.y, direction.z);
                (parts[3][lane], parts[4][lane]) = (inverse, luminance);
            }
        }
        Self([Vertices::load(&rows[0]), Vertices::load(&rows[1])])
    }
}

impl<L: Lanes<8>> Vertices<L> {
    #[inline(always)]
    fn load([x, y, z, inverse, luminance]: &[[f32; 8]; 5]) -> Self {
        Self {
            direction: [L::load(x), L::load(y), L::load(z)],
            inverse: L::load(inverse),
            luminance: L::load(luminance),
        }
    }
}

impl Patch {
    #[inline(always)]
    fn add<L: Lanes<8>>(&self, points: &Points, light: &mut Terms<L>, base: &mut Terms<L>) {
        let quads = if self.band { self.columns } else { self.columns - 1 };
        let zenith = points.zenith(self);
        let orientation = L::splat(if self.band { 1.0 } else { -1.0 });
        for first in (0..quads).step_by(8) {
            let count = 8.min(quads - first);
            let mut corners = [zenith; 9];
            for (k, corner) in corners[..=count].iter_mut().enumerate() {
                if let Some(cell) = self.above.cell((first + k) % self.columns) {
                    *corner = points.cell(cell);
                }
            }
            let mut upper = Row::new(&corners, count);
            for row in 0..self.rows {
                let start = self.first + row * self.columns;
                for (k, corner) in corners[..=count].iter_mut().enumerate() {
                    let column = if first + k == self.columns { 0 } else { first + k };
                    *corner = points.cell(start + column);
                }
                let lower = Row::new(&corners, count);
                if self.band || row > 0 {
                    *light = light.add_quads(&upper, &lower, orientation);
                }
                upper = lower;
            }
            if self.band {
                for corner in &mut corners[..=count] {
                    *corner = drop_to_horizon(*corner);
                }
                *light = light.add_quads(&upper, &Row::new(&corners, count), orientation);
                *base = base.add(L::splat(1.0), &Terms::edge(&upper.0[0], &upper.0[1]));
            }
        }
    }
}

/// The point moved along the normal onto the tangent plane.
fn drop_to_horizon(point: Point) -> Point {
    let Vec3 { x, y, .. } = point.direction;
    let sine = libm::sqrtf(x * x + y * y).max(f32::MIN_POSITIVE);
    Point { direction: Vec3::new(x / sine, y / sine, 0.0), inverse: point.inverse / sine, ..point }
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
    fn add_quads(&self, upper: &Row<L>, lower: &Row<L>, orientation: L) -> Self {
        let (Row([a, b]), Row([d, c])) = (upper, lower);
        let (plus, minus) = (L::splat(1.0), L::splat(-1.0));
        let diagonal = Self::edge(a, c);
        let first = Self::edge(a, d).add(plus, &Self::edge(d, c)).add(minus, &diagonal);
        let second = diagonal.add(plus, &Self::edge(c, b)).add(plus, &Self::edge(b, a));
        self.add(orientation * farthest(a, d, c), &first).add(orientation * farthest(a, c, b), &second)
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
