//! Columns: functions of a cosine, by their values at [`NODES`] nodes, and blends of some of them.
//!
//! As functions between nodes are linear, their integrals over all directions are exact sums.

use std::array;

/// Cosines of a column: `μ = (k/31)²`.
pub(super) const NODES: usize = 32;

pub(super) const LAST: f32 = (NODES - 1) as f32;

/// A function of the cosine of a direction, linear in its square root between nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Column(pub(super) [f32; NODES]);

/// `∫ 2μ hat_k(μ) dμ` of the hat function about each node.
pub(super) const WEIGHTS: [f32; NODES] = weights();

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

/// The cosine itself: those of the nodes.
pub(super) const COSINES: Column = Column(cosines());

const fn cosines() -> [f32; NODES] {
    let mut cosines = [0.0; NODES];
    let mut k = 0;
    while k < NODES {
        let root = k as f32 / LAST;
        cosines[k] = root * root;
        k += 1;
    }
    cosines
}

impl Column {
    /// 0 everywhere.
    pub(super) const ZERO: Self = Self([0.0; NODES]);
    /// 1 everywhere.
    pub(super) const ONE: Self = Self([1.0; NODES]);

    /// The function of each node's cosine.
    pub(super) fn from_fn(mut f: impl FnMut(f32) -> f32) -> Self {
        Self::by_node(|k| f(COSINES.0[k]))
    }

    /// The function of each node's number. A loop, as `array::from_fn` and `map` are not always inlined.
    #[inline(always)]
    pub(super) fn by_node(mut f: impl FnMut(usize) -> f32) -> Self {
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
    pub(super) below: usize,
    pub(super) fraction: f32,
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
pub(super) fn mix(a: f32, b: f32, fraction: f32) -> f32 {
    a + fraction * (b - a)
}

/// A column of a table, and its mean.
#[derive(Debug)]
pub(super) struct Tabled {
    column: Column,
    mean: f32,
}

impl Tabled {
    pub(super) fn new(column: Column) -> Self {
        Self { mean: column.mean(), column }
    }
}

/// A column between those of a table, which are as many as it takes: none is copied.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blend<const N: usize> {
    pub(super) columns: [&'static Tabled; N],
    pub(super) weights: [f32; N],
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
