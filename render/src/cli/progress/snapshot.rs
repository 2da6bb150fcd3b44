//! The progress of a command at a moment, as a line of JSON and as the text beside a bar.

use std::time::Duration;

use serde_json::{Value, json};

/// The unit of the count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Counted {
    /// Samples.
    Samples,
    /// Samples, after irradiance records.
    Records,
    /// Texels, and irradiance records.
    Texels,
    /// Texels alone.
    PlainTexels,
    /// Parts of a picture that is denoised.
    Parts,
    /// Thousandths of a layout that is unwrapped, and then how often it is packed.
    Layout,
}

/// The progress of a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Snapshot {
    pub(super) samples: u64,
    /// 0 if unknown.
    pub(super) total: u64,
    pub(super) rays: u64,
    /// Irradiance records made, or how often a layout is packed.
    pub(super) records: u64,
    pub(super) counted: Counted,
    /// Since the command's work began.
    pub(super) elapsed: Duration,
    /// Since what is counted was begun.
    pub(super) counting: Duration,
    /// Samples taken at a known pace, and how long that took; it was begun after all that is not counted.
    pub(super) pace: Option<(u64, Duration)>,
}

impl Snapshot {
    /// The finished fraction, 0 to 1, if known.
    pub(super) fn done(&self) -> Option<f64> {
        let is_packed = self.counted == Counted::Layout && self.records > 0;
        (self.total > 0 && !is_packed).then(|| (self.samples as f64 / self.total as f64).min(1.0))
    }

    /// Seconds left if the rest goes as fast; unknown at the beginning, and where steps differ: a cache's last texels
    /// take as long as all before.
    fn remaining(&self) -> Option<f64> {
        let (samples, time) = self.pace.filter(|(samples, _)| *samples > 0)?;
        let is_even = !matches!(self.counted, Counted::Texels | Counted::Layout) && self.total > 0;
        is_even.then(|| time.as_secs_f64() * self.total.saturating_sub(self.samples) as f64 / samples as f64)
    }

    pub(super) fn json(&self) -> Value {
        let mut event = json!({
            "event": "progress",
            "done": self.done(),
            "rays": self.rays,
            "rays_per_second": per_second(self.rays, self.counting),
            "elapsed": self.elapsed.as_secs_f64(),
            "remaining": self.remaining(),
        });
        if self.is_of_texels() {
            event["texels"] = self.samples.into();
        }
        if self.counted == Counted::Layout {
            let (stage, tries) =
                if self.records == 0 { ("unwrap", Value::Null) } else { ("pack", self.records.into()) };
            return json!({
                "event": "progress", "stage": stage, "done": event["done"], "tries": tries,
                "elapsed": event["elapsed"], "remaining": null,
            });
        }
        if self.counted == Counted::Parts {
            return json!({
                "event": "progress", "stage": "denoise", "done": event["done"], "elapsed": event["elapsed"],
                "remaining": event["remaining"],
            });
        }
        if self.counted != Counted::Samples {
            event["records"] = self.records.into();
        }
        event
    }

    fn is_of_texels(&self) -> bool {
        matches!(self.counted, Counted::Texels | Counted::PlainTexels)
    }

    pub(super) fn message(&self) -> String {
        let samples = per_second(self.samples, self.counting) / 1e6;
        let rays = per_second(self.rays, self.counting) / 1e6;
        let left = self.remaining().map_or("--:--".to_owned(), clock);
        let Self { samples: texels, total, records, .. } = self;
        match self.counted {
            Counted::Samples => format!("{samples:.2} Msamples/s  {rays:.1} Mrays/s  {left} left"),
            Counted::Records => format!("{records} records  {rays:.1} Mrays/s  {left} left"),
            Counted::Parts => format!("denoising  {left} left"),
            Counted::Layout if *records == 0 => "unwrapping".to_owned(),
            Counted::Layout => format!("packing charts, try {records}"),
            Counted::Texels | Counted::PlainTexels => {
                format!("{texels}/{total} texels  {records} records  {rays:.1} Mrays/s  {left} left")
            }
        }
    }
}

