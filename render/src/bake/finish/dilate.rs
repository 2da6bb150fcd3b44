//! Fills texels without light of their own: covered texels of a chart, and its gutter.
//!
//! Each takes the mean of its neighbours of the same chart that have a value, ring by ring; texels of other charts are
//! never used.

use crate::bake::layout::atlas::{NO_CHART, Page};

/// The texels of a page.
#[derive(Clone, Debug)]
pub(crate) struct PageTexels {
    pub(crate) page: Page,
    /// The chart of each texel, [`NO_CHART`] outside of all.
    pub(crate) owners: Vec<u32>,
    /// The source of its value.
    pub(crate) sources: Vec<TexelSource>,
}

/// The source of a texel's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TexelSource {
    /// Nowhere: it is in no chart, and black.
    Nothing,
    /// It is the light at a point of the texel.
    Light,
    /// Other texels of its chart, because something covers it.
    Covered,
    /// Other texels of its chart, next to which it lies.
    Gutter,
}

/// A texel that takes the mean of others.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mean {
    pub(crate) texel: u32,
    pub(crate) of: Vec<u32>,
}

impl PageTexels {
    /// Gives the texels around charts to the charts, `rings` deep.
    pub(crate) fn add_gutters(&mut self, rings: u32) {
        for _ in 0..rings {
            let before = self.owners.clone();
            for texel in (0..before.len() as u32).filter(|&texel| before[texel as usize] == NO_CHART) {
                // Sides before corners; of equal neighbours the first.
                let owner = self.neighbours(texel).map(|other| before[other as usize]).find(|&owner| owner != NO_CHART);
                if let Some(owner) = owner {
                    self.owners[texel as usize] = owner;
                    self.sources[texel as usize] = TexelSource::Gutter;
                }
            }
        }
    }

    /// What each texel without light is the mean of, in an order in which all of these are known before.
    pub(crate) fn means(&self) -> Vec<Mean> {
        let mut known: Vec<bool> = self.sources.iter().map(|source| *source == TexelSource::Light).collect();
        let mut open: Vec<u32> =
            (0..known.len() as u32).filter(|&i| !known[i as usize] && self.owners[i as usize] != NO_CHART).collect();
        let mut means: Vec<Mean> = Vec::new();
        loop {
            let first = means.len();
            open.retain(|&texel| {
                let owner = self.owners[texel as usize];
                let has_value = |&other: &u32| known[other as usize] && self.owners[other as usize] == owner;
                let of: Vec<u32> = self.neighbours(texel).filter(has_value).collect();
                let is_open = of.is_empty();
                if !is_open {
                    means.push(Mean { texel, of });
                }
                is_open
            });
            if means.len() == first {
                return means;
            }
            means[first..].iter().for_each(|mean| known[mean.texel as usize] = true);
        }
    }

    /// The texels around one, those at its sides first.
    fn neighbours(&self, texel: u32) -> impl Iterator<Item = u32> + use<> {
        const STEPS: [(i64, i64); 8] = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];
        let (width, height) = (i64::from(self.page.width), i64::from(self.page.height));
        let (x, y) = (i64::from(texel) % width, i64::from(texel) / width);
        STEPS.into_iter().filter_map(move |(dx, dy)| {
            let (x, y) = (x + dx, y + dy);
            ((0..width).contains(&x) && (0..height).contains(&y)).then(|| (y * width + x) as u32)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Digits are charts with light, `x` a covered texel of chart 1, dots nothing.
    fn grid(rows: &[&str]) -> PageTexels {
        let texels = || rows.iter().flat_map(|row| row.bytes());
        PageTexels {
            page: Page { width: rows[0].len() as u32, height: rows.len() as u32 },
            owners: texels()
                .map(|c| match c {
                    b'.' => NO_CHART,
                    b'x' => 1,
                    digit => u32::from(digit - b'0'),
                })
                .collect(),
            sources: texels()
                .map(|c| match c {
                    b'.' => TexelSource::Nothing,
                    b'x' => TexelSource::Covered,
                    _ => TexelSource::Light,
                })
                .collect(),
        }
    }

    #[test]
    fn gutters_grow_ring_by_ring_and_meet_in_the_middle() {
        let mut grid = grid(&["1....2"]);
        grid.add_gutters(1);
        assert_eq!(grid.owners, [1, 1, NO_CHART, NO_CHART, 2, 2]);
        grid.add_gutters(1);
        assert_eq!(grid.owners, [1, 1, 1, 2, 2, 2]);
        assert_eq!(grid.sources[2], TexelSource::Gutter);
    }

    #[test]
    fn means_are_of_the_own_chart_and_of_what_is_known() {
        let mut grid = grid(&["11x2", "1xx2", "xx.."]);
        grid.add_gutters(1);
        let means = grid.means();
        assert_eq!(means.len(), 7);
        let first = &means[0];
        assert_eq!((first.texel, first.of.as_slice()), (2, &[1][..]), "not of chart 2 at its right");
        let mut known: Vec<u32> = vec![0, 1, 3, 4, 7];
        for mean in &means {
            assert!(mean.of.iter().all(|other| grid.owners[*other as usize] == grid.owners[mean.texel as usize]));
            known.push(mean.texel);
        }
        // The corner of chart 1 is two rings away from its light.
        assert!(means.last().unwrap().of.iter().all(|other| known.contains(other)));
        let gutter = means.iter().find(|mean| mean.texel == 11).unwrap();
        assert_eq!(gutter.of, [7]);
    }
}
