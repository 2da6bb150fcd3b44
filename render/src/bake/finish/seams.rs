//! Seams: where the border of a chart cuts a smooth surface, samples on both sides of the cut must agree. Along a
//! crease they must agree only as far as the difference is noise: a greater difference is in the light itself.
//!
//! At points along each cut the map is sampled on both sides, as engines will; the texels around are changed as little
//! as possible so that the differences vanish: `min Σ (s_a - s_b)²/m² + Σ λ (x - x₀)²/m²`, a sparse least squares
//! problem (Iwanicki 2013 has it for bilinear sampling), solved by conjugate gradients on its normal equations in a
//! fixed order. `m` is the brightness there, for a step is seen relative to it. Gutter texels may change more than
//! texels on surfaces.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3, Vec3};

use super::dilate::{PageTexels, TexelSource};
use super::filter::{Footprint, footprint};
use super::noise::{View, sigma};
use crate::bake::layout::atlas::{Atlas, NO_CHART};
use crate::bake::layout::edges::{SharedEdge, Side};
use crate::bake::options::Sampling;

/// The cost of a change of a texel, relative to a step of the same size at a seam.
const LIGHT: f64 = 0.001;
/// The same of texels that were taken from others.
const FILLED: f64 = 0.0001;
/// Brightness below this part of the greatest counts as this much.
const DARKEST: f64 = 1e-4;
/// Steps at creases up to this many times their noise are noise.
const NOISE: f64 = 4.0;
/// So are all up to this: a cache's noise is as smooth as light itself.
const MIN_STEP: f64 = 0.05;
/// None above this is: what a chart's noise says is wrong where light changes within a few texels, or where there is
/// none.
const MAX_STEP: f64 = 0.25;
/// Second differences that a chart must have to know its noise.
const MIN_DIFFERENCES: usize = 16;
/// Points along a cut for each texel.
const POINTS: f64 = 4.0;
/// Ends of sides within this many texels are the same.
const MERGE_DISTANCE: f64 = 1e-6;
/// Steps of the solver, at most.
const MAX_STEPS: u32 = 2000;
/// The part of the residual's square at which it ends.
const TOLERANCE: f64 = 1e-16;

/// Seams of an atlas as equations between texels.
pub(crate) struct Seams {
    equations: Vec<Equation>,
    /// The texels in them, as page and index.
    unknowns: Vec<(u32, u32)>,
    /// The cost of a change of each.
    costs: Vec<f64>,
    /// Points where a filter reaches into another chart.
    pub(crate) mixed: usize,
    /// The meshes whose charts these are.
    pub(crate) mixed_meshes: BTreeSet<usize>,
}

/// Two samples that should be equal.
struct Equation {
    /// Unknowns with their weights on one side, and negative ones on the other.
    terms: Vec<(u32, f64)>,
}

/// An edge that lies in two places of the pages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cut {
    pub(crate) sides: [CutSide; 2],
    /// Whether the surface continues across it without a crease.
    pub(crate) is_smooth: bool,
}

/// One of the places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CutSide {
    pub(crate) page: usize,
    pub(crate) chart: u32,
    pub(crate) ends: [DVec2; 2],
}

impl CutSide {
    /// Whether both are one line of one chart, to rounding.
    fn is_at(&self, other: &Self) -> bool {
        let is_near = |i: usize| self.ends[i].distance(other.ends[i]) < MERGE_DISTANCE;
        (self.page, self.chart) == (other.page, other.chart) && is_near(0) && is_near(1)
    }
}

/// The edges that charts' borders cut.
pub(crate) fn cuts(atlas: &Atlas, meshes: usize, edges: &[SharedEdge]) -> Vec<Cut> {
    let mut places: Vec<Vec<(u32, u32)>> = vec![Vec::new(); meshes];
    for (number, part) in (0..).zip(&atlas.parts) {
        let places = &mut places[part.mesh];
        for (triangle, &face) in (0..).zip(&part.faces) {
            places.resize(places.len().max(face as usize + 1), (0, 0));
            places[face as usize] = (number, triangle);
        }
    }
    let side = |side: Side, span: [f64; 2]| {
        let (part, triangle) = places[side.mesh as usize][side.face as usize];
        let part = &atlas.parts[part as usize];
        let corners = part.corners(triangle as usize, atlas.pages[part.page]);
        let [start, end] = side.corners().map(|corner| corners[corner]);
        let ends = span.map(|part| start.lerp(end, part));
        CutSide { page: part.page, chart: part.charts[triangle as usize], ends }
    };
    let cut = |edge: &SharedEdge| Cut {
        sides: [0, 1].map(|i| side(edge.sides[i], edge.spans[i])),
        is_smooth: edge.is_smooth,
    };
    let is_cut = |cut: &Cut| !cut.sides[0].is_at(&cut.sides[1]) && cut.sides.iter().all(|side| side.chart != NO_CHART);
    edges.iter().map(cut).filter(is_cut).collect()
}