/// `count` in a second, zero in no time.
pub(in crate::cli) fn per_second(count: u64, elapsed: Duration) -> f64 {
    let seconds = elapsed.as_secs_f64();
    if seconds > 0.0 { count as f64 / seconds } else { 0.0 }
}

/// Minutes and seconds, with hours if there are any.
fn clock(seconds: f64) -> String {
    let seconds = seconds.round() as u64;
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    if hours > 0 { format!("{hours}:{minutes:02}:{seconds:02}") } else { format!("{minutes:02}:{seconds:02}") }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::cli::progress::pace::Pace;

    pub(in super::super) const HALF: Snapshot = Snapshot {
        samples: 50,
        total: 100,
        rays: 3_000_000,
        records: 7,
        counted: Counted::Samples,
        elapsed: Duration::from_secs(2),
        counting: Duration::from_secs(2),
        pace: Some((50, Duration::from_secs(2))),
    };

    #[test]
    fn a_line_is_valid_json_with_the_promised_keys() {
        let line = HALF.json().to_string();
        assert!(!line.contains('\n'));
        let value: Value = serde_json::from_str(&line).unwrap();
        let expected = json!({
            "event": "progress", "done": 0.5, "rays": 3_000_000, "rays_per_second": 1.5e6, "elapsed": 2.0,
            "remaining": 2.0
        });
        assert_eq!(value, expected);
    }

    #[test]
    fn the_first_line_has_no_infinities() {
        let first =
            Snapshot { samples: 0, rays: 0, elapsed: Duration::ZERO, counting: Duration::ZERO, pace: None, ..HALF };
        let value: Value = serde_json::from_str(&first.json().to_string()).unwrap();
        assert_eq!(value["remaining"], Value::Null);
        assert_eq!(value["rays_per_second"], 0.0);
        assert_eq!(first.message(), "0.00 Msamples/s  0.0 Mrays/s  --:-- left");
    }

    #[test]
    fn the_bar_says_rates_and_time_left() {
        assert_eq!(HALF.message(), "0.00 Msamples/s  1.5 Mrays/s  00:02 left");
        let texels = Snapshot { counted: Counted::PlainTexels, ..HALF };
        assert_eq!(texels.message(), "50/100 texels  7 records  1.5 Mrays/s  00:02 left");
        assert_eq!((&texels.json()["texels"], &texels.json()["records"]), (&50.into(), &7.into()));
        let records = Snapshot { counted: Counted::Records, total: 0, ..HALF };
        assert_eq!(records.message(), "7 records  1.5 Mrays/s  --:-- left");
        let parts = Snapshot { counted: Counted::Parts, ..HALF };
        assert_eq!(parts.message(), "denoising  00:02 left");
        assert_eq!((&parts.json()["stage"], &parts.json()["rays"]), (&"denoise".into(), &Value::Null));
        let unknown = records.json();
        let expected = [&Value::Null, &Value::Null, &7.into()];
        assert_eq!([&unknown["done"], &unknown["remaining"], &unknown["records"]], expected);
        assert_eq!(clock(3_725.4), "1:02:05");
        assert_eq!(clock(59.6), "01:00");
    }

    #[test]
    fn nothing_is_said_of_the_time_that_a_cache_takes() {
        let texels = Snapshot { counted: Counted::Texels, ..HALF };
        assert_eq!(texels.message(), "50/100 texels  7 records  1.5 Mrays/s  --:-- left");
        let event = texels.json();
        assert_eq!((&event["done"], &event["remaining"], &event["texels"]), (&0.5.into(), &Value::Null, &50.into()));
    }

    #[test]
    fn time_before_the_first_sample_is_not_its_pace() {
        let (mut pace, seconds) = (Pace::default(), Duration::from_secs);
        assert_eq!(pace.at(0, seconds(60)), (0, None));
        let (samples, taken) = pace.at(10, seconds(61));
        let now = Snapshot { samples, pace: taken, elapsed: seconds(70), counting: seconds(61), ..HALF };
        assert_eq!(now.remaining(), Some(9.0));
        assert_eq!(now.json()["elapsed"], 70.0);
        // Not even if the counters go back.
        assert_eq!(pace.at(5, seconds(62)), (10, Some((10, seconds(2)))));
    }
}
