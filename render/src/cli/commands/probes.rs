//! `halfdome probes`: light from all directions at points in a scene.

mod files;

use std::fs::File;
use std::io::{self, BufRead, BufReader, IsTerminal};
use std::path::{Path, PathBuf};

use clap::Args;
use glam::Vec3;
use serde_json::json;

use crate::cli::args::CommonArguments;
use crate::cli::args::light::LightArguments;
use crate::cli::error::{CliError, EXIT_DONE, EXIT_INTERRUPTED, invalid};
use crate::cli::messages::{Style, print_line, print_text, warn};
use crate::cli::prepare::prepare_world;
use crate::cli::progress::Progress;
use crate::cli::{inputs, interrupt};
use crate::irradiance;
use crate::probes::{self, Options, ProbeGrid, Probes, State};
use crate::scene::count;
use crate::scene::scene_file::value;
use crate::world::LightQuery;
use crate::world::World;
use files::Files;

/// The arguments of `halfdome probes`.
#[derive(Args, Clone, Debug)]
pub(crate) struct ProbesArguments {
    /// A scene file (.toml), a model (.glb, .gltf, .obj, .pbrt, .ply), or `cornell` for the built-in scene
    scene: PathBuf,

    /// File to write; can be given several times: .json (positions, states and coefficients), .exr (one texel per
    /// probe, channels by coefficient) or, with --grid, .ktx2 (Bevy's irradiance volume)
    #[arg(short, long = "output", value_name = "FILE", required = true)]
    outputs: Vec<PathBuf>,

    /// Number of probes along x, y and z, at the centres of the cells of a box, for example 8x4x8
    #[arg(long, value_name = "NXxNYxNZ", allow_hyphen_values = true, value_parser = cells)]
    #[arg(required_unless_present = "points")]
    grid: Option<[u32; 3]>,

    /// Lower corner of the box [default: the scene's]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = value::argument(value::point))]
    #[arg(requires = "grid")]
    min: Option<Vec3>,

    /// Upper corner of the box [default: the scene's]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = value::argument(value::point))]
    #[arg(requires = "grid")]
    max: Option<Vec3>,

    /// Positions of probes instead of a grid: one line `x y z` each; blank lines and # comments are skipped; - is
    /// standard input
    #[arg(long, value_name = "FILE", conflicts_with = "grid")]
    points: Option<PathBuf>,

    /// Approximate number of paths per probe, for light reflected by surfaces and the sky
    #[arg(long, value_name = "N", default_value = "2048", allow_hyphen_values = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(18..=16_777_216))]
    rays: u32,

    /// Samples of direct light for each of two opposite sides of a probe
    #[arg(long, value_name = "N", default_value = "256", allow_hyphen_values = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,

    #[command(flatten)]
    light: LightArguments,

    /// Threads and progress.
    #[command(flatten)]
    pub(crate) common: CommonArguments,
}

impl ProbesArguments {
    /// The grid in a world.
    fn grid(&self, count: [u32; 3], world: &World) -> Result<ProbeGrid, CliError> {
        let bounds = world.bounds();
        let (min, max) = match (self.min, self.max) {
            (Some(min), Some(max)) => (min, max),
            _ if bounds.is_empty() => {
                let problem = format!("{} has no surfaces, so the grid has no box", self.scene.display());
                return Err(invalid(problem, "give the box with --min and --max"));
            }
            (min, max) => (min.unwrap_or(bounds.min), max.unwrap_or(bounds.max)),
        };
        // Rays could not distinguish points of such a box, or not reach them.
        let is_box = min.cmplt(max).all() && min.abs().max(max.abs()).max_element() <= halfdome_kernel::MAX_COORDINATE;
        match is_box {
            true => Ok(ProbeGrid { min, max, count }),
            false => Err(invalid(
                format!("the box from {min} to {max} is empty"),
                "make each coordinate of --max greater than that of --min",
            )),
        }
    }
}

/// The positions of probes.
enum Places {
    Grid(ProbeGrid),
    Points(Vec<Vec3>),
}

