//! `halfdome render`: from a scene to pictures on disk.

use std::io::IsTerminal;
use std::path::PathBuf;

use super::args::RenderArguments;
use super::build_progress::BuildProgress;
use super::cache::{cached_options, read_cache};
use super::error::{CliError, EXIT_DONE, EXIT_INTERRUPTED};
use super::inputs;
use super::prepare::{prepare, thread_pool};
use super::preview::Preview;
use super::progress::Progress;
use super::summary::RenderReport;
use super::{interrupt, memory};
use crate::driver;
use crate::executor::RayonExecutor;
use crate::film::Picture;
use crate::output::{self, ToneMapping};
use crate::scene::count;
use crate::settings::Settings;
use crate::world::World;

/// Renders; the exit code says whether every sample was taken.
pub(super) fn run(arguments: &RenderArguments) -> Result<u8, CliError> {
    let paths = arguments.outputs()?;
    for path in &paths {
        output::check(path).map_err(CliError::input)?;
    }
    inputs::refuse(&paths, arguments.cache.as_slice())?;
    let (mut scene, settings) = prepare(&arguments.scene, arguments.overriding.overrides(), &paths)?;
    memory::check(&settings)?;
    let lit = scene.has_light();
    if settings.integrator.needs_light() && !lit {
        let from_gltf = scene.meshes.iter().any(|mesh| mesh.origin.is_some());
        let export = if from_gltf {
            ", or export the lights: Blender leaves them out unless Include > Punctual Lights is on"
        } else {
            ""
        };
        scene.warnings.push(format!("the scene has no light, so the picture is black; give it a --sky{export}"));
    }

    let pool = thread_pool(&arguments.common)?;
    let style = arguments.common.progress.style(std::io::stderr().is_terminal());
    let mut warnings = std::mem::take(&mut scene.warnings);
    let scene_name = arguments.scene.display().to_string();
    let building = BuildProgress::start(style, scene.triangle_count());
    let watch = |fraction| building.advance(fraction);
    let world = pool.install(|| World::build(scene, &settings.build.into(), &RayonExecutor(&watch)));
    let world = world.map_err(CliError::input)?;
    drop(building);
    let cache = match &arguments.cache {
        Some(path) => Some(read_cache(Some(path), &cached_options(&settings)?, &world)?),
        None => None,
    };
    let degenerate = world.build_report().degenerate;
    if degenerate > 0 {
        let dropped = count(degenerate, "triangle with two equal corners is", "triangles with two equal corners are");
        warnings.push(format!("{dropped} dropped"));
    }
    let mut report =
        RenderReport { scene: scene_name, settings: &settings, threads: pool.current_num_threads(), warnings };
    report.print_start(style);

    interrupt::catch()?;
    let progress = Progress::start(style, samples(&settings));
    let tone = arguments.tone_mapping();
    let preview = Preview { progress: &progress, coarsest: arguments.progressive, paths: &paths, tone: &tone, style };
    let result = pool.install(|| driver::render_with(&world, &settings, cache, &preview));
    drop(progress);
    if settings.integrator.needs_light() && lit && result.finished && is_black(&result.picture) {
        let warning = "the picture is black although the scene has lights: emitters may face away (try --emission both), \
                       or the camera may see nothing that is lit";
        report.warn(style, warning.to_owned());
    }

    let (written, mut failures) = write_all(&paths, &result.picture, &tone);
    if !failures.is_empty() {
        // An end that names files would look like success.
        failures.extend(written.iter().map(|path| format!("{} was written", path.display())));
        return Err(CliError::System(failures.join("\n")));
    }
    report.print_end(style, &result, &written);
    Ok(if result.finished { EXIT_DONE } else { EXIT_INTERRUPTED })
}

/// Writes every picture that can be written, for it may have taken hours to make: paths written, errors of the others.
fn write_all(paths: &[PathBuf], picture: &Picture, tone: &ToneMapping) -> (Vec<PathBuf>, Vec<String>) {
    let mut written = Vec::new();
    let mut failures = Vec::new();
    for path in paths {
        match output::write(path, picture, tone) {
            Ok(()) => written.push(path.clone()),
            Err(error) => failures.push(error.to_string()),
        }
    }
    (written, failures)
}

/// Whether no pixel has any light.
fn is_black(picture: &Picture) -> bool {
    ["R", "G", "B"]
        .iter()
        .filter_map(|name| picture.channel(name))
        .all(|channel| channel.values.iter().all(|&v| v == 0.0))
}

/// Camera samples of the whole picture.
fn samples(settings: &Settings) -> u64 {
    // Less than 2^28 pixels of less than 2^32 samples.
    u64::from(settings.width) * u64::from(settings.height) * u64::from(settings.spp)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_samples_does_not_overflow() {
        let settings = Settings { width: 16_384, height: 16_384, spp: u32::MAX, ..Settings::default() };
        assert_eq!(samples(&settings), (1 << 28) * (u64::from(u32::MAX)));
    }
}