impl Cut {
    /// Places along the cut, a few for each texel, `offset` of a step from the start.
    pub(crate) fn places(&self, offset: f64) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        let length = self.sides.iter().map(|side| side.ends[0].distance(side.ends[1])).fold(0.0, f64::max);
        let steps = (POINTS * length).ceil().max(1.0);
        (0..steps as u32).map(move |step| {
            let t = (f64::from(step) + offset) / steps;
            self.sides.map(|side| side.ends[0].lerp(side.ends[1], t))
        })
    }
}

impl Seams {
    /// The seams at `cuts`, for maps that are sampled like this; `brightness` has a value for each texel of each page.
    pub(crate) fn new(
        atlas: &Atlas,
        cuts: &[Cut],
        page_texels: &[PageTexels],
        brightness: &[Vec<f32>],
        sampling: Sampling,
    ) -> Self {
        let samplings: &[Sampling] = match sampling {
            Sampling::Bilinear => &[Sampling::Bilinear],
            // Engines have a switch for it.
            Sampling::Bicubic => &[Sampling::Bilinear, Sampling::Bicubic],
        };
        let mut numbers: Vec<Vec<u32>> = page_texels.iter().map(|grid| vec![u32::MAX; grid.owners.len()]).collect();
        let mut seams = Self {
            equations: Vec::new(),
            unknowns: Vec::new(),
            costs: Vec::new(),
            mixed: 0,
            mixed_meshes: BTreeSet::new(),
        };
        let noise = noise(atlas, page_texels, brightness);
        let sample = |(page, footprint): &(usize, Footprint)| -> f64 {
            footprint.iter().map(|&(texel, weight)| weight * f64::from(brightness[*page][texel as usize])).sum()
        };
        for cut in cuts {
            let of_both = cut.sides.map(|side| noise[side.chart as usize].powi(2)).iter().sum::<f64>().sqrt();
            let most = if cut.is_smooth { f64::INFINITY } else { (NOISE * of_both).clamp(MIN_STEP, MAX_STEP) };
            for (places, &sampling) in cut.places(0.5).flat_map(|places| samplings.iter().map(move |by| (places, by))) {
                let side = |i: usize| {
                    let CutSide { page, chart, .. } = cut.sides[i];
                    let footprint = footprint(sampling, atlas.pages[page], places[i]);
                    let is_own = footprint.iter().all(|&(texel, _)| page_texels[page].owners[texel as usize] == chart);
                    is_own.then_some((page, footprint))
                };
                let sides = [side(0), side(1)];
                let is_mixed = sides.each_ref().map(Option::is_none);
                if let [Some(a), Some(b)] = sides {
                    let [x, y] = [sample(&a), sample(&b)];
                    if (x - y).abs() <= most * 0.5 * (x + y) {
                        seams.add(page_texels, &mut numbers, [(a, 1.0), (b, -1.0)]);
                    }
                } else if cut.is_smooth {
                    // Charts are too close: a filter mixes them, and nothing can be done.
                    seams.mixed += 1;
                    let mesh = |i: usize| atlas.parts[atlas.charts[cut.sides[i].chart as usize].part].mesh;
                    seams.mixed_meshes.extend((0..2).filter(|&i| is_mixed[i]).map(mesh));
                }
            }
        }
        seams
    }

    fn add(&mut self, page_texels: &[PageTexels], numbers: &mut [Vec<u32>], sides: [((usize, Footprint), f64); 2]) {
        let mut terms: Vec<(u32, f64)> = Vec::new();
        for ((page, footprint), sign) in sides {
            for (texel, weight) in footprint {
                let number = &mut numbers[page][texel as usize];
                if *number == u32::MAX {
                    *number = self.unknowns.len() as u32;
                    self.unknowns.push((page as u32, texel));
                    let is_light = page_texels[page].sources[texel as usize] == TexelSource::Light;
                    self.costs.push(if is_light { LIGHT } else { FILLED });
                }
                match terms.iter_mut().find(|(unknown, _)| unknown == number) {
                    Some((_, sum)) => *sum += sign * weight,
                    None => terms.push((*number, sign * weight)),
                }
            }
        }
        self.equations.push(Equation { terms });
    }

    /// The number of equations.
    pub(crate) fn len(&self) -> usize {
        self.equations.len()
    }

