//! Checks the coordinates of an atlas: overlaps, lost and stretched charts, fill.

use std::collections::BTreeMap;
use std::fmt;

use super::atlas::{Atlas, NO_CHART};
use super::islands::{area, stretch};
use super::raster::{Polygon, rasterize};
use super::texels::MIN_COVERAGE;
use crate::scene::{Scene, count};

/// Two triangles overlap in a texel if they share more than this part of it; less is rounding.
const OVERLAP: f64 = 0.01;
/// A chart is stretched if a step on the page is more than this many times as long in one direction as in another ...
const STRETCH: f64 = 4.0;
/// ... or if its density and the densities' median have this ratio or a greater one.
const DENSITY: f32 = 4.0;
/// Coordinates may be outside of the page by this much.
const TOLERANCE: f32 = 1e-5;

/// The results of a check.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Check {
    /// The number of charts.
    pub charts: usize,
    /// The part of all texels that charts cover.
    pub fill: f64,
    /// Texels in which triangles lie on each other.
    pub overlapping: u64,
    /// The charts that they belong to, most texels first.
    pub overlaps: Vec<Overlap>,
    /// Texels that two charts touch or that both need for their filter.
    pub crowded: u64,
    /// Charts that are stretched, or much denser or less dense than the median.
    pub stretched: Vec<usize>,
    /// The triangles of each part without a texel.
    pub lost: Vec<Lost>,
    /// The overlapping texels of each page, as indices.
    pub overlapping_texels: Vec<Vec<u32>>,
}

/// Two charts that lie on each other; or one that folds over itself, which is named twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overlap {
    /// Their indices.
    pub charts: [usize; 2],
    /// How many texels they share.
    pub texels: u64,
}

/// Triangles of a part that have an area in space, but none on its page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lost {
    /// Triangles with coordinates that are not finite.
    pub not_finite: u64,
    /// Triangles with coordinates outside 0..=1.
    pub outside: u64,
    /// Triangles whose coordinates have no area.
    pub no_area: u64,
}

/// What speaks against using a part's own coordinates; as a text what they do wrong, empty if nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Faults {
    lost: Lost,
    overlapping: u64,
}

impl Lost {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.not_finite + self.outside + self.no_area
    }
}

impl Check {
    /// Whether light can be baked into these coordinates: nothing overlaps and nothing is lost.
    pub fn passes(&self) -> bool {
        self.overlapping == 0 && self.lost.iter().all(|lost| lost.total() == 0)
    }

    /// What speaks against part `part` alone.
    pub(crate) fn faults_of(&self, atlas: &Atlas, part: usize) -> Faults {
        let own = |overlap: &&Overlap| overlap.charts.iter().all(|&chart| atlas.charts[chart].part == part);
        let overlapping = self.overlaps.iter().filter(own).map(|overlap| overlap.texels).sum();
        Faults { lost: self.lost[part], overlapping }
    }
}

impl Faults {
    pub(crate) fn is_empty(&self) -> bool {
        self.lost.total() == 0 && self.overlapping == 0
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Lost { not_finite, outside, no_area } = self.lost;
        let triangles = |number: u64| count(number as usize, "triangle", "triangles");
        let mut faults = Vec::new();
        if not_finite > 0 {
            faults.push(format!("are not finite in {}", triangles(not_finite)));
        }
        if outside > 0 {
            faults.push(format!("are not between 0 and 1 in {}", triangles(outside)));
        }
        if no_area > 0 {
            faults.push(format!("have no area in {}", triangles(no_area)));
        }
        if self.overlapping > 0 {
            faults.push(format!("overlap in {}", count(self.overlapping as usize, "texel", "texels")));
        }
        f.write_str(&faults.join(" and "))
    }
}

/// Checks an atlas whose charts keep `padding` texels around them to themselves.
pub(crate) fn check(scene: &Scene, atlas: &Atlas, padding: u32) -> Check {
    let mut found = Check { charts: atlas.charts.len(), ..Check::default() };
    found.lost = atlas.parts.iter().map(|_| Lost::default()).collect();
    for (part, lost) in atlas.parts.iter().zip(&mut found.lost) {
        for (triangle, &chart) in part.charts.iter().enumerate() {
            let corners = part.triangles[triangle].map(|vertex| part.vertices[vertex as usize].uv);
            let inside = |value: f32| (-TOLERANCE..=1.0 + TOLERANCE).contains(&value);
            if area(scene.meshes[part.mesh].corners(part.faces[triangle] as usize)) == 0.0 {
                // Nothing of it could be seen.
            } else if !corners.iter().all(|uv| uv.is_finite()) {
                lost.not_finite += 1;
            } else if !corners.iter().all(|uv| inside(uv.x) && inside(uv.y)) {
                lost.outside += 1;
            } else if chart == NO_CHART && !atlas.left_out.has(part.mesh, part.faces[triangle] as usize) {
                lost.no_area += 1;
            }
        }
    }
    found.stretched = stretched(scene, atlas);
    find_overlaps(atlas, padding, &mut found);
    found
}

