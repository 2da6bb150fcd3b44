//! `halfdome view`: a window to look around in a scene while it is rendered.

#[cfg(feature = "view")]
mod window;

use std::path::PathBuf;

use clap::Args;

use crate::cli::args::{CommonArguments, OverrideArguments, ToneArguments};
use crate::cli::error::CliError;

/// The arguments of `halfdome view`.
#[derive(Args, Clone, Debug)]
pub(crate) struct ViewArguments {
    /// A scene file (.toml), a model (.glb, .gltf, .obj, .pbrt, .ply), or `cornell` for the built-in scene
    scene: PathBuf,

    /// Overrides of the scene.
    #[command(flatten)]
    overriding: OverrideArguments,

    /// Tone mapping of the display.
    #[command(flatten)]
    tone: ToneArguments,

    /// Threads and progress.
    #[command(flatten)]
    pub(crate) common: CommonArguments,
}

/// Says that this program has no window.
#[cfg(not(feature = "view"))]
pub(crate) fn run(_arguments: &ViewArguments) -> Result<u8, CliError> {
    Err(CliError::System(
        "this halfdome was built without a window\n  help: build it with one: cargo install --path render --features view; \
         or watch a picture grow with `halfdome render --tev` or `--progressive`"
            .to_owned(),
    ))
}

/// Opens a window, until it is closed.
#[cfg(feature = "view")]
pub(crate) fn run(arguments: &ViewArguments) -> Result<u8, CliError> {
    use std::io::IsTerminal;

    use crate::cli::memory;
    use crate::cli::messages::print_warning;
    use crate::cli::prepare::{CORNELL, Prepared, prepare_from, thread_pool};
    use crate::executor::RayonExecutor;
    use crate::settings::Settings;
    use crate::view::{CameraFile, Session, Start, optics_keys};
    use crate::world::World;

    // Before a long load.
    let window = window::Window::open()?;
    let ViewArguments { scene: path, overriding, tone, common } = arguments;
    let overrides = overriding.overrides();
    let style = common.progress.style(std::io::stderr().is_terminal());
    let pool = thread_pool(common)?;
    let read = || prepare_from::<PathBuf>(path, overrides.clone(), &[], style);
    let Prepared { scene, settings, from_file, .. } = pool.install(read)?;
    let with_aovs = Settings { aov: true, halves: true, ..settings.clone() };
    memory::check(&with_aovs)?;
    scene.warnings.iter().for_each(|warning| print_warning(style, warning));
    let name = path.display().to_string();
    let outline = Session::outline(&scene, &name);
    let world = pool.install(|| World::build(scene, &settings.build.into(), &RayonExecutor::UNWATCHED));
    let world = world.map_err(CliError::input)?;
    let has_optics = from_file.make_camera() && !overrides.set_camera();
    let options = overrides.or(from_file).camera;
    let camera_file = CameraFile {
        scene: (path.as_path() != std::path::Path::new(CORNELL)).then(|| path.clone()),
        optics: optics_keys(&world.camera(), world.optics(), &options),
        has_optics,
    };
    let start = Start { name, settings, tone: tone.mapping(), camera_file, pool, notify: window.notify() };
    window.show(Session::new(world, outline, start))
}
