//! Error against rays or time: by paths, and by caches of several kinds, as figures.

use super::study::{Run, Study};
use crate::cache::Reading;
use crate::output::plot::{Axis, Figure, Point, Series, svg};
use crate::settings::{CachedOptions, Gradients, Metric};

/// A kind of cache.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// What it is called in figures.
    pub label: &'static str,
    metric: Metric,
    reading: Reading,
}

/// The split-sphere without gradients, with the rotational one, and with both, records read alone as published and then
/// together; its bounded form, and the Hessian.
pub const KINDS: [Kind; 6] = [
    Kind { label: NO_GRADIENTS, metric: Metric::SplitSphere, reading: Reading::Alone(Gradients::Off) },
    Kind { label: "rotation", metric: Metric::SplitSphere, reading: Reading::Alone(Gradients::Rotation) },
    Kind { label: "both, records alone", metric: Metric::SplitSphere, reading: Reading::Alone(Gradients::Both) },
    Kind { label: GRADIENTS, metric: Metric::SplitSphere, reading: Reading::Together },
    Kind { label: "bounded", metric: Metric::Bounded, reading: Reading::Together },
    Kind { label: HESSIAN, metric: Metric::Hessian, reading: Reading::Together },
];
pub(super) const NO_GRADIENTS: &str = "no gradients";
pub(super) const GRADIENTS: &str = "both gradients";
pub(super) const HESSIAN: &str = "Hessian";
/// Paths in figures.
const PATHS: &str = "path tracing";

/// The measured quantity.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// Numbers of paths.
    pub paths: &'a [u32],
    /// Errors that caches are made with, from coarse to fine.
    pub errors: &'a [f32],
    /// Rays of a record.
    pub rays: u32,
    /// Metrics whose caches are measured; of others there are no curves.
    pub metrics: &'a [Metric],
}

/// The horizontal axis of errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Rays, which are the same on every machine.
    Rays,
    /// Processor time, if measured.
    Seconds,
}

/// The runs of each kind, in the order of [`KINDS`] after those by paths.
#[derive(Clone, Debug)]
pub struct Curves {
    paths: Vec<Run>,
    caches: [Vec<Run>; KINDS.len()],
}

impl Curves {
    /// Measures all of `plan`. `each` sees the runs of every cache, with their kinds, or one by paths with none, and
    /// its error or number of paths; it gives the seconds that they would take for all pixels, or `None` to end the
    /// work. Then there are no curves.
    pub fn measure(
        study: &Study,
        plan: &Plan,
        mut each: impl FnMut(&[Kind], f32, &[Run]) -> Option<f64>,
    ) -> Option<Self> {
        let mut curves = Self { paths: Vec::new(), caches: Default::default() };
        for &spp in plan.paths {
            let run = study.paths(spp);
            let seconds = each(&[], spp as f32, &[run])?;
            curves.paths.push(Run { seconds, ..run });
        }
        for &metric in plan.metrics {
            let (numbers, kinds): (Vec<usize>, Vec<Kind>) =
                KINDS.into_iter().enumerate().filter(|(_, kind)| kind.metric == metric).unzip();
            let readings: Vec<Reading> = kinds.iter().map(|kind| kind.reading).collect();
            for &error in plan.errors {
                let options = CachedOptions { error, rays: plan.rays, metric, ..CachedOptions::default() };
                let runs = study.cache(options, &readings);
                let seconds = each(&kinds, error, &runs)?;
                numbers.iter().zip(runs).for_each(|(&number, run)| curves.caches[number].push(Run { seconds, ..run }));
            }
        }
        Some(curves)
    }

    /// The runs by paths.
    pub(super) fn by_paths(&self) -> &[Run] {
        &self.paths
    }

    /// The runs of the kind with this label.
    pub(super) fn of(&self, label: &str) -> &[Run] {
        KINDS.iter().zip(&self.caches).find(|(kind, _)| kind.label == label).map_or(&[], |(_, runs)| runs)
    }

    /// Error against rays or time.
    pub(super) fn figure(&self, name: &'static str, title: &str, cost: Cost) -> Figure {
        let x = match cost {
            Cost::Rays => Axis::logarithmic("rays for 256 × 256 pixels", 2e6, 1e9),
            Cost::Seconds => Axis::logarithmic("processor time for 256 × 256 pixels (s)", 0.1, 300.0),
        };
        let of = |run: &Run| if cost == Cost::Rays { run.rays } else { run.seconds };
        let point = |run: &Run| Point { x: of(run), y: run.error.of_all, error: 0.0 };
        let series = |label, runs: &[Run]| Series::measured(label, runs.iter().map(point).collect());
        let measured = KINDS.iter().zip(&self.caches).filter(|(_, runs)| !runs.is_empty());
        let caches = measured.map(|(kind, runs)| series(kind.label, runs));
        Figure {
            name,
            title: title.to_owned(),
            x,
            y: Axis::logarithmic("relative error of indirect irradiance (root mean square)", 0.005, 1.0),
            series: std::iter::once(series(PATHS, &self.paths)).chain(caches).collect(),
        }
    }

    /// The figure's file.
    pub fn svg(&self, title: &str, cost: Cost) -> String {
        svg(&self.figure("curves", title, cost))
    }
}

/// How many records it takes for an error, and which error so many records have: between neighbouring runs by the
/// straight line through both in logarithms, beyond them by that of the nearest two.
pub(super) fn records_for(runs: &[Run], error: f64) -> f64 {
    along(runs.iter().map(|run| (run.error.of_all, run.records as f64)).collect(), error)
}

/// See [`records_for`].
pub(super) fn error_of(runs: &[Run], records: f64) -> f64 {
    along(runs.iter().map(|run| (run.records as f64, run.error.of_all)).collect(), records)
}

/// How many rays it takes for an error; see [`records_for`].
pub(super) fn rays_for(runs: &[Run], error: f64) -> f64 {
    along(runs.iter().map(|run| (run.error.of_all, run.rays)).collect(), error)
}

/// The value at `x` of the curve through two or more points of positive coordinates.
fn along(mut points: Vec<(f64, f64)>, x: f64) -> f64 {
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let after = points.partition_point(|point| point.0 < x).clamp(1, points.len() - 1);
    let [(x0, y0), (x1, y1)] = [points[after - 1], points[after]];
    y0 * (y1 / y0).powf((x / x0).ln() / (x1 / x0).ln())
}

#[cfg(test)]
mod tests {
    use super::super::study::RelativeError;
    use super::*;

    #[test]
    fn power_laws_are_followed_between_and_beyond() {
        let error = |error: f64| RelativeError { of_all: error, of_most: error };
        let run = |records: usize| Run { records, rays: 0.0, seconds: 0.0, error: error(3.0 / records as f64) };
        let runs: Vec<Run> = [10, 20, 80].map(run).to_vec();
        for records in [5.0, 10.0, 15.0, 40.0, 80.0, 200.0] {
            assert!((error_of(&runs, records) * records / 3.0 - 1.0).abs() < 1e-12);
            assert!((records_for(&runs, 3.0 / records) / records - 1.0).abs() < 1e-12);
        }
    }
}