/// The charts that are stretched, or of an unusual density.
fn stretched(scene: &Scene, atlas: &Atlas) -> Vec<usize> {
    let mut densities: Vec<f32> = atlas.charts.iter().map(super::atlas::Chart::density).collect();
    let all = densities.clone();
    let median = match densities.len() {
        0 => return Vec::new(),
        length => *densities.select_nth_unstable_by(length / 2, f32::total_cmp).1,
    };
    let is_stretched = |&index: &usize| {
        let chart = &atlas.charts[index];
        let part = &atlas.parts[chart.part];
        let (mut ratios, mut areas) = (0.0, 0.0);
        for &triangle in &chart.triangles {
            let on_page = part.corners(triangle as usize, atlas.pages[part.page]);
            let corners = scene.meshes[part.mesh].corners(part.faces[triangle as usize] as usize);
            let [greatest, least] = stretch(corners, on_page);
            let area = Polygon::triangle(on_page).area().abs();
            // What is a line in space counts as stretched as can be.
            ratios += area * (greatest / least).min(1e6);
            areas += area;
        }
        let density = all[index] / median;
        ratios > STRETCH * areas || !(1.0 / DENSITY..=DENSITY).contains(&density)
    };
    (0..atlas.charts.len()).filter(is_stretched).collect()
}

/// Finds which charts overlap or are closer than `padding` allows, and how much of the pages is covered.
fn find_overlaps(atlas: &Atlas, padding: u32, found: &mut Check) {
    let mut pairs: BTreeMap<[usize; 2], u64> = BTreeMap::new();
    let (mut covered, mut all) = (0.0, 0.0);
    for (index, page) in atlas.pages.iter().enumerate() {
        let mut pieces: Vec<(u32, u32, Polygon)> = Vec::new();
        for part in atlas.parts.iter().filter(|part| part.page == index) {
            for (triangle, &chart) in part.charts.iter().enumerate().filter(|(_, chart)| **chart != NO_CHART) {
                rasterize(part.corners(triangle, *page), page.width, page.height, |x, y, piece| {
                    pieces.push((y * page.width + x, chart, *piece));
                });
            }
        }
        pieces.sort_by_key(|(texel, ..)| *texel);
        let mut overlapping = Vec::new();
        // Which chart has a texel, if it is only one.
        let mut owners = vec![NO_CHART; page.texels()];
        let mut crowded = vec![false; page.texels()];
        for group in pieces.chunk_by(|a, b| a.0 == b.0) {
            let texel = group[0].0 as usize;
            let charts = charts_shown(group);
            if let Some(&first) = charts.first() {
                owners[texel] = first;
                crowded[texel] = charts.iter().any(|chart| *chart != first);
            }
            covered += group.iter().map(|(.., piece)| piece.area().abs()).sum::<f64>().min(1.0);
            let in_texel = overlapping_pairs(group);
            if !in_texel.is_empty() {
                overlapping.push(texel as u32);
            }
            in_texel.into_iter().for_each(|pair| *pairs.entry(pair).or_default() += 1);
        }
        all += page.texels() as f64;
        found.overlapping += overlapping.len() as u64;
        found.overlapping_texels.push(overlapping);
        found.crowded += count_crowded(&owners, &crowded, page.width as usize, 2 * padding as usize);
    }
    found.fill = covered / all;
    found.overlaps = pairs.into_iter().map(|(charts, texels)| Overlap { charts, texels }).collect();
    found.overlaps.sort_by_key(|overlap| std::cmp::Reverse(overlap.texels));
}

/// The charts that a bake shows in the texel of which these are the pieces: it leaves to the gutter what hardly covers
/// any of it, as does a chart that ends at the texel's border but for rounding.
fn charts_shown(pieces: &[(u32, u32, Polygon)]) -> Vec<u32> {
    let area = |chart: u32| -> f64 {
        pieces.iter().filter(|(_, other, _)| *other == chart).map(|(.., piece)| piece.area().abs()).sum()
    };
    let mut charts: Vec<u32> = pieces.iter().map(|(_, chart, _)| *chart).collect();
    charts.dedup();
    charts.retain(|chart| area(*chart) >= f64::from(MIN_COVERAGE));
    charts
}

/// The pairs of charts whose pieces of one texel overlap.
fn overlapping_pairs(pieces: &[(u32, u32, Polygon)]) -> Vec<[usize; 2]> {
    let mut pairs: Vec<[usize; 2]> = Vec::new();
    for (i, (_, chart, piece)) in pieces.iter().enumerate() {
        for (_, other_chart, other) in &pieces[i + 1..] {
            let pair = [*chart.min(other_chart) as usize, *chart.max(other_chart) as usize];
            if !pairs.contains(&pair) && piece.overlap(other) > OVERLAP {
                pairs.push(pair);
            }
        }
    }
    pairs
}

/// Texels that two charts touch, or that are fewer than `gutter` texels away from another chart's in their row or
/// column.
fn count_crowded(owners: &[u32], crowded: &[bool], width: usize, gutter: usize) -> u64 {
    let height = owners.len() / width.max(1);
    let mut close = crowded.to_vec();
    let mut along = |length: usize, texel: &dyn Fn(usize) -> usize| {
        let mut last: Option<usize> = None;
        for i in (0..length).filter(|&i| owners[texel(i)] != NO_CHART) {
            if let Some(before) = last
                && owners[texel(before)] != owners[texel(i)]
                && i - before <= gutter
            {
                (close[texel(before)], close[texel(i)]) = (true, true);
            }
            last = Some(i);
        }
    };
    (0..height).for_each(|y| along(width, &|x| y * width + x));
    (0..width).for_each(|x| along(height, &|y| y * width + x));
    close.into_iter().filter(|&close| close).count() as u64
}
