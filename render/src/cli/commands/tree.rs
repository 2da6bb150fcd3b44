//! `halfdome tree`: the kernel's tree of a scene as a file, and its description by `halfdome info`.

use std::fmt::Write as _;
use std::fs;
use std::io::{ErrorKind, IsTerminal, Write as _};
use std::path::{Path, PathBuf};

use clap::Args;
use halfdome_kernel::bvh::{BLOB_VERSION, MAX_STACK, WIDTH};
use halfdome_kernel::{Bvh, Quality, Triangle};
use serde_json::json;

use crate::cli::args::CommonArguments;
use crate::cli::error::{CliError, EXIT_DONE};
use crate::cli::messages::{Style, print_line, print_warning};
use crate::cli::prepare::{open, thread_pool};
use crate::cli::print::print;
use crate::cli::progress::stages::StageProgress;
use crate::cli::{inputs, interrupt, memory};
use crate::executor::RayonExecutor;
use crate::output::OutputFile;
use crate::scene::scene_file::value;
use crate::scene::{MomentOverrides, Overrides, Place, SceneError, Sharing};

/// The arguments of `halfdome tree`.
#[derive(Args, Clone, Debug)]
pub(crate) struct TreeArguments {
    /// A scene file (.toml), a model (.glb, .gltf, .obj, .pbrt, .ply), or `cornell` for the built-in scene
    scene: PathBuf,

    /// Tree to write (.bvh); triangles are numbered in the order of the scene, mesh by mesh
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Quality of the BVH: fast, medium or high [default: high]
    #[arg(long, value_name = "QUALITY", value_parser = value::argument(value::quality))]
    build: Option<Quality>,

    /// The moment of the model's animations.
    #[command(flatten)]
    moment: MomentOverrides,

    /// Threads and progress.
    #[command(flatten)]
    pub(crate) common: CommonArguments,
}

/// Builds the tree and writes it.
pub(crate) fn run(arguments: &TreeArguments) -> Result<u8, CliError> {
    let file = OutputFile::check(&arguments.output).map_err(CliError::input)?;
    if !is_tree(&arguments.output) {
        return Err(CliError::Input(format!(
            "{}: a tree's name ends in .bvh\n  help: call it {}",
            arguments.output.display(),
            arguments.output.with_extension("bvh").display()
        )));
    }
    // Its triangles are those of all copies.
    let overrides =
        Overrides { instances: Some(Sharing::Never), moment: arguments.moment.clone(), ..Overrides::default() };
    let style = arguments.common.progress.style(std::io::stderr().is_terminal());
    let pool = thread_pool(&arguments.common)?;
    let (scene, from_file) = pool.install(|| open(&arguments.scene, &overrides, style))?;
    inputs::refuse(&[&arguments.output], &scene.files)?;
    scene.warnings.iter().for_each(|warning| print_warning(style, warning));
    let triangles: Vec<Triangle> =
        scene.meshes.iter().flat_map(|mesh| (0..mesh.triangles.len()).map(|face| mesh.corners(face))).collect();
    drop(scene);

    let quality = arguments.build.or(from_file.build).unwrap_or_default();
    let building = StageProgress::of_build(style, triangles.len());
    let watch = |fraction| building.advance(fraction);
    let built = pool.install(|| Bvh::build_on(&RayonExecutor(&watch), &triangles, &quality.into()));
    let (bvh, report) = built.map_err(CliError::input)?;
    drop(building);

    let bytes = bvh.to_bytes();
    // A started write is finished.
    interrupt::catch()?;
    file.write(&bytes).map_err(CliError::system)?;
    match style {
        Style::Silent => {}
        Style::Json => print_line(&json!({
            "event": "end",
            "triangles": report.kept,
            "dropped": {
                "degenerate": report.degenerate,
                "not_finite": report.not_finite,
                "out_of_range": report.out_of_range,
            },
            "bytes": bytes.len(),
            "files": [arguments.output.display().to_string()],
        })),
        Style::Bar => {
            let size = memory::size(bytes.len() as u64);
            let _ = writeln!(std::io::stderr(), "{report}\nwrote {}, {size}", arguments.output.display());
        }
    }
    Ok(EXIT_DONE)
}

/// Whether a file is called as trees are.
pub(super) fn is_tree(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("bvh"))
}

/// Prints what is in the tree at `path`, as a table or as JSON.
pub(super) fn describe(path: &Path, as_json: bool) -> Result<u8, CliError> {
    let error = |problem: String| {
        SceneError::new(path, Place::File, problem, "give a file written by this version of `halfdome tree`")
    };
    let bytes = fs::read(path).map_err(|failure| match failure.kind() {
        ErrorKind::NotFound => error("no such file".to_owned()),
        _ => error(format!("cannot be read: {failure}")),
    })?;
    let bvh = Bvh::from_bytes(&bytes).map_err(|failure| error(failure.to_string()))?;
    let (tree, bounds) = (bvh.statistics(), bvh.view().bounds());
    let text = if as_json {
        let bounds =
            (!bounds.is_empty()).then(|| json!({ "lower": bounds.min.to_array(), "upper": bounds.max.to_array() }));
        let json = json!({
            "tree": path.display().to_string(),
            "version": BLOB_VERSION,
            "bytes": bytes.len(),
            "triangles": tree.triangles,
            "bounds": bounds,
            "sah_cost": tree.cost,
            "depth": tree.depth,
            "stack": tree.stack,
            "nodes": tree.nodes,
            "leaves": tree.leaves,
            "leaf_blocks": tree.blocks,
            "block_fill": tree.triangles as f32 / (WIDTH * tree.blocks).max(1) as f32,
        });
        format!("{json:#}\n")
    } else {
        let mut table = String::new();
        let mut row = |name: &str, value: String| {
            // Writing to a string cannot fail.
            let _ = writeln!(table, "{name:<20}{value}");
        };
        row("tree", path.display().to_string());
        row("version", BLOB_VERSION.to_string());
        row("size", memory::size(bytes.len() as u64));
        row("triangles", tree.triangles.to_string());
        match bounds.is_empty() {
            true => row("bounds", "empty".to_owned()),
            false => row("bounds", format!("{}  to  {}", spaced(bounds.min), spaced(bounds.max))),
        }
        row("quality", format!("SAH cost {:.2}", tree.cost));
        row("shape", format!("depth {}, {} nodes, {} leaf blocks", tree.depth, tree.nodes, tree.blocks));
        row("stack", format!("{} entries of {MAX_STACK}", tree.stack));
        table
    };
    print(&text)?;
    Ok(EXIT_DONE)
}

fn spaced(corner: glam::Vec3) -> String {
    corner.to_array().map(|x| x.to_string()).join(" ")
}
