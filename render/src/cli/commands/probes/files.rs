//! The files of probes: JSON, OpenEXR, and Bevy's irradiance volume.

use std::path::{Path, PathBuf};

use glam::Vec3;
use serde::Serialize;

use crate::cli::error::{CliError, invalid};
use crate::film::{Channel, Metadata, Picture};
use crate::output::{OutputFile, Shape, Texture, encode_exr, encode_ktx2_texture};
use crate::probes::{Options, Probe, ProbeGrid, Probes, harmonics, volume};
use crate::scene::count;

/// The version of the JSON's form; it changes when old readers would misunderstand it.
const VERSION: u32 = 1;

/// The output of probes.
pub(super) struct Files(Vec<(PathBuf, Format)>);

/// The format of probes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Json,
    Exr,
    Ktx2,
}

/// Probes as JSON.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Document {
    version: u32,
    generator: &'static str,
    unit: &'static str,
    /// Degree and order of each coefficient.
    coefficients: [&'static str; 9],
    seed: u64,
    rays: u32,
    spp: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    grid: Option<GridEntry>,
    probes: Vec<ProbeEntry>,
}

/// A grid, x first.
#[derive(Serialize)]
struct GridEntry {
    count: [u32; 3],
    min: Vec3,
    max: Vec3,
    /// The transform of Bevy's volume, a cube of side 1.
    transform: Transform,
}

#[derive(Serialize)]
struct Transform {
    translation: Vec3,
    scale: Vec3,
}

#[derive(Serialize)]
struct ProbeEntry {
    position: Vec3,
    state: &'static str,
    backs: f32,
    sh: [Vec3; 9],
}

impl Files {
    /// Checks that everything can be written.
    pub(super) fn new(outputs: &[PathBuf], is_grid: bool) -> Result<Self, CliError> {
        let mut files = Vec::new();
        for (i, path) in outputs.iter().enumerate() {
            let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
            let format = match extension.as_str() {
                "json" => Format::Json,
                "exr" => Format::Exr,
                "ktx2" if is_grid => Format::Ktx2,
                "ktx2" => {
                    let problem = format!("{}: a volume needs a grid of probes", path.display());
                    return Err(invalid(problem, "use --grid instead of --points, or write .json or .exr"));
                }
                _ => {
                    let problem = format!("{}: probes cannot be written in this format", path.display());
                    return Err(invalid(problem, "give a name that ends in .json, .exr or .ktx2"));
                }
            };
            if outputs[..i].contains(path) {
                let problem = format!("{} is given twice", path.display());
                return Err(invalid(problem, "give each file its own name"));
            }
            OutputFile::check(path).map_err(CliError::input)?;
            files.push((path.clone(), format));
        }
        Ok(Self(files))
    }

    /// Writes everything; gives warnings.
    pub(super) fn write(
        &self,
        found: &Probes,
        grid: Option<&ProbeGrid>,
        options: &Options,
    ) -> Result<Vec<String>, CliError> {
        let mut warnings = Vec::new();
        let mut ready = Vec::new();
        for (path, format) in &self.0 {
            let bytes = match (format, grid) {
                (Format::Ktx2, Some(grid)) => {
                    let volume = volume(grid, &found.probes);
                    let shape = Shape::Volume(volume.extent);
                    let texture = Texture { shape, levels: vec![&volume.texels], is_signed: false };
                    let file = encode_ktx2_texture(path, &texture).map_err(CliError::system)?;
                    if file.clamped > 0 {
                        let texels = count(file.clamped, "texel is", "texels are");
                        let path = path.display();
                        warnings.push(format!("{path}: {texels} brighter than the format can store, clamped"));
                    }
                    file.bytes
                }
                (Format::Exr, _) => encode_exr(path, &picture(found, grid, options)).map_err(CliError::system)?,
                _ => document(found, grid, options).into_bytes(),
            };
            ready.push((path, bytes));
        }
        for (path, bytes) in ready {
            write(path, &bytes)?;
        }
        Ok(warnings)
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), CliError> {
    OutputFile::check(path).and_then(|file| file.write(bytes)).map_err(CliError::system)
}

fn document(found: &Probes, grid: Option<&ProbeGrid>, options: &Options) -> String {
    let entry = |probe: &Probe| ProbeEntry {
        position: probe.position,
        state: probe.state.name(),
        backs: probe.backs,
        sh: probe.light.harmonics,
    };
    let grid = grid.map(|&ProbeGrid { min, max, count }| GridEntry {
        count,
        min,
        max,
        transform: Transform { translation: 0.5 * (min + max), scale: max - min },
    });
    let document = Document {
        version: VERSION,
        generator: concat!("halfdome ", env!("CARGO_PKG_VERSION")),
        unit: "radiance, W/(m² sr), linear sRGB",
        coefficients: harmonics::NAMES,
        seed: options.seed,
        rays: options.rays,
        spp: options.spp,
        grid,
        probes: found.probes.iter().map(entry).collect(),
    };
    serde_json::to_string_pretty(&document).unwrap_or_else(|error| unreachable!("plain data: {error}")) + "\n"
}

/// A texel for each probe: of a grid as wide as it is along x, its slices below each other; of a list a single column.
fn picture(found: &Probes, grid: Option<&ProbeGrid>, options: &Options) -> Picture {
    let number = found.probes.len() as u32;
    let width = grid.map_or(1, |grid| grid.count[0]);
    let channel = |name: String, value: &dyn Fn(&Probe) -> f32| Channel {
        name,
        values: found.probes.iter().map(value).collect(),
    };
    let mut channels: Vec<Channel> = Vec::new();
    for (i, coefficient) in harmonics::NAMES.into_iter().enumerate() {
        for (c, color) in ["R", "G", "B"].into_iter().enumerate() {
            channels.push(channel(format!("sh.{coefficient}.{color}"), &|probe| probe.light.harmonics[i][c]));
        }
    }
    for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        channels.push(channel(format!("P.{name}"), &|probe| probe.position[axis]));
    }
    channels.push(channel("state".to_owned(), &|probe| f32::from(probe.state as u8)));
    channels.push(channel("backs".to_owned(), &|probe| probe.backs));
    let metadata = Metadata {
        samples_per_pixel: options.rays,
        seed: options.seed,
        integrator: "probes".to_owned(),
        ..Metadata::default()
    };
    Picture { width, height: number / width, channels, metadata }
}