/// Finds probes and writes them.
pub(crate) fn run(arguments: &ProbesArguments) -> Result<u8, CliError> {
    let files = Files::new(&arguments.outputs, arguments.grid.is_some())?;
    inputs::refuse(&arguments.outputs, arguments.points.as_slice())?;
    let points = arguments.points.as_deref().map(read_points).transpose()?;
    let style = arguments.common.progress.style(io::stderr().is_terminal());
    let from = points.as_deref().map_or(LightQuery::Surfaces, LightQuery::Places);
    let (world, settings, pool) =
        prepare_world(&arguments.scene, arguments.light.overrides(), &arguments.common, &arguments.outputs, from)?;
    let places = match (points, arguments.grid) {
        (Some(points), _) => Places::Points(points),
        (None, Some(count)) => Places::Grid(arguments.grid(count, &world)?),
        (None, None) => unreachable!("one of them is required"),
    };
    let options = Options { rays: arguments.rays, spp: arguments.spp, seed: settings.seed };
    let number = match &places {
        Places::Grid(grid) => grid.len(),
        Places::Points(points) => points.len(),
    };
    interrupt::catch()?;
    let progress = Progress::start(style, number as u64);
    let found = pool.install(|| match &places {
        Places::Grid(grid) => probes::on_grid(&world, grid, &options, &progress),
        Places::Points(points) => probes::at_points(&world, points, &options, &progress),
    });
    drop(progress);
    let Some(found) = found else {
        print_text(style, "interrupted; nothing was written");
        return Ok(EXIT_INTERRUPTED);
    };
    warn(style, &mut warnings(&found, arguments.grid.is_some()));
    let grid = match &places {
        Places::Grid(grid) => Some(grid),
        Places::Points(_) => None,
    };
    let mut clamped = files.write(&found, grid, &options)?;
    warn(style, &mut clamped);
    report(style, &found, &arguments.outputs);
    Ok(EXIT_DONE)
}

/// Probes of one state.
fn number(found: &Probes, state: State) -> usize {
    found.probes.iter().filter(|probe| probe.state == state).count()
}

fn warnings(found: &Probes, is_grid: bool) -> Vec<String> {
    let mut warnings = Vec::new();
    let covered = number(found, State::Covered);
    if covered > 0 {
        let probes = count(covered, "probe is", "probes are");
        let place = if is_grid { ", with no free neighbour to be filled from" } else { "" };
        warnings.push(format!("{probes} inside of objects{place}"));
    }
    if !found.probes.is_empty() && found.probes.iter().all(|probe| probe.light.harmonics[0] == Vec3::ZERO) {
        warnings.push(
            "all probes are black: the scene has no light there; give a --sky, or try --emission both".to_owned(),
        );
    }
    warnings
}

fn report(style: Style, found: &Probes, files: &[PathBuf]) {
    let [free, moved, filled, covered] = State::ALL.map(|state| number(found, state));
    match style {
        Style::Silent => {}
        Style::Json => print_line(&json!({
            "event": "end",
            "probes": found.probes.len(),
            "free": free,
            "moved": moved,
            "filled": filled,
            "covered": covered,
            "rays": found.rays,
            "files": files.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
        })),
        Style::Bar => {
            let probes = count(found.probes.len(), "probe", "probes");
            let inside = format!("{moved} moved out of objects, {filled} filled from neighbours, {covered} covered");
            print_text(style, &format!("{probes}: {free} free, {inside}; {} rays", found.rays));
            files.iter().for_each(|path| print_text(style, &format!("wrote {}", path.display())));
        }
    }
}

/// The points in a file, or on standard input if it is called `-`.
fn read_points(path: &Path) -> Result<Vec<Vec3>, CliError> {
    let reader: Box<dyn BufRead> = if path == Path::new("-") {
        Box::new(io::stdin().lock())
    } else {
        let file = File::open(path).map_err(|error| {
            CliError::Input(format!(
                "{}: cannot be read: {error}\n  help: give a file with a line `x y z` for each probe",
                path.display()
            ))
        })?;
        Box::new(BufReader::new(file))
    };
    let naming = |error: String| CliError::Input(format!("{}: {error}", path.display()));
    let points = irradiance::read_positions(reader).map_err(|error| naming(error.to_string()))?;
    match points.len() as u64 {
        0 => Err(naming("it has no points\n  help: give a line `x y z` for each probe".to_owned())),
        number if number > ProbeGrid::MAX_PROBES => {
            Err(naming(format!("it has {number} points\n  help: give at most {}", ProbeGrid::MAX_PROBES)))
        }
        _ => Ok(points),
    }
}

/// Cells along three axes.
fn cells(text: &str) -> Result<[u32; 3], String> {
    let cells: Option<Vec<u32>> = text.split(['x', 'X', '×']).map(|side| side.parse().ok()).collect();
    let count = cells.and_then(|cells| <[u32; 3]>::try_from(cells).ok());
    let fits = |count: &[u32; 3]| {
        let sides = count.iter().all(|side| (1..=1024).contains(side));
        sides && count.iter().map(|&side| u64::from(side)).product::<u64>() <= ProbeGrid::MAX_PROBES
    };
    count.filter(fits).ok_or_else(|| {
        format!(
            "expected three whole numbers from 1 to 1024, of {} probes at most, for example 8x4x8",
            ProbeGrid::MAX_PROBES
        )
    })
}
