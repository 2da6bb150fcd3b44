//! The output: a table, or one JSON object a line.

use halfdome_benches::measure::median;
use serde_json::{Value, json};

use crate::error::{Reference, mean};
use crate::renderer::Rendering;

/// What all renderers have in common.
pub(crate) struct Task {
    /// Samples a pixel.
    pub(crate) spp: u32,
    /// Pixels.
    pub(crate) pixels: u32,
    /// Samples a pixel of the reference.
    pub(crate) reference_spp: u32,
}

/// What one renderer did in all rounds.
#[derive(Default)]
pub(crate) struct Record {
    /// Seconds, one figure a round.
    seconds: Vec<f64>,
    /// The rays of a picture.
    rays: Option<u64>,
    absolute: Errors,
    relative: Errors,
    brighter: Vec<f64>,
}

/// Mean squared errors, one figure a round, by one of the two measures.
#[derive(Default)]
struct Errors {
    /// The samples of the timed pictures.
    mse: Vec<f64>,
    /// Of pictures with one sample a pixel.
    single_mse: Vec<f64>,
}

impl Errors {
    fn mse(&self) -> f64 {
        mean(self.mse.iter().copied())
    }

    fn rmse(&self) -> f64 {
        self.mse().sqrt()
    }

    /// How many times the variance would be this if samples were independent: single samples are.
    fn variance_ratio(&self, task: &Task) -> f64 {
        mean(self.single_mse.iter().copied()) / f64::from(task.spp) / self.mse()
    }
}

impl Record {
    /// Adds a round's picture.
    pub(crate) fn add(&mut self, rendering: &Rendering, reference: &Reference) {
        self.seconds.push(rendering.seconds);
        self.rays = rendering.rays;
        self.absolute.mse.push(reference.mse(&rendering.pixels));
        self.relative.mse.push(reference.relative_mse(&rendering.pixels));
        self.brighter.push(reference.brighter(&rendering.pixels));
    }

    /// Adds a picture of one sample a pixel.
    pub(crate) fn add_single(&mut self, rendering: &Rendering, reference: &Reference) {
        self.absolute.single_mse.push(reference.mse(&rendering.pixels));
        self.relative.single_mse.push(reference.relative_mse(&rendering.pixels));
    }

    /// The median of a round's seconds.
    fn seconds(&self) -> f64 {
        median(self.seconds.clone())
    }

    fn paths_per_second(&self, task: &Task) -> f64 {
        f64::from(task.spp) * f64::from(task.pixels) / self.seconds()
    }

    fn rays_per_path(&self, task: &Task) -> Option<f64> {
        self.rays.map(|rays| rays as f64 / (f64::from(task.spp) * f64::from(task.pixels)))
    }

    /// The median over the rounds of how many times as fast as `other` this was.
    fn speed_ratio(&self, other: &Self) -> f64 {
        median(other.seconds.iter().zip(&self.seconds).map(|(other, own)| other / own).collect())
    }

    fn brighter(&self) -> f64 {
        mean(self.brighter.iter().copied())
    }
}

/// A renderer's name, what it says about itself, and what it did.
pub(crate) struct Line<'a> {
    pub(crate) name: &'a str,
    pub(crate) about: &'a str,
    pub(crate) record: &'a Record,
    /// What ours did in the same rounds.
    pub(crate) ours: &'a Record,
}

impl Line<'_> {
    /// The line of machines. `speed_ratio` is how many times as fast as this renderer ours is, the error ratios are its
    /// root mean squared errors by ours: more than one is for us.
    pub(crate) fn json(&self, task: &Task) -> Value {
        let Self { name, about, record, ours } = self;
        let Record { absolute, relative, .. } = record;
        let rays_per_path = record.rays_per_path(task);
        json!({
            "renderer": name,
            "about": about,
            "spp": task.spp,
            "seconds": rounded(record.seconds()),
            "paths_per_second": record.paths_per_second(task).round(),
            "rays_per_path": rays_per_path.map(rounded),
            "rays_per_second": rays_per_path.map(|rays| (rays * record.paths_per_second(task)).round()),
            "speed_ratio": rounded(ours.speed_ratio(record)),
            "rmse": rounded(absolute.rmse()),
            "error_ratio": rounded(absolute.rmse() / ours.absolute.rmse()),
            "variance_ratio": rounded(absolute.variance_ratio(task)),
            "relative_mse": rounded(relative.mse()),
            "relative_error_ratio": rounded(relative.rmse() / ours.relative.rmse()),
            "relative_variance_ratio": rounded(relative.variance_ratio(task)),
            "brighter": rounded(record.brighter()),
        })
    }

    /// The line of people, under [`heading`].
    pub(crate) fn text(&self, task: &Task) -> String {
        let Self { name, record, ours, .. } = self;
        let Record { absolute, relative, .. } = record;
        let rays = record.rays_per_path(task).map_or_else(|| "-".to_owned(), |rays| format!("{rays:.2}"));
        format!(
            "{name:16}{:9.3}{:10.3}{rays:>7}{:7.2} |{:9.5}{:7.3}{:10.2} |{:9.5}{:7.3}{:10.2} |{:+8.3}%",
            record.seconds(),
            record.paths_per_second(task) / 1e6,
            ours.speed_ratio(record),
            absolute.rmse(),
            absolute.rmse() / ours.absolute.rmse(),
            absolute.variance_ratio(task),
            relative.mse(),
            relative.rmse() / ours.relative.rmse(),
            relative.variance_ratio(task),
            100.0 * record.brighter(),
        )
    }
}

