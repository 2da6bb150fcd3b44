//! Directional albedos of microfacet lobes, and from them the transmittance of layers, and the gain of light scattered
//! by a second microfacet.
//!
//! The albedo of a lobe depends on the cosine `μ` of `wo`, on roughness and on the refractive index. Tables hold it for
//! [`NODES`] cosines, [`ROUGHNESSES`] roughnesses and [`INDICES`] refractive indices. A [`Column`] of cosines is computed
//! once, over visible normals, when a closure first asks for it. A closure holds a [`Blend`] of some columns, which mixes two
//! nodes of each where it needs a cosine. As functions between nodes are linear, their integrals over all directions are exact
//! sums.

use std::array;
use std::sync::{LazyLock, OnceLock};

use glam::{Vec2, Vec3};

use super::fresnel;
use halfdome_kernel::sampling::r2;

use super::ggx::{Ggx, reflect};

/// Cosines of a column: `μ = (k/31)²`.
pub(super) const NODES: usize = 32;
const LAST: f32 = (NODES - 1) as f32;

/// A function of the cosine of a direction, linear in its square root between nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Column([f32; NODES]);

/// `∫ 2μ hat_k(μ) dμ` of the hat function about each node.
const WEIGHTS: [f32; NODES] = weights();

const fn weights() -> [f32; NODES] {
    // With μ = x²: ∫ 4x³ hat(x) dx; a piece from a to b = a + 1/31 has ∫ 4x³ (b - x) dx / (b - a) for its left node.
    let mut weights = [0.0f64; NODES];
    let mut k = 0;
    while k + 1 < NODES {
        let (a, b) = (k as f64 / LAST as f64, (k + 1) as f64 / LAST as f64);
        let fourth = b * b * b * b - a * a * a * a;
        let fifth = 0.8 * (b * b * b * b * b - a * a * a * a * a);
        weights[k] += (b * fourth - fifth) * LAST as f64;
        weights[k + 1] += (fifth - a * fourth) * LAST as f64;
        k += 1;
    }
    let mut rounded = [0.0; NODES];
    let mut k = 0;
    while k < NODES {
        rounded[k] = weights[k] as f32;
        k += 1;
    }
    rounded
}

impl Column {
    /// 0 everywhere.
    pub(super) const ZERO: Self = Self([0.0; NODES]);
    /// 1 everywhere.
    pub(super) const ONE: Self = Self([1.0; NODES]);

    /// The function of each node's cosine.
    pub(super) fn from_fn(mut f: impl FnMut(f32) -> f32) -> Self {
        Self::by_node(|k| {
            let root = k as f32 / LAST;
            f(root * root)
        })
    }

    /// The function of each node's number. A loop, as `array::from_fn` and `map` are not always inlined.
    #[inline(always)]
    fn by_node(mut f: impl FnMut(usize) -> f32) -> Self {
        let mut column = Self::ZERO;
        for (k, value) in column.0.iter_mut().enumerate() {
            *value = f(k);
        }
        column
    }

    /// Its value at a cosine, 0 to 1.
    #[inline]
    pub(super) fn at(&self, cos: f32) -> f32 {
        let Node { below, fraction } = Node::new(cos);
        mix(self.0[below], self.0[below + 1], fraction)
    }

    /// Its mean over uniform light, `2 ∫ f(μ) μ dμ`.
    #[inline]
    pub(super) fn mean(&self) -> f32 {
        let mut sums = [0.0; 8];
        for (values, weights) in self.0.chunks_exact(8).zip(WEIGHTS.chunks_exact(8)) {
            for k in 0..8 {
                sums[k] += values[k] * weights[k];
            }
        }
        sums.iter().sum()
    }

    /// Another function of the same values.
    #[inline]
    pub(super) fn map(&self, mut f: impl FnMut(f32) -> f32) -> Self {
        Self::by_node(|k| f(self.0[k]))
    }

