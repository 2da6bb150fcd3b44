//! Reports of experiments, as text and as JSON.

use std::fmt::Write as _;

use serde_json::json;

use super::{Experiment, FAMILIES, Outcome};

/// Lays rows out so that their columns stand below each other, although they are printed one by one.
pub(crate) struct Row {
    name_width: usize,
}

impl Row {
    /// For a table of these experiments.
    pub(crate) fn for_table(experiments: &[&Experiment]) -> Self {
        let names = experiments.iter().map(|experiment| experiment.name.len());
        Self { name_width: names.fold("experiment".len(), usize::max) }
    }

    /// The table's head.
    pub(crate) fn head(&self) -> String {
        let width = self.name_width;
        format!("      {:width$}  {:>11}  {:>9}  {:>10}  {}\n", "experiment", "measured", "expected", "tolerance", "of")
    }

    /// An outcome.
    pub(crate) fn outcome(&self, experiment: &Experiment, outcome: &Outcome) -> String {
        let width = self.name_width;
        let state = if outcome.pass() { "pass" } else { "FAIL" };
        let Outcome { quantity, measured, expected, tolerance, .. } = outcome;
        format!(
            "{state}  {:width$}  {:>11}  {:>9}  {:>10}  {quantity}\n",
            experiment.name,
            short(*measured),
            short(*expected),
            format!("±{}", short(*tolerance)),
        )
    }
}

/// Five digits of a number, without trailing zeros.
fn short(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) {
        return format!("{value:.2e}");
    }
    let digits = (4 - value.abs().max(1.0).log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// An outcome as a line of JSON; a measured value that is not a finite number is null, and has failed.
pub(crate) fn json(experiment: &Experiment, outcome: &Outcome) -> String {
    let line = json!({
        "name": experiment.name,
        "quantity": outcome.quantity,
        "measured": outcome.measured,
        "expected": outcome.expected,
        "tolerance": outcome.tolerance,
        "pass": outcome.pass(),
    });
    format!("{line}\n")
}

/// All experiments and what they are about.
pub(crate) fn list() -> String {
    let names = FAMILIES.iter().flat_map(|family| family.experiments).map(|experiment| experiment.name.len());
    let width = names.max().unwrap_or(0);
    let mut text = String::new();
    for family in FAMILIES {
        let _ = writeln!(text, "{}: {}", family.name, family.about);
        for Experiment { name, about, .. } in family.experiments {
            let _ = writeln!(text, "  {name:width$}  {about}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;
    use crate::validate::Interrupted;

    const EXPERIMENT: Experiment = Experiment { name: "furnace-x", about: "Nothing", run: |_| Err(Interrupted) };

    fn outcome(measured: f64) -> Outcome {
        Outcome { quantity: "radiance".into(), measured, expected: 2.0, tolerance: 0.25, figure: None }
    }

    #[test]
    fn lines_of_json_have_all_digits() {
        let line = json(&EXPERIMENT, &outcome(2.000_000_000_000_1));
        assert!(line.ends_with("}\n") && line.matches('\n').count() == 1);
        let value: Value = serde_json::from_str(&line).unwrap();
        assert_eq!(value["name"], "furnace-x");
        assert_eq!(value["measured"].as_f64(), Some(2.000_000_000_000_1));
        assert_eq!((value["expected"].as_f64(), value["tolerance"].as_f64()), (Some(2.0), Some(0.25)));
        assert_eq!(value["pass"], true);
        for broken in [f64::NAN, f64::INFINITY] {
            let value: Value = serde_json::from_str(&json(&EXPERIMENT, &outcome(broken))).unwrap();
            assert_eq!((&value["measured"], &value["pass"]), (&Value::Null, &false.into()));
        }
    }

    #[test]
    fn rows_stand_below_each_other() {
        let rows = Row::for_table(&[&EXPERIMENT]);
        let (head, row) = (rows.head(), rows.outcome(&EXPERIMENT, &outcome(2.0001)));
        assert_eq!(row, "pass  furnace-x        2.0001          2       ±0.25  radiance\n");
        assert_eq!(head.find("of"), row.replace('±', "+").find("radiance"));
        assert!(rows.outcome(&EXPERIMENT, &outcome(3.0)).starts_with("FAIL"));
    }

    #[test]
    fn short_numbers_have_five_digits() {
        let cases =
            [(0.0, "0"), (2.0, "2"), (1.99996, "2"), (0.12345678, "0.1235"), (12_345.6, "12346"), (1e-5, "1.00e-5")];
        for (value, text) in cases {
            assert_eq!(short(value), text);
        }
        assert_eq!(short(-123.456), "-123.46");
        assert_eq!(short(f64::NAN), "NaN");
    }

    #[test]
    fn the_list_names_every_experiment_and_family() {
        let list = list();
        for family in FAMILIES {
            assert!(list.contains(&format!("{}: ", family.name)));
            assert!(family.experiments.iter().all(|experiment| list.contains(&format!("  {} ", experiment.name))));
        }
    }
}
