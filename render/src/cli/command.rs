//! The commands.

use clap::{Parser, Subcommand};

use super::args::help::{
    BAKE_EXAMPLES, CUBEMAP_EXAMPLES, DENOISE_EXAMPLES, EXAMPLES, EXIT_CODES, MERGE_EXAMPLES, PROBES_EXAMPLES,
    RENDER_EXAMPLES, VALIDATE_EXAMPLES, VIEW_EXAMPLES,
};
use super::args::{InfoArguments, MaterialsArguments, RenderArguments};
use super::commands::bake::BakeArguments;
use super::commands::cache::CacheCommand;
use super::commands::cubemap::CubemapArguments;
use super::commands::denoise::DenoiseArguments;
use super::commands::irradiance::IrradianceArguments;
use super::commands::manual::{CompletionsArguments, ManArguments};
use super::commands::merge::MergeArguments;
use super::commands::probes::ProbesArguments;
use super::commands::tree::TreeArguments;
use super::commands::validate::ValidateArguments;
use super::commands::view::ViewArguments;
use super::prepare::CORNELL;

/// Renders scenes with global illumination, and bakes lightmaps, cube maps and light probes
///
/// Without a command it renders the built-in Cornell box with 32 samples per pixel, to cornell.exr and cornell.png in
/// the current folder.
#[derive(Parser, Debug)]
#[command(version, after_help = format!("{EXAMPLES}\n\n{EXIT_CODES}"))]
pub(super) struct Arguments {
    /// The command; without one, renders the built-in Cornell box.
    #[command(subcommand)]
    pub(super) command: Option<Command>,
}

#[derive(Subcommand, Debug)]
pub(super) enum Command {
    /// Render a scene to pictures
    #[command(after_help = format!("{RENDER_EXAMPLES}\n\n{EXIT_CODES}"))]
    Render(Box<RenderArguments>),
    /// View a scene in a window while it is rendered
    #[command(after_help = format!("{VIEW_EXAMPLES}\n\n{EXIT_CODES}"))]
    View(Box<ViewArguments>),
    /// Merge the parts of several runs or machines: films to a picture, shards of a bake, shards of sensors
    #[command(after_help = format!("{MERGE_EXAMPLES}\n\n{EXIT_CODES}"))]
    Merge(MergeArguments),
    /// Denoise a rendered picture
    #[command(after_help = format!("{DENOISE_EXAMPLES}\n\n{EXIT_CODES}"))]
    Denoise(DenoiseArguments),
    /// Show the contents of a scene, or of a tree that `halfdome tree` wrote
    #[command(after_help = EXIT_CODES)]
    Info(Box<InfoArguments>),
    /// Print a scene's materials, as they were read, as [[material]] tables for a scene file
    #[command(after_help = EXIT_CODES)]
    Materials(MaterialsArguments),
    /// Bake lightmaps or ambient occlusion for a model
    #[command(after_help = format!("{BAKE_EXAMPLES}\n\n{EXIT_CODES}"))]
    Bake(Box<BakeArguments>),
    /// Compute irradiance at given points
    #[command(after_help = EXIT_CODES)]
    Irradiance(Box<IrradianceArguments>),
    /// Build, inspect, merge and draw irradiance caches
    #[command(subcommand, after_help = EXIT_CODES)]
    Cache(CacheCommand),
    /// Build the BVH of a scene, and write it for programs that embed the kernel
    #[command(after_help = EXIT_CODES)]
    Tree(TreeArguments),
    /// Make a prefiltered cube map of an environment, or of the view from a point in a scene
    #[command(after_help = format!("{CUBEMAP_EXAMPLES}\n\n{EXIT_CODES}"))]
    Cubemap(Box<CubemapArguments>),
    /// Compute light probes: spherical harmonics at points or on a grid
    #[command(after_help = format!("{PROBES_EXAMPLES}\n\n{EXIT_CODES}"))]
    Probes(Box<ProbesArguments>),
    /// Validate the renderer on scenes with exact answers
    #[command(after_help = format!("{VALIDATE_EXAMPLES}\n\n{EXIT_CODES}"))]
    Validate(ValidateArguments),
    /// Make manual pages of the program and its commands
    Man(ManArguments),
    /// Print a script that lets a shell complete options
    Completions(CompletionsArguments),
}

impl Command {
    /// The program without arguments.
    pub(super) fn cornell() -> Self {
        // A few seconds on two cores.
        let arguments = Arguments::parse_from(["halfdome", "render", CORNELL, "--spp", "32"]);
        arguments.command.expect("`render` is a command")
    }
}