    /// A function of two columns' values.
    #[inline]
    pub(super) fn zip(&self, other: &Self, mut f: impl FnMut(f32, f32) -> f32) -> Self {
        Self::by_node(|k| f(self.0[k], other.0[k]))
    }

    #[inline]
    pub(super) fn lerp(&self, other: &Self, fraction: f32) -> Self {
        self.zip(other, |a, b| mix(a, b, fraction))
    }
}

/// The place of a cosine in every column: the node below it, and the way from there to the next one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    below: usize,
    fraction: f32,
}

impl Node {
    /// The node of a cosine, 0 to 1.
    #[inline]
    pub(super) fn new(cos: f32) -> Self {
        let x = cos.sqrt() * LAST;
        // The comparison is false for a NaN too.
        let below = if x < LAST { x as usize } else { NODES - 2 };
        Self { below, fraction: x - below as f32 }
    }
}

#[inline]
fn mix(a: f32, b: f32, fraction: f32) -> f32 {
    a + fraction * (b - a)
}

/// A column of a table, and its mean.
#[derive(Debug)]
struct Tabled {
    column: Column,
    mean: f32,
}

impl Tabled {
    fn new(column: Column) -> Self {
        Self { mean: column.mean(), column }
    }
}

/// A column between those of a table, which are as many as it takes: none is copied.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blend<const N: usize> {
    columns: [&'static Tabled; N],
    weights: [f32; N],
}

impl<const N: usize> Blend<N> {
    /// The same value everywhere.
    pub(super) fn constant(value: f32) -> Self {
        static ONE: Tabled = Tabled { column: Column::ONE, mean: 1.0 };
        Self { columns: [&ONE; N], weights: array::from_fn(|i| if i == 0 { value } else { 0.0 }) }
    }

    #[inline]
    fn sum(&self, value: impl Fn(&Tabled) -> f32) -> f32 {
        let mut sum = 0.0;
        for (column, weight) in self.columns.iter().zip(self.weights) {
            sum += weight * value(column);
        }
        sum
    }

    /// Its value at a cosine.
    #[inline]
    pub(super) fn at(&self, Node { below, fraction }: Node) -> f32 {
        mix(self.sum(|it| it.column.0[below]), self.sum(|it| it.column.0[below + 1]), fraction)
    }

    /// See [`Column::mean`].
    #[inline]
    pub(super) fn mean(&self) -> f32 {
        self.sum(|it| it.mean)
    }

    /// All of it.
    pub(super) fn column(&self) -> Column {
        Column::by_node(|k| self.sum(|it| it.column.0[k]))
    }
}

impl Blend<2> {
    /// The same in the form of more columns.
    #[inline]
    pub(super) fn widen(&self) -> Blend<4> {
        let ([a, b], [x, y]) = (self.columns, self.weights);
        Blend { columns: [a, b, a, b], weights: [x, y, 0.0, 0.0] }
    }
}

/// Roughnesses of a table, evenly from 0 to 1.
pub(super) const ROUGHNESSES: usize = 33;
/// Refractive indices of a table: the root of the reflectance at normal incidence, below 1, is `(j/16)²`.
pub(super) const INDICES: usize = 16;

/// Columns by roughness, each made when it is first asked for.
type Rows = [OnceLock<Tabled>; ROUGHNESSES];

/// Rows by refractive index.
type Table = [Rows; INDICES];

const fn no_rows() -> Rows {
    [const { OnceLock::new() }; ROUGHNESSES]
}

const fn no_table() -> Table {
    [const { no_rows() }; INDICES]
}

/// The reflection lobe's albedo where all is reflected, of a roughness.
#[inline]
pub(super) fn full(roughness: f32) -> Blend<2> {
    static ROWS: Rows = no_rows();
    at_roughness(&ROWS, roughness, |ggx, wo, h, _| reflected(ggx, wo, h))
}

