//! The noise of a map: the relative noise σ of each chart, from the second differences along its rows and columns,
//! whose median is hardly moved by the edges of shadows.

use super::dilate::{PageTexels, TexelSource};
use crate::bake::layout::atlas::Page;

/// The median of |x| of a normal distribution is this part of its σ; a second difference has √6 times the σ.
const MEDIAN: f32 = 0.6745 * 2.449_49;

/// A page of texels with light, by their brightness.
pub(crate) struct View<'a> {
    pub(crate) grid: &'a PageTexels,
    pub(crate) brightness: &'a [f32],
}

impl View<'_> {
    /// The texels with light.
    pub(crate) fn texels(&self) -> impl Iterator<Item = u32> {
        (0..self.grid.owners.len() as u32).filter(|&texel| self.is_light(texel))
    }

    /// Whether a texel has light of its own.
    pub(crate) fn is_light(&self, texel: u32) -> bool {
        self.grid.sources[texel as usize] == TexelSource::Light
    }

    /// The texel at a step from another, if it is one with light of the same chart.
    pub(crate) fn at(&self, texel: u32, (dx, dy): (i64, i64)) -> Option<u32> {
        let Page { width, height } = self.grid.page;
        let (x, y) = (i64::from(texel % width) + dx, i64::from(texel / width) + dy);
        if !(0..i64::from(width)).contains(&x) || !(0..i64::from(height)).contains(&y) {
            return None;
        }
        let other = y as u32 * width + x as u32;
        let is_own = self.grid.owners[other as usize] == self.grid.owners[texel as usize];
        (is_own && self.is_light(other)).then_some(other)
    }

    /// The difference of two texels over their mean.
    pub(crate) fn difference(&self, a: u32, b: u32) -> f32 {
        let (a, b) = (self.brightness[a as usize], self.brightness[b as usize]);
        if a + b > 0.0 { 2.0 * (a - b) / (a + b) } else { 0.0 }
    }

    /// The second differences along the row and the column of a texel, as far as there are any.
    pub(crate) fn second_differences(&self, texel: u32) -> impl Iterator<Item = f32> {
        [(1, 0), (0, 1)].into_iter().filter_map(move |(x, y)| {
            let (after, before) = (self.at(texel, (x, y))?, self.at(texel, (-x, -y))?);
            Some((self.difference(texel, before) + self.difference(texel, after)).abs())
        })
    }

    /// Adds the second differences of each chart to its list.
    pub(crate) fn differences(&self, of_charts: &mut [Vec<f32>]) {
        for texel in self.texels() {
            of_charts[self.grid.owners[texel as usize] as usize].extend(self.second_differences(texel));
        }
    }
}

/// The σ of second differences; 0 without any.
pub(crate) fn sigma(differences: &mut [f32]) -> f32 {
    match differences.len() {
        0 => 0.0,
        length => *differences.select_nth_unstable_by(length / 2, f32::total_cmp).1 / MEDIAN,
    }
}
