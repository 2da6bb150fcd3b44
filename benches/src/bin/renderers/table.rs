//! The table of scenes made in Blender.

use halfdome_benches::measure::median;
use serde_json::{Value, json};

use crate::error::{Reference, mean};
use crate::renderer::Rendering;
use crate::report::rounded;

/// What one renderer did in all rounds.
#[derive(Default)]
pub(crate) struct Record {
    /// Seconds, one figure a round.
    seconds: Vec<f64>,
    pictures: Vec<Vec<f32>>,
}

impl Record {
    /// Adds a round's picture.
    pub(crate) fn add(&mut self, rendering: Rendering) {
        self.seconds.push(rendering.seconds);
        self.pictures.push(rendering.pixels);
    }

    /// The median of a round's seconds.
    pub(crate) fn seconds(&self) -> f64 {
        median(self.seconds.clone())
    }
}

/// All renderers, the first `ours` of which are ours.
pub(crate) struct Lines<'a> {
    pub(crate) names: &'a [&'a str],
    pub(crate) records: &'a [Record],
    pub(crate) ours: usize,
    pub(crate) reference: &'a Reference,
}

/// Figures of one renderer.
#[derive(Clone, Copy)]
struct Figures {
    seconds: f64,
    error: f64,
    noise: f64,
    brighter: f64,
}

/// One of ours against a peer: below 1 is for us.
struct Ratios {
    samples: f64,
    time: f64,
}

impl Lines<'_> {
    fn figures(&self, record: &Record) -> Figures {
        let over = |figure: &dyn Fn(&[f32]) -> f64| mean(record.pictures.iter().map(|picture| figure(picture)));
        Figures {
            seconds: record.seconds(),
            error: over(&|picture| self.reference.trimmed_error(picture)),
            noise: self.reference.noise(&record.pictures),
            brighter: over(&|picture| self.reference.brighter(picture)),
        }
    }

    /// Cycles is judged by errors against its own reference. Mitsuba's materials are not all glTF's, so its errors are
    /// not noise alone, and noise is what counts.
    fn ratios(name: &str, ours: Figures, peer: Figures) -> Ratios {
        let samples = if name == "mitsuba" { ours.noise / peer.noise } else { ours.error / peer.error };
        Ratios { samples, time: samples * ours.seconds / peer.seconds }
    }

    /// One object for each renderer, ours with ratios to the peers.
    pub(crate) fn json(&self, scene: &str, spp: u32) -> Vec<Value> {
        let figures: Vec<Figures> = self.records.iter().map(|record| self.figures(record)).collect();
        let line = |(number, own): (usize, &Figures)| {
            let mut line = json!({
                "scene": scene, "renderer": self.names[number], "spp": spp, "seconds": rounded(own.seconds),
                "error": rounded(own.error), "noise": rounded(own.noise), "brighter": rounded(own.brighter),
            });
            if number < self.ours {
                for (peer, name) in figures.iter().zip(self.names).skip(self.ours) {
                    let Ratios { samples, time } = Self::ratios(name, *own, *peer);
                    line[format!("to_{name}")] = json!({ "samples": rounded(samples), "time": rounded(time) });
                }
            }
            line
        };
        figures.iter().enumerate().map(line).collect()
    }

    /// A table with what its columns mean.
    pub(crate) fn text(&self, scene: &str, spp: u32, reference_spp: u32) -> String {
        let figures: Vec<Figures> = self.records.iter().map(|record| self.figures(record)).collect();
        let width = self.names.iter().map(|name| name.len()).max().unwrap_or(0).max(8);
        let mut text = format!(
            "{scene}, {spp} samples a pixel; the reference is Cycles' with {reference_spp}, whose own error is {:.5}. \
             Ratios are ours by theirs, at equal\nsamples and at equal time: of errors to Cycles, of noise to Mitsuba.\n\
             {:width$}{:>9}{:>10}{:>10}{:>9}{:>13}",
            self.reference.own_trimmed_error, "", "seconds", "error", "noise", "brighter", "noise × time"
        );
        for name in &self.names[self.ours..] {
            text += &format!(" |{:>17}", format!("to {name}"));
        }
        for (number, own) in figures.iter().enumerate() {
            let Figures { seconds, error, noise, brighter } = *own;
            let cost = noise * seconds;
            let brighter = 100.0 * brighter;
            text += &format!(
                "\n{:width$}{seconds:9.2}{error:10.5}{noise:10.5}{brighter:+8.2}%{cost:13.5}",
                self.names[number]
            );
            for (peer, name) in figures.iter().zip(self.names).skip(self.ours).take_while(|_| number < self.ours) {
                let Ratios { samples, time } = Self::ratios(name, *own, *peer);
                text += &format!(" |{samples:8.3}{time:9.3}");
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_below_one_are_for_us() {
        let reference = Reference::new(&[1.0; 6], &[1.0; 6]);
        let record = |seconds: f64, error: f32| {
            let mut record = Record::default();
            for sign in [1.0, -1.0] {
                record.add(Rendering { pixels: vec![1.0 + sign * error; 6], seconds, rays: None });
            }
            record
        };
        let records = [record(1.0, 0.125), record(4.0, 0.25), record(2.0, 0.5)];
        let names = ["halfdome", "cycles", "mitsuba"];
        let lines = Lines { names: &names, records: &records, ours: 1, reference: &reference };
        let [ours, cycles, _] = &lines.json("yard", 16)[..] else { panic!("three lines") };
        assert_eq!(ours["to_cycles"], json!({ "samples": 0.25, "time": 0.0625 }));
        assert_eq!(ours["to_mitsuba"], json!({ "samples": 0.0625, "time": 0.031_25 }));
        assert_eq!((&ours["error"], &ours["brighter"]), (&json!(rounded(0.015_625 / 1.01)), &json!(0.0)));
        // Of two pictures, the variance is twice the square of what each is off their mean.
        assert_eq!(ours["noise"], json!(rounded(0.031_25 / 1.01)));
        assert_eq!(cycles.get("to_cycles"), None);
        let text = lines.text("yard", 16, 1024);
        let widths: Vec<usize> = text.lines().skip(2).map(|line| line.chars().count()).collect();
        assert_eq!((widths.len(), widths[0]), (4, widths[1]));
    }
}
