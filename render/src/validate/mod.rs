//! Validation: scenes whose answer is known exactly, rendered as experiments.
//!
//! An experiment measures one number through the public library, scene to picture, and compares it with a closed form.
//! Where it measures many, as in a series over bounces, the number is the largest distance from the exact values in
//! standard errors. Results depend on the seed and the effort alone.

mod cache;
mod convergence;
mod exact;
mod furnace;
mod lights;
mod materials;
mod report;
mod room;
mod runner;
mod scenes;
mod statistics;

use crate::output::plot::Figure;
use crate::settings::Invalid;

pub(crate) use report::{Row, json, list};
pub(crate) use runner::{Effort, Interrupted, Runner};

pub use cache::{Cost, Curves, KINDS, Kind, Places, Plan, Reference, RelativeError, Run, Study, Walls};
pub use room::furnished_room;
use statistics::Sample;

/// Experiments about one thing; their names begin with the family's and a hyphen.
pub(crate) struct Family {
    /// One word.
    pub name: &'static str,
    /// The subject, as a sentence without a full stop.
    pub about: &'static str,
    /// In the order in which they run.
    pub experiments: &'static [Experiment],
}

/// Something to measure.
pub(crate) struct Experiment {
    /// Unique, in kebab-case.
    pub name: &'static str,
    /// The measured quantity, as a sentence without a full stop.
    pub about: &'static str,
    run: fn(&Runner) -> Result<Outcome, Interrupted>,
}

/// The result of an experiment.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    /// The meaning of `measured`.
    pub quantity: String,
    /// The number found.
    pub measured: f64,
    /// The number that it should be.
    pub expected: f64,
    /// The allowed difference.
    pub tolerance: f64,
    /// Intermediate measurements.
    pub figure: Option<Figure>,
}

/// Every family, in the order in which they run.
pub(crate) const FAMILIES: [&Family; 5] =
    [&furnace::FAMILY, &lights::FAMILY, &convergence::FAMILY, &materials::FAMILY, &cache::FAMILY];

/// How many standard errors a mean may be off: one in 16,000 is, of those that are right.
const MAX_Z: f64 = 4.0;

/// The experiments of which `names` has the name, or its beginning up to a hyphen; all of them without names.
///
/// # Errors
/// A name that is not that of an experiment or family.
pub(crate) fn select(names: &[String]) -> Result<Vec<&'static Experiment>, Invalid> {
    let all = || FAMILIES.into_iter().flat_map(|family| family.experiments);
    let selects = |name: &String, experiment: &Experiment| {
        let rest = experiment.name.strip_prefix(name.as_str());
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
    };
    if let Some(unknown) = names.iter().find(|name| !all().any(|experiment| selects(name, experiment))) {
        let families: Vec<_> = FAMILIES.iter().map(|family| family.name).collect();
        return Err(Invalid::new(
            format!("there is no experiment {unknown:?}"),
            format!("name a family ({}) or an experiment; --list shows all of them", families.join(", ")),
        ));
    }
    Ok(all().filter(|experiment| names.is_empty() || names.iter().any(|name| selects(name, experiment))).collect())
}

/// The greatest of values, or one that is not a number, which `f64::max` would pass over.
fn worst(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |worst, value| if value <= worst || worst.is_nan() { worst } else { value })
}

impl Experiment {
    /// Measures, with random numbers that no other experiment uses.
    ///
    /// # Errors
    /// [`Interrupted`] if the lab's watcher says stop.
    pub(crate) fn run(&self, runner: &Runner) -> Result<Outcome, Interrupted> {
        (self.run)(&runner.for_experiment(self.name))
    }
}

impl Outcome {
    /// A mean that should be `exact`, which itself is known to the relative uncertainty `allowance`.
    fn mean(quantity: &str, sample: &Sample, exact: f64, allowance: f64) -> Self {
        let tolerance = MAX_Z * sample.standard_error().hypot(allowance * exact);
        Self { quantity: quantity.to_owned(), measured: sample.mean, expected: exact, tolerance, figure: None }
    }

    /// The largest distance of several means from their exact values, in standard errors.
    fn worst_z(z: impl IntoIterator<Item = f64>) -> Self {
        let measured = worst(z.into_iter().map(f64::abs));
        Self { quantity: "worst |z|".to_owned(), measured, expected: 0.0, tolerance: MAX_Z, figure: None }
    }

    /// The same outcome with a figure.
    fn with(self, figure: Figure) -> Self {
        Self { figure: Some(figure), ..self }
    }

    /// Whether the number is what it should be.
    pub(crate) fn pass(&self) -> bool {
        (self.measured - self.expected).abs() <= self.tolerance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_those_of_their_families() {
        let mut names = Vec::new();
        for family in FAMILIES {
            for experiment in family.experiments {
                let rest = experiment.name.strip_prefix(family.name).and_then(|rest| rest.strip_prefix('-'));
                let kebab =
                    |rest: &str| rest.bytes().all(|b| b == b'-' || b.is_ascii_lowercase() || b.is_ascii_digit());
                assert!(rest.is_some_and(|rest| !rest.is_empty() && kebab(rest)), "{}", experiment.name);
                assert!(!experiment.about.ends_with('.') && !experiment.about.is_empty());
                names.push(experiment.name);
            }
        }
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }

    #[test]
    fn names_select_experiments_and_families() {
        let names = |given: &[&str]| -> Vec<&str> {
            let given: Vec<_> = given.iter().map(|&name| name.to_owned()).collect();
            select(&given).unwrap().into_iter().map(|experiment| experiment.name).collect()
        };
        assert_eq!(names(&["furnace-sphere"]), ["furnace-sphere"]);
        assert_eq!(names(&["furnace"]).len(), furnace::FAMILY.experiments.len());
        assert_eq!(names(&["materials", "furnace-sphere"]).len(), 1 + materials::FAMILY.experiments.len());
        assert_eq!(names(&[]).len(), FAMILIES.iter().map(|family| family.experiments.len()).sum::<usize>());
        for unknown in ["furn", "furnace-", "", "Furnace", "furnace-spheres"] {
            let error = select(&[unknown.to_owned()]).err().unwrap();
            assert!(error.problem.contains(unknown) && error.remedy.contains("furnace, lights"), "{error}");
        }
    }

    #[test]
    fn outcomes_pass_within_their_tolerance_alone() {
        let outcome = |measured| Outcome { measured, ..Outcome::worst_z([]) };
        assert!(outcome(4.0).pass() && outcome(-4.0).pass());
        assert!(!outcome(4.1).pass() && !outcome(f64::NAN).pass() && !outcome(f64::INFINITY).pass());
        assert_eq!(Outcome::worst_z([1.0, -3.0, 2.0]).measured, 3.0);
        assert!(!Outcome::worst_z([1.0, f64::NAN, 2.0]).pass());
        let sample = Sample::of(&[1.0, 2.0, 3.0, 2.0]);
        let mean = Outcome::mean("radiance", &sample, 2.5, 1e-9);
        assert!((mean.tolerance - 4.0 * (1.0f64 / 6.0).sqrt()).abs() < 1e-6 && mean.pass());
    }
}
