//! Renders scenes with our path tracer, Mitsuba 3 and Blender's Cycles, one thread each, in turns, and compares time
//! and error.
//!
//! `setup-renderers.sh` installs the peers, which scripts in `benches/renderers` run; without one its line is missing.
//! All have the same scene, camera, box filter, and direct light by multiple importance sampling. Time is the
//! processor's, so that it counts on a busy machine too.
//!
//! `cornell` is our own scene, handed over as numbers. The others are made in Blender by the scripts in
//! `benches/renderers/scenes` and exported as glTF, as a user's are; they need Cycles.

mod cornell;
mod error;
mod model;
mod peer;
mod reference_cache;
mod renderer;
mod report;
mod scene;
mod side_by_side;
mod table;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

/// Our own scene.
const CORNELL: &str = "cornell";
/// Those that are made in Blender.
const MODELS: [&str; 19] = [
    "yard", "bulbs", "window", "glazed", "hdri", "interior", "ajar", "street", "loft", "shop", "lounge", "chapel",
    "studio", "market", "bath", "park", "station", "pendants", "vanity",
];
/// Seeds of the reference's halves, which no round has.
const REFERENCE_SEEDS: [u32; 2] = [1 << 20, 2 << 20];

/// Compares our path tracer with other renderers.
#[derive(Parser)]
struct Options {
    /// What to render: cornell, yard, bulbs, window, glazed, hdri, interior, ajar, street, loft, shop, lounge, chapel,
    /// studio, market, bath, park, station, pendants, vanity
    #[arg(value_name = "SCENE", default_values_t = [CORNELL.to_owned()], value_parser = known)]
    scenes: Vec<String>,
    /// Samples a pixel [default: 64 for cornell, else 16]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Pixels across and down [default: 256x256 for cornell, else 320x240]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<(u32, u32)>,
    /// How often each renderer renders; noise takes two
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..1 << 19))]
    rounds: u32,
    /// Samples a pixel of each of the reference's two halves [default: 4096 for cornell, else 512]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..1 << 30))]
    reference: Option<u32>,
    /// Options of `halfdome render` for a line of ours, as one argument: --ours="" --ours="--max-depth 8" compares two;
    /// not for cornell
    #[arg(long, value_name = "OPTIONS", default_values_t = [String::new()])]
    ours: Vec<String>,
    /// Where to put a PNG of each scene: pictures beside each other, made in the same time, and the reference; not for
    /// cornell
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
    /// Print one JSON object a line
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    let options = Options::parse();
    let mut ending = ExitCode::SUCCESS;
    for name in &options.scenes {
        let compared = if name == CORNELL { cornell::compare(&options) } else { model::compare(name, &options) };
        if let Err(error) = compared {
            eprintln!("error: {name}: {error}");
            ending = ExitCode::FAILURE;
        }
    }
    ending
}

fn known(name: &str) -> Result<String, String> {
    if name == CORNELL || MODELS.contains(&name) {
        Ok(name.to_owned())
    } else {
        Err(format!("there is {CORNELL}, {}", MODELS.join(", ")))
    }
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=4096).contains(side));
    let sides = text.split_once('x').and_then(|(width, height)| Some((side(width)?, side(height)?)));
    sides.ok_or_else(|| "this is two numbers from 1 to 4096, as in 320x240".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn every_model_has_its_script() {
        let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("renderers/scenes");
        for name in MODELS {
            assert!(scripts.join(name).with_extension("py").is_file(), "{name}");
        }
        assert!(known("yard").is_ok() && known("cornell").is_ok());
        assert!(known("yards").unwrap_err().contains("cornell, yard, bulbs"));
    }

    #[test]
    fn sizes_are_two_numbers() {
        assert_eq!(size("320x240"), Ok((320, 240)));
        for wrong in ["320", "320x", "0x4", "4x4097", "ax4", "-1x4"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