/// What the reflection lobe is multiplied by for each of its two directions so that all is reflected: `g` with
/// `g(μ_o) ∫ f cos g(μ_i) = 1`.
///
/// A lobe without what microfacets reflect to each other is too dark; with both factors it has its shape, is reciprocal, and leaves
/// nothing of a white furnace. Sinkhorn (1964) has the iteration.
#[inline]
pub(super) fn gain(roughness: f32) -> Blend<2> {
    static ROWS: Rows = no_rows();
    between(&ROWS, roughness, gain_column)
}

/// The reflection lobe's albedo at a cosine where `(1 - cos)⁵` is reflected, and where `cos (1 - cos)⁶` is: see
/// [`fresnel::Metal`].
#[inline]
pub(super) fn metal_at(roughness: f32, node: Node) -> (f32, f32) {
    static SCHLICK: Rows = no_rows();
    static DIP: Rows = no_rows();
    let schlick = |ggx: &Ggx, wo, h, cos| fresnel::schlick(cos) * reflected(ggx, wo, h);
    let dip = |ggx: &Ggx, wo, h, cos| cos * (1.0 - cos) * fresnel::schlick(cos) * reflected(ggx, wo, h);
    (at_roughness(&SCHLICK, roughness, schlick).at(node), at_roughness(&DIP, roughness, dip).at(node))
}

/// What a lobe of this roughness loses under a smooth coat of index 1.5 whose `t(μ) = 1 - F(μ)` dims it by the lesser of
/// `t(μ_o)` and `t(μ_i)`: `∫ max(0, t(μ_o) - t(μ_i)) f cos`. Other coats lose in proportion.
#[inline]
fn dimmed(roughness: f32) -> Blend<2> {
    static ROWS: Rows = no_rows();
    at_roughness(&ROWS, roughness, |ggx, wo, h, _| dims(wo, h) * reflected(ggx, wo, h))
}

/// The same of a lobe with its [gains](gain), by that without.
pub(super) fn dimmed_gain(roughness: f32) -> Column {
    static ROWS: Rows = no_rows();
    let gained = at_roughness(&ROWS, roughness, |ggx, wo, h, _| {
        let gain = gain(ggx.mean_roughness());
        let both = gain.at(Node::new(wo.z)) * gain.at(Node::new(reflect(wo, h).z.clamp(0.0, 1.0)));
        dims(wo, h) * reflected(ggx, wo, h) * both
    });
    gained.column().zip(&dimmed(roughness).column(), |gained, plain| if plain > 0.0 { gained / plain } else { 1.0 })
}

/// By how much such a coat dims light from the reflection of `wo` about `h` more than that of `wo`.
fn dims(wo: Vec3, h: Vec3) -> f32 {
    let reflectance = |w: Vec3| fresnel::dielectric(w.z.clamp(0.0, 1.0), 1.5).0;
    (reflectance(reflect(wo, h)) - reflectance(wo)).max(0.0)
}

/// What wide light loses likewise, under a cover whose `t` grows with the cosine: `∫ max(0, t(μ) - t(ν)) 2ν dν`.
fn dimmed_wide(transmittance: &Column) -> Column {
    let (mut weight, mut moment) = (0.0, 0.0);
    Column::by_node(|k| {
        weight += WEIGHTS[k];
        moment += WEIGHTS[k] * transmittance.0[k];
        (transmittance.0[k] * weight - moment).max(0.0)
    })
}

/// What a lobe of this roughness loses under a cover that leaves `transmittance`: [`dimmed`] in proportion to what wide
/// light loses.
pub(super) fn dimmed_under(transmittance: &Column, roughness: f32) -> Column {
    static SMOOTH: LazyLock<Column> =
        LazyLock::new(|| dimmed_wide(&reflection(0.0, 1.5, false).column().map(|f| 1.0 - f)));
    let ratio = dimmed_wide(transmittance).zip(&SMOOTH, |cover, smooth| (cover / smooth.max(1e-5)).min(2.0));
    dimmed(roughness).column().zip(&ratio, |lost, ratio| lost * ratio)
}

