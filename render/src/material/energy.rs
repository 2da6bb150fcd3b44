//! Directional albedos of microfacet lobes, and from them the transmittance of layers, and the gain of light scattered
//! by a second microfacet.
//!
//! The albedo of a lobe depends on the cosine `μ` of `wo`, on roughness and on the refractive index. Tables hold it for
//! [`NODES`] cosines, [`ROUGHNESSES`] roughnesses and [`INDICES`] refractive indices. A [`Column`] of cosines is computed
//! once, over visible normals, when a closure first asks for it. A closure holds a [`Blend`] of some columns, which mixes two
//! nodes of each where it needs a cosine. As functions between nodes are linear, their integrals over all directions are exact
//! sums.

use std::sync::{LazyLock, OnceLock};

use glam::{Vec2, Vec3};

use super::albedo_integral::{each_visible, integrate, interface, reflected};
use super::column::{Blend, Column, NODES, Node, Tabled, WEIGHTS};
use super::fresnel;
use super::ggx::{Ggx, reflect};

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
