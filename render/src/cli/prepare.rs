//! From the arguments to a scene, its settings, a world and threads.

use std::io::{ErrorKind, IsTerminal};
use std::path::Path;

use glam::Vec3;

use super::args::CommonArguments;
use super::error::CliError;
use super::inputs;
use super::messages::{Style, print_warning};
use super::progress::stages::LoadProgress;
use crate::scene::{self, Overrides, Place, Scene, SceneError};
use crate::settings::Settings;
use crate::world::{LightQuery, World};

/// The scene of a name, with options.
pub(super) struct Prepared {
    pub(super) scene: Scene,
    pub(super) settings: Settings,
    /// The options of the scene file.
    #[cfg_attr(not(feature = "view"), expect(dead_code, reason = "the viewer alone asks"))]
    pub(super) from_file: Overrides,
    /// The position of the file's own camera, if it has one.
    pub(super) eye: Option<Vec3>,
}

/// The built-in scene's name in place of a path.
pub(super) const CORNELL: &str = "cornell";

/// The scene called `name` with the options of its file, if it has one, below those of `arguments`. No file that it is
/// read from may be one of `outputs`.
pub(super) fn prepare<P: AsRef<Path>>(
    name: &Path,
    arguments: Overrides,
    outputs: &[P],
    style: Style,
) -> Result<(Scene, Settings), CliError> {
    prepare_from(name, arguments, outputs, style).map(|Prepared { scene, settings, .. }| (scene, settings))
}

/// The same, and more of what the file says.
pub(super) fn prepare_from<P: AsRef<Path>>(
    name: &Path,
    arguments: Overrides,
    outputs: &[P],
    style: Style,
) -> Result<Prepared, CliError> {
    let (mut scene, from_file) = open(name, &arguments, style)?;
    let eye = from_file.eye.or(scene.camera.map(|camera| camera.eye));
    let settings = arguments.or(from_file.clone()).apply(&mut scene);
    let settings = settings.map_err(|conflict| CliError::input(conflict.naming(name, &from_file)))?;
    inputs::refuse(outputs, &scene.files)?;
    Ok(Prepared { scene, settings, from_file, eye })
}

/// The world of the scene called `name`, to find light where it is said, with its settings, and the threads to work
/// with; warnings are printed.
pub(super) fn prepare_world<P: AsRef<Path> + Sync>(
    name: &Path,
    overrides: Overrides,
    arguments: &CommonArguments,
    outputs: &[P],
    from: LightQuery,
) -> Result<(World, Settings, rayon::ThreadPool), CliError> {
    let style = arguments.progress.style(std::io::stderr().is_terminal());
    let pool = thread_pool(arguments)?;
    let (mut scene, settings) = pool.install(|| prepare(name, overrides, outputs, style))?;
    scene.warnings.iter().for_each(|warning| print_warning(style, warning));
    scene.warnings.clear();
    let world = pool.install(|| World::for_light_query(scene, from)).map_err(CliError::input)?;
    Ok((world, settings, pool))
}

/// As many threads as asked for.
pub(super) fn thread_pool(arguments: &CommonArguments) -> Result<rayon::ThreadPool, CliError> {
    let threads = arguments.threads.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| CliError::System(format!("cannot start threads: {error}")))
}

/// The scene called `name`: the built-in one, a model, or a scene file with the options that it sets. `overrides` say
/// which moment is shown and what is shared, where they do.
pub(super) fn open(name: &Path, overrides: &Overrides, style: Style) -> Result<(Scene, Overrides), SceneError> {
    if name == Path::new(CORNELL) {
        return Ok((scene::cornell_box(), Overrides::default()));
    }
    match name.metadata() {
        Ok(_) => scene::open_watched(name, overrides, Some(&LoadProgress::start(style))),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let remedy = "give a scene file (.toml), a model (.glb, .gltf, .obj, .pbrt, .ply), or `cornell` for the built-in scene";
            Err(SceneError::new(name, Place::File, "no such file", remedy))
        }
        Err(error) => Err(SceneError::unreadable(name, &error)),
    }
}