/// The reflection lobe's albedo with Fresnel's reflectance, seen from outside or inside.
#[inline]
pub(super) fn reflection(roughness: f32, ior: f32, is_inside: bool) -> Blend<4> {
    static TABLES: [Table; 2] = [const { no_table() }; 2];
    let weight = |ior: f32, ggx: &Ggx, wo, h, cos| {
        let eta = if is_inside { 1.0 / ior } else { ior };
        fresnel::dielectric(cos, eta).0 * reflected(ggx, wo, h)
    };
    at(&TABLES[usize::from(is_inside)], roughness, ior, weight)
}

/// The albedo of reflection and refraction together, seen from outside or inside.
#[inline]
pub(super) fn glass(roughness: f32, ior: f32, is_inside: bool) -> Blend<4> {
    static TABLES: [Table; 2] = [const { no_table() }; 2];
    let weight = |ior: f32, ggx: &Ggx, wo, h, cos| {
        let eta = if is_inside { 1.0 / ior } else { ior };
        interface(ggx, wo, h, cos, eta)
    };
    at(&TABLES[usize::from(is_inside)], roughness, ior, weight)
}

/// The microfacets of a row.
fn ggx(r: usize) -> Ggx {
    let roughness = r as f32 / (ROUGHNESSES - 1) as f32;
    Ggx { alpha: Vec2::splat(roughness * roughness) }
}

/// See [`gain`].
#[cold]
#[inline(never)]
fn gain_column(r: usize) -> Tabled {
    const STEPS: u32 = 64;
    let ggx = ggx(r);
    // What a direction at each node gets of a function that is 1 at another.
    let mut spread = [[0.0; NODES]; NODES];
    let mut row = spread.iter_mut();
    Column::from_fn(|cos| {
        let Some(row) = row.next() else { return 0.0 };
        each_visible(&ggx, cos, |wo, h, share| {
            let weight = share * reflected(&ggx, wo, h);
            let Node { below, fraction } = Node::new(reflect(wo, h).z.clamp(0.0, 1.0));
            row[below] += weight * (1.0 - fraction);
            row[below + 1] += weight * fraction;
        });
        0.0
    });
    let mut gain = Column::ONE;
    for _ in 0..STEPS {
        let before = gain;
        gain = Column::by_node(|k| {
            let got: f32 = spread[k].iter().zip(&before.0).map(|(spread, gain)| spread * gain).sum();
            (before.0[k] / got.max(f32::MIN_POSITIVE)).sqrt()
        });
    }
    Tabled::new(gain)
}

/// The mean of a weight of visible normals, for each cosine.
#[cold]
#[inline(never)]
fn column(r: usize, weight: &dyn Fn(&Ggx, Vec3, Vec3, f32) -> f32) -> Tabled {
    let ggx = ggx(r);
    Tabled::new(Column::from_fn(|cos| integrate(&ggx, cos, |wo, h, cos| weight(&ggx, wo, h, cos))))
}

#[inline]
fn at(table: &'static Table, roughness: f32, ior: f32, weight: impl Fn(f32, &Ggx, Vec3, Vec3, f32) -> f32) -> Blend<4> {
    let (j, fraction) = place(((ior - 1.0) / (ior + 1.0)).sqrt() * INDICES as f32, INDICES);
    let row = |j: usize| {
        let root = j as f32 / INDICES as f32;
        // At an index of 1 refraction has no half vector.
        let ior = ((1.0 + root * root) / (1.0 - root * root)).max(1.001);
        at_roughness(&table[j], roughness, |ggx, wo, h, cos| weight(ior, ggx, wo, h, cos))
    };
    let (below, above) = (row(j), row(j + 1));
    let ([a, b], [c, d]) = (below.columns, above.columns);
    let [x, y] = below.weights;
    let rest = 1.0 - fraction;
    Blend { columns: [a, b, c, d], weights: [rest * x, rest * y, fraction * x, fraction * y] }
}

#[inline]
fn at_roughness(rows: &'static Rows, roughness: f32, weight: impl Fn(&Ggx, Vec3, Vec3, f32) -> f32) -> Blend<2> {
    between(rows, roughness, |r| column(r, &weight))
}