    /// Changes `layers`, each of which has a list of texels for each page, so that samples agree. The first one gives
    /// the brightness.
    pub(crate) fn solve(&self, layers: &mut [Vec<Vec<Vec3>>]) {
        let Some(brightness) = layers.first() else { return };
        let (scales, costs) = self.scales(brightness);
        for layer in layers {
            let at = |&(page, texel): &(u32, u32)| (page as usize, texel as usize);
            let places: Vec<(usize, usize)> = self.unknowns.iter().map(at).collect();
            let changes = [0, 1, 2].map(|channel| {
                let values: Vec<f64> = places.iter().map(|&(page, texel)| layer[page][texel][channel].into()).collect();
                self.changes(&values, &scales, &costs)
            });
            for (i, (page, texel)) in places.into_iter().enumerate() {
                let change = DVec3::from_array([0, 1, 2].map(|channel: usize| changes[channel][i]));
                let value = &mut layer[page][texel];
                *value = (value.as_dvec3() + change).as_vec3();
            }
        }
    }

    /// The factor of each equation, and the cost of a change of each unknown, in the same unit.
    fn scales(&self, brightness: &[Vec<Vec3>]) -> (Vec<f64>, Vec<f64>) {
        let bright = |unknown: u32| -> f64 {
            let (page, texel) = self.unknowns[unknown as usize];
            brightness[page as usize][texel as usize].element_sum().abs().into()
        };
        let mean = |equation: &Equation| -> f64 {
            0.5 * equation.terms.iter().map(|&(unknown, weight)| weight.abs() * bright(unknown)).sum::<f64>()
        };
        let means: Vec<f64> = self.equations.iter().map(mean).collect();
        let darkest = means.iter().copied().fold(f64::MIN_POSITIVE, f64::max) * DARKEST;
        let scales: Vec<f64> = means.iter().map(|mean| 1.0 / mean.max(darkest)).collect();
        let mut squares = vec![(0.0, 0.0); self.unknowns.len()];
        for (equation, scale) in self.equations.iter().zip(&scales) {
            for &(unknown, _) in &equation.terms {
                let (sum, number) = &mut squares[unknown as usize];
                *sum += scale * scale;
                *number += 1.0;
            }
        }
        let costs = self.costs.iter().zip(squares).map(|(cost, (sum, number))| cost * sum / number);
        (scales, costs.collect())
    }

    /// The changes that make samples agree: conjugate gradients (Hestenes and Stiefel 1952) with the diagonal as
    /// preconditioner.
    fn changes(&self, values: &[f64], scales: &[f64], costs: &[f64]) -> Vec<f64> {
        let mut inverse = costs.to_vec();
        for (equation, scale) in self.equations.iter().zip(scales) {
            equation.terms.iter().for_each(|&(i, weight)| inverse[i as usize] += (scale * weight).powi(2));
        }
        inverse.iter_mut().for_each(|diagonal| *diagonal = 1.0 / *diagonal);
        let mut changes = vec![0.0; values.len()];
        let mut residual = self.normal(values, scales, &vec![0.0; values.len()]);
        residual.iter_mut().for_each(|value| *value = -*value);
        let mut direction: Vec<f64> = residual.iter().zip(&inverse).map(|(r, i)| r * i).collect();
        let mut rest = dot(&residual, &direction);
        let end = rest * TOLERANCE;
        for _ in 0..MAX_STEPS {
            if rest <= end {
                break;
            }
            let product = self.normal(&direction, scales, costs);
            let step = rest / dot(&direction, &product);
            for i in 0..changes.len() {
                changes[i] += step * direction[i];
                residual[i] -= step * product[i];
            }
            let before = rest;
            rest = residual.iter().zip(&inverse).map(|(r, i)| r * r * i).sum();
            for i in 0..direction.len() {
                direction[i] = residual[i] * inverse[i] + rest / before * direction[i];
            }
        }
        changes
    }

    /// The matrix of the normal equations times `values`.
    fn normal(&self, values: &[f64], scales: &[f64], costs: &[f64]) -> Vec<f64> {
        let mut product: Vec<f64> = values.iter().zip(costs).map(|(value, cost)| value * cost).collect();
        for (equation, scale) in self.equations.iter().zip(scales) {
            let step: f64 = equation.terms.iter().map(|&(i, weight)| weight * values[i as usize]).sum();
            let step = step * scale * scale;
            equation.terms.iter().for_each(|&(i, weight)| product[i as usize] += weight * step);
        }
        product
    }
}

/// The relative noise of each chart; 0 where too little is known of it.
fn noise(atlas: &Atlas, page_texels: &[PageTexels], brightness: &[Vec<f32>]) -> Vec<f64> {
    let mut differences = vec![Vec::new(); atlas.charts.len()];
    for (grid, brightness) in page_texels.iter().zip(brightness) {
        View { grid, brightness }.differences(&mut differences);
    }
    let noise =
        |differences: &mut Vec<f32>| if differences.len() < MIN_DIFFERENCES { 0.0 } else { sigma(differences).into() };
    differences.iter_mut().map(noise).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
