//! Arguments of sequences: which frames, and the names of their pictures.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::settings::Invalid;

/// Frames to render, one after the other.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Sequences")]
pub(in crate::cli) struct SequenceArguments {
    /// Render frames A to B, both included; -o needs a #, or several, for the number: out.####.exr is out.0012.exr
    #[arg(long, value_name = "A..B", value_parser = frames, allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["frame", "progressive"])]
    pub(in crate::cli) frames: Option<RangeInclusive<i32>>,

    /// Render every Nth of the frames
    #[arg(long, value_name = "N", default_value = "1", allow_hyphen_values = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    #[arg(requires = "frames")]
    step: u32,

    /// Skip frames whose pictures all exist and are not empty; otherwise they are rendered again. Not with --resume or
    /// --checkpoint, with which an interrupted frame has a picture
    #[arg(long, requires = "frames")]
    pub(in crate::cli) skip_existing: bool,
}

impl SequenceArguments {
    /// The frames' numbers, if a sequence is asked for.
    pub(in crate::cli) fn numbers(&self) -> Option<impl Iterator<Item = i32> + use<>> {
        self.frames.clone().map(|frames| frames.step_by(self.step as usize))
    }
}

fn frames(text: &str) -> Result<RangeInclusive<i32>, String> {
    let number = |text: &str| text.trim().parse::<i32>().ok().filter(|frame| frame.abs() <= 1_000_000);
    let ends = text.split_once("..").and_then(|(from, to)| Some((number(from)?, number(to)?)));
    match ends {
        Some((from, to)) if from <= to => Ok(from..=to),
        Some((from, to)) => Err(format!("the first frame {from} is after the last one {to}; frames go upwards")),
        None => Err("expected the first and the last frame, for example 1..250".to_owned()),
    }
}

/// The name with the frame's number in place of the last `#` or row of them, with zeros in front to its length.
pub(super) fn numbered(path: &Path, frame: i32) -> Result<PathBuf, Invalid> {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let Some(end) = name.rfind('#').map(|last| last + 1) else {
        let problem = format!("{} has no place for the frame's number", path.display());
        let stem = path.with_extension("####");
        let example = match path.extension() {
            Some(extension) => format!("{}.{}", stem.display(), extension.display()),
            None => stem.display().to_string(),
        };
        return Err(Invalid::new(problem, format!("write # where it goes: {example}")));
    };
    let start = name[..end].trim_end_matches('#').len();
    let width = end - start + usize::from(frame < 0);
    Ok(path.with_file_name(format!("{}{frame:0width$}{}", &name[..start], &name[end..])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_take_the_place_of_the_last_row() {
        let name = |path: &str, frame| numbered(Path::new(path), frame).unwrap();
        assert_eq!(name("a/out.####.exr", 12), Path::new("a/out.0012.exr"));
        assert_eq!(name("#1/a#b###.png", 7), Path::new("#1/a#b007.png"));
        assert_eq!(name("f#.png", 1234), Path::new("f1234.png"));
        assert_eq!(name("f###.png", -3), Path::new("f-003.png"));
        let error = numbered(Path::new("a#/out.exr"), 1).unwrap_err();
        assert_eq!(error.problem, "a#/out.exr has no place for the frame's number");
        assert_eq!(error.remedy, "write # where it goes: a#/out.####.exr");
    }

    #[test]
    fn frames_go_upwards() {
        assert_eq!(frames("1..250"), Ok(1..=250));
        assert_eq!(frames("-3..-3"), Ok(-3..=-3));
        for wrong in ["", "1", "1..", "..2", "1...2", "2..1", "1..1e9", "1.5..2"] {
            assert!(frames(wrong).is_err(), "{wrong}");
        }
        let arguments = SequenceArguments { frames: Some(1..=10), step: 4, skip_existing: false };
        assert_eq!(arguments.numbers().unwrap().collect::<Vec<_>>(), [1, 5, 9]);
    }
}
