//! Arguments of long renders: noise targets, checkpoints and shards.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use super::with_extension;
use crate::film::FILM_EXTENSION;
use crate::settings::{Invalid, Shard};

/// How often checkpoints are written by default.
const INTERVAL: &str = "10m";

/// The limits of a render, and its film.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Long renders")]
pub(in crate::cli) struct FilmArguments {
    /// Stop each tile at this relative error, estimated from its own samples, for example 2%; --spp is the limit, after
    /// which the exit code is 4
    #[arg(long, value_name = "ERROR", allow_hyphen_values = true, value_parser = part)]
    pub(in crate::cli) noise: Option<f64>,

    /// Stop after this time, for example 90s, 30m or 8h, with the picture so far and exit code 4; the picture then
    /// depends on the machine's speed
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = duration)]
    pub(in crate::cli) time: Option<Duration>,

    /// Write the film so far every INTERVAL, so that --resume can continue it: to the output that ends in .hdf, or the
    /// first output's name with .hdf [default: off; 10m without an INTERVAL]
    #[arg(long, value_name = "INTERVAL", num_args = 0..=1, require_equals = false, default_missing_value = INTERVAL)]
    #[arg(value_parser = duration)]
    pub(in crate::cli) checkpoint: Option<Duration>,

    /// Continue the film that --checkpoint wrote, if it exists, and write checkpoints; --spp may be more than before
    #[arg(long)]
    pub(in crate::cli) resume: bool,

    /// Render part K of N, 1 to N, as a film (-o PART.hdf); `halfdome merge` makes the picture of all parts
    #[arg(long, value_name = "K/N", allow_hyphen_values = true, value_parser = shard)]
    shard: Option<Shard>,

    /// Begin with sample number N of each pixel, in a film (-o PART.hdf) to be merged with films of the earlier
    /// samples; --spp is the end
    #[arg(long, value_name = "N", default_value = "0", allow_hyphen_values = true)]
    pub(in crate::cli) first_sample: u32,
}

impl FilmArguments {
    /// The tiles to render.
    pub(in crate::cli) fn shard(&self) -> Shard {
        self.shard.unwrap_or_default()
    }

    /// The part's printed name, if it is a part.
    pub(in crate::cli) fn part(&self) -> Option<String> {
        let shard = self.shard.map(|shard| format!("part {} of {}", shard.number() + 1, shard.count()));
        let samples = (self.first_sample > 0).then(|| format!("from sample {}", self.first_sample));
        let words: Vec<String> = shard.into_iter().chain(samples).collect();
        (!words.is_empty()).then(|| words.join(" "))
    }

    /// How often checkpoints are written, if they are.
    pub(in crate::cli) fn interval(&self) -> Option<Duration> {
        self.checkpoint.or_else(|| self.resume.then(|| duration(INTERVAL).unwrap_or_default()))
    }

    /// Where the film is, if one is kept, and the outputs that are pictures.
    pub(in crate::cli) fn places(&self, outputs: &[PathBuf]) -> Result<(Option<PathBuf>, Vec<PathBuf>), Invalid> {
        let (films, pictures): (Vec<PathBuf>, Vec<PathBuf>) = outputs.iter().cloned().partition(|path| is_film(path));
        if let [_, second, ..] = &films[..] {
            return Err(Invalid::new(format!("{} is a second film", second.display()), "write one film (.hdf)"));
        }
        if let (Some(part), true) = (self.part(), films.is_empty() || !pictures.is_empty()) {
            return Err(Invalid::new(
                format!("{part} is no picture"),
                "write it as a film alone, for example -o part.hdf, and make the picture with `halfdome merge`",
            ));
        }
        if self.noise.is_some() && self.first_sample > 0 {
            let problem = "--noise needs all samples of a pixel, and --first-sample leaves some out";
            return Err(Invalid::new(problem, "share the picture with --shard"));
        }
        let is_kept = self.interval().is_some();
        let beside =
            || pictures.first().map(|path| with_extension(path.with_extension("").as_os_str(), FILM_EXTENSION));
        let film = films.into_iter().next().or_else(|| beside().filter(|_| is_kept));
        Ok((film, pictures))
    }
}

/// Whether a path is that of a film.
pub(in crate::cli) fn is_film(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(FILM_EXTENSION))
}

/// A part of one: `2%` or `0.02`.
fn part(text: &str) -> Result<f64, String> {
    let (number, scale) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
    let value = number.trim().parse().ok().map(|number: f64| number * scale);
    value
        .filter(|value| (1e-4..=1.0).contains(value))
        .ok_or_else(|| "expected a relative error from 0.01% to 100%, for example 2%".to_owned())
}

/// A time: a number with `s`, `m`, `h` or `d`; seconds without.
fn duration(text: &str) -> Result<Duration, String> {
    let (number, unit) = match text.char_indices().next_back() {
        Some((end, 's')) => (&text[..end], 1.0),
        Some((end, 'm')) => (&text[..end], 60.0),
        Some((end, 'h')) => (&text[..end], 3600.0),
        Some((end, 'd')) => (&text[..end], 86_400.0),
        _ => (text, 1.0),
    };
    let seconds = number.parse().ok().map(|number: f64| number * unit);
    seconds
        .filter(|seconds| (0.001..=1e9).contains(seconds))
        .map(Duration::from_secs_f64)
        .ok_or_else(|| "expected a time, for example 90s, 30m or 8h".to_owned())
}

/// `K/N`, both from 1 on.
pub(in crate::cli) fn shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/').and_then(|(number, count)| Some((number.parse().ok()?, count.parse().ok()?)));
    parts
        .and_then(|(number, count): (u32, u32)| Shard::new(number.checked_sub(1)?, count))
        .ok_or_else(|| "expected K/N with K from 1 to N, for example 3/16".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read() {
        assert_eq!((part("2%"), part("0.5")), (Ok(0.02), Ok(0.5)));
        assert!(["0", "-1%", "nan", "", "200%"].iter().all(|text| part(text).is_err()));
        let seconds = |text| duration(text).map(|duration| duration.as_secs_f64());
        assert_eq!(["90", "90s", "1.5m", "2h", "1d"].map(seconds), [90.0, 90.0, 90.0, 7200.0, 86_400.0].map(Ok));
        assert!(["", "m", "-1s", "1w", "inf", "0"].iter().all(|text| duration(text).is_err()));
        assert_eq!((shard("1/1"), shard("3/16")), (Ok(Shard::ALL), Ok(Shard::new(2, 16).unwrap())));
        assert!(["0/4", "5/4", "1", "a/b", "1/0"].iter().all(|text| shard(text).is_err()));
    }
}