/// What stands above the lines of [`Line::text`].
pub(crate) fn heading() -> String {
    let errors = |name| format!(" |{name:>9}{:>7}{:>10}", "times", "variance");
    let speed = format!("{:16}{:>9}{:>10}{:>7}{:>7}", "", "seconds", "Mpaths/s", "rays", "times");
    format!("{speed}{}{} |{:>9}", errors("RMSE"), errors("rel. MSE"), "brighter")
}

/// The reference as a line for machines.
pub(crate) fn reference_json(reference: &Reference, task: &Task) -> Value {
    json!({
        "reference": "halfdome",
        "spp": task.reference_spp,
        "rmse": rounded(reference.rmse),
        "mean": rounded(reference.mean()),
    })
}

/// The reference for people, and what the columns mean.
pub(crate) fn reference_text(reference: &Reference, task: &Task) -> String {
    let Task { spp, pixels, reference_spp } = task;
    format!(
        "Cornell box, {pixels} pixels, {spp} samples each. The reference has {reference_spp}, a mean of {:.5}, and by \
         its two halves an RMSE of {:.1e}.\nrays: a path. times: how many times as fast as it ours is, and its root \
         mean squared errors by ours. variance: that of independent\nsamples by its own.",
        reference.mean(),
        reference.rmse,
    )
}

/// To six digits: more is noise.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TASK: Task = Task { spp: 4, pixels: 2, reference_spp: 16 };

    fn record(seconds: &[f64], error: f32, single_error: f32, rays: Option<u64>) -> Record {
        let reference = Reference::new(&[1.0, 1.0], &[1.0, 1.0]);
        let rendering = |error, seconds| Rendering { pixels: vec![1.0 + error, 1.0 - error], seconds, rays };
        let mut record = Record::default();
        for &seconds in seconds {
            record.add(&rendering(error, seconds), &reference);
        }
        record.add_single(&rendering(single_error, 1.0), &reference);
        record
    }

    #[test]
    fn ratios_above_one_are_for_us() {
        // Both slow down in the second round, and the ratio does not.
        let ours = record(&[0.5, 1.0, 0.25], 0.125, 0.5, Some(96));
        let peer = record(&[1.0, 2.0, 0.5], 0.25, 0.5, None);
        let line = Line { name: "peer", about: "Peer 1", record: &peer, ours: &ours };
        let expected = json!({
            "renderer": "peer", "about": "Peer 1", "spp": 4, "seconds": 1.0, "paths_per_second": 8.0,
            "rays_per_path": null, "rays_per_second": null, "speed_ratio": 2.0,
            "rmse": 0.25, "error_ratio": 2.0, "variance_ratio": 1.0, "relative_mse": 0.061_881_2,
            "relative_error_ratio": 2.0, "relative_variance_ratio": 1.0, "brighter": 0.0,
        });
        assert_eq!(line.json(&TASK), expected);
        assert_eq!(line.text(&TASK).len(), heading().len());
        let line = Line { name: "halfdome", about: "ours", record: &ours, ours: &ours }.json(&TASK);
        assert_eq!((&line["speed_ratio"], &line["error_ratio"]), (&json!(1.0), &json!(1.0)));
        assert_eq!((&line["rays_per_path"], &line["rays_per_second"]), (&json!(12.0), &json!(192.0)));
        // Four samples have a sixteenth of one sample's variance, where independent ones have a quarter.
        assert_eq!((&line["variance_ratio"], &line["relative_variance_ratio"]), (&json!(4.0), &json!(4.0)));
    }

    #[test]
    fn figures_have_six_digits() {
        assert_eq!(rounded(1_234_567.8), 1_234_570.0);
        assert_eq!(rounded(0.001_234_567_8), 0.001_234_57);
        assert_eq!(rounded(0.0), 0.0);
    }

    #[test]
    fn the_reference_says_its_own_error() {
        let reference = Reference::new(&[0.5, 3.5], &[1.5, 4.5]);
        let line = reference_json(&reference, &TASK);
        assert_eq!(line, json!({ "reference": "halfdome", "spp": 16, "rmse": 0.5, "mean": 2.5 }));
        assert!(reference_text(&reference, &TASK).contains("an RMSE of 5.0e-1"));
    }
}