/// The column between those of the rows, which are made as they are asked for.
#[inline]
fn between(rows: &'static Rows, roughness: f32, make: impl Fn(usize) -> Tabled) -> Blend<2> {
    let (r, fraction) = place(roughness * (ROUGHNESSES - 1) as f32, ROUGHNESSES);
    let row = |r: usize| rows[r].get_or_init(|| make(r));
    Blend { columns: [row(r), row(r + 1)], weights: [1.0 - fraction, fraction] }
}

/// The node below, one that has a node above, and the way to that; beyond the last node its own value.
#[inline]
fn place(x: f32, nodes: usize) -> (usize, f32) {
    let k = if x < (nodes - 1) as f32 { x as usize } else { nodes - 2 };
    (k, (x - k as f32).clamp(0.0, 1.0))
}

/// The weight of a reflection by a visible normal, `G₂/G₁`, where all is reflected.
fn reflected(ggx: &Ggx, wo: Vec3, h: Vec3) -> f32 {
    let wi = reflect(wo, h);
    if wi.z > 0.0 { ggx.g2(wo, wi) / ggx.g1(wo) } else { 0.0 }
}

/// The albedo of reflection and refraction.
fn interface(ggx: &Ggx, wo: Vec3, h: Vec3, cos: f32, eta: f32) -> f32 {
    let (reflectance, cos_beyond) = fresnel::dielectric(cos, eta);
    let refracted = if reflectance < 1.0 {
        let wi = (cos / eta - cos_beyond) * h - wo / eta;
        if wi.z < 0.0 { ggx.g2(wo, wi) / ggx.g1(wo) } else { 0.0 }
    } else {
        0.0
    };
    reflectance * reflected(ggx, wo, h) + (1.0 - reflectance) * refracted
}

/// The mean of a weight over the normals that are visible from a direction with this cosine. They are symmetric about
/// its plane: half of them do. There are more points where normals are steep: few are, but they reflect below the horizon.
fn integrate(ggx: &Ggx, cos: f32, weight: impl Fn(Vec3, Vec3, f32) -> f32) -> f32 {
    let mut sum = 0.0;
    each_visible(ggx, cos, |wo, h, share| sum += share * weight(wo, h, wo.dot(h).clamp(0.0, 1.0)));
    sum
}

/// Calls `see` with a direction of this cosine, with normals that are visible from there, and with the share of each.
fn each_visible(ggx: &Ggx, cos: f32, mut see: impl FnMut(Vec3, Vec3, f32)) {
    const POINTS: u32 = 1024;
    let cos = cos.max(1e-4);
    let wo = Vec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos);
    if ggx.alpha.x == 0.0 {
        return see(wo, Vec3::Z, 1.0);
    }
    let unit = |word: u32| (word >> 8) as f32 * (1.0 / 16_777_216.0);
    let shares: f32 = (0..POINTS).map(|point| unit(r2(point, [1 << 31; 2])[1])).sum();
    for point in 0..POINTS {
        let [x, y] = r2(point, [1 << 31; 2]);
        let (x, y) = (unit(x), unit(y));
        let h = ggx.sample_normal(wo, Vec2::new(0.5 * x, 1.0 - y * y));
        see(wo, h, y / shares);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A blend is what its columns are: at any cosine, and in the mean.
    #[test]
    fn blends_are_as_their_columns() {
        for (roughness, ior) in [(0.0, 1.5), (0.31, 1.33), (0.5, 1.5), (1.0, 2.4), (0.77, 1.0)] {
            for is_inside in [false, true] {
                let blend = reflection(roughness, ior, is_inside);
                let column = blend.column();
                for cos in [0.0, 1e-4, 0.2, 0.55, 0.999, 1.0] {
                    assert_eq!(blend.at(Node::new(cos)).to_bits(), column.at(cos).to_bits());
                }
                assert!((blend.mean() - column.mean()).abs() < 1e-6);
            }
        }
        assert_eq!(Blend::<4>::constant(0.25).column(), Column::ONE.map(|_| 0.25));
    }
}
