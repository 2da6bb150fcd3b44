//! `halfdome cache show`: draws the positions and radii of records.

use std::f32::consts::TAU;
use std::fmt::Write as _;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

use clap::Args;
use glam::{Vec2, Vec3};

use super::{cached_options, read_cache, with_cache};
use crate::cache::{Cache, Record};
use crate::camera::Camera;
use crate::cli::args::{CommonArguments, OverrideArguments};
use crate::cli::error::{CliError, EXIT_DONE, EXIT_INTERRUPTED};
use crate::cli::prepare::prepare_world;
use crate::cli::progress::Progress;
use crate::cli::{inputs, interrupt, memory};
use crate::driver::{self, Plan};
use crate::film::Picture;
use crate::output::{self, OutputFile, ToneMapping};
use crate::overlay::visible_records;
use crate::settings::Invalid;
use crate::watch::Watch;
use crate::world::LightQuery;
use crate::world::World;

/// A cache, and the picture over which its records are drawn.
#[derive(Args, Clone, Debug)]
pub(in crate::cli) struct ShowArguments {
    /// The scene of the cache
    scene: PathBuf,

    /// A cache
    cache: PathBuf,

    /// Picture (.png) or points (.ply) to write; can be given several times
    #[arg(short, long = "output", value_name = "FILE", required = true)]
    outputs: Vec<PathBuf>,

    /// Draw only dots, without ellipses
    #[arg(long)]
    dots: bool,

    /// Overrides of the scene.
    #[command(flatten)]
    overriding: OverrideArguments,

    /// Threads and progress.
    #[command(flatten)]
    pub(super) common: CommonArguments,
}

/// Linear colours of dots and rings.
const DOT: [f32; 3] = [1.0, 0.02, 0.0];
const RING: [f32; 3] = [0.9, 0.75, 0.05];
/// Corners of a ring.
const CORNERS: usize = 48;

/// Draws, or writes points.
pub(super) fn run(arguments: &ShowArguments) -> Result<u8, CliError> {
    for path in &arguments.outputs {
        match extension(path).as_deref() {
            Some("ply") => _ = OutputFile::check(path).map_err(CliError::input)?,
            Some("png") => output::check(path).map_err(CliError::input)?,
            _ => {
                let problem = format!("{}: records can only be written as .png or .ply", path.display());
                return Err(Invalid::new(problem, "give a name that ends in .png (picture) or .ply (points)").into());
            }
        }
    }
    inputs::refuse(&arguments.outputs, &[&arguments.cache])?;
    let overrides = with_cache(arguments.overriding.overrides());
    let (world, settings, pool) =
        prepare_world(&arguments.scene, overrides, &arguments.common, &arguments.outputs, LightQuery::Camera)?;
    let cache = read_cache(Some(&arguments.cache), &cached_options(&settings)?, &world)?;
    memory::check(&settings)?;
    let mut stopped = false;
    for path in &arguments.outputs {
        if extension(path).as_deref() == Some("ply") {
            let file = OutputFile::check(path).map_err(CliError::input)?;
            file.write(ply(&cache).as_bytes()).map_err(CliError::system)?;
            continue;
        }
        interrupt::catch()?;
        let samples = u64::from(settings.width) * u64::from(settings.height) * u64::from(settings.spp);
        let progress = Progress::start(arguments.common.progress.style(io::stderr().is_terminal()), samples);
        let plan = Plan { cache: Some(cache.clone()), ..Plan::default() };
        let render = pool.install(|| driver::render_plan(&world, &settings, plan, &progress));
        let render = render.map_err(CliError::input)?;
        stopped |= progress.stop();
        drop(progress);
        let mut picture = render.picture;
        draw(&mut picture, &world, &cache, !arguments.dots);
        output::write(path, &picture, &ToneMapping::default()).map_err(CliError::system)?;
    }
    Ok(if stopped { EXIT_INTERRUPTED } else { EXIT_DONE })
}

fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

/// Draws the records that the camera sees over the picture: rings first, so that they hide no dot.
fn draw(picture: &mut Picture, world: &World, cache: &Cache, rings: bool) {
    let camera = world.camera_on(picture.width, picture.height);
    let visible = visible_records(world, cache, picture.width, picture.height);
    if rings {
        for (record, _) in &visible {
            let corners: Vec<Vec3> = (0..=CORNERS).map(|i| corner(record, i as f32 / CORNERS as f32)).collect();
            for ends in corners.windows(2) {
                line(picture, &camera, ends[0], ends[1]);
            }
        }
    }
    for (_, Vec2 { x, y }) in visible {
        for (right, down) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            paint(picture, x - 0.5 + right, y - 0.5 + down, DOT);
        }
    }
}

/// The point of a record's ellipse at a part of the way around.
fn corner(record: &Record, turn: f32) -> Vec3 {
    let (sin, cos) = (turn * TAU).sin_cos();
    let across = record.normal.cross(record.axis);
    record.position + record.axis * (cos * record.radii[0]) + across * (sin * record.radii[1])
}

/// A line between two points in space, a pixel wide, cut off where the camera does not see it.
fn line(picture: &mut Picture, camera: &Camera, from: Vec3, to: Vec3) {
    for view in 0..camera.views() {
        if let (Some(from), Some(to)) = (camera.sight(from, view), camera.sight(to, view))
            && camera.joins(from.film, to.film)
        {
            stroke(picture, from.film, to.film);
        }
    }
}

/// A line between two points of the film.
fn stroke(picture: &mut Picture, from: Vec2, to: Vec2) {
    let steps = (to - from).abs().max_element().ceil().clamp(1.0, 4096.0);
    for step in 0..steps as u32 {
        let point = from.lerp(to, step as f32 / steps);
        paint(picture, point.x, point.y, RING);
    }
}

/// Gives the pixel at a point of the film a colour.
fn paint(picture: &mut Picture, x: f32, y: f32, color: [f32; 3]) {
    let (width, height) = (picture.width as usize, picture.height as usize);
    if !(x >= 0.0 && y >= 0.0 && (x as usize) < width && (y as usize) < height) {
        return;
    }
    let pixel = y as usize * width + x as usize;
    for (name, value) in ["R", "G", "B"].into_iter().zip(color) {
        if let Some(channel) = picture.channels.iter_mut().find(|channel| channel.name == name) {
            channel.values[pixel] = value;
        }
    }
}

/// The records as a point cloud in the Stanford PLY format.
fn ply(cache: &Cache) -> String {
    let mut text = format!(
        "ply\nformat ascii 1.0\ncomment halfdome irradiance records\nelement vertex {}\n",
        cache.records().len()
    );
    for name in
        ["x", "y", "z", "nx", "ny", "nz", "irradiance_r", "irradiance_g", "irradiance_b", "radius_1", "radius_2"]
    {
        let _ = writeln!(text, "property float {name}");
    }
    text += "end_header\n";
    for Record { position: p, normal: n, irradiance: e, radii: [r1, r2], .. } in cache.records() {
        let _ = writeln!(text, "{} {} {} {} {} {} {} {} {} {r1} {r2}", p.x, p.y, p.z, n.x, n.y, n.z, e.x, e.y, e.z);
    }
    text
}
