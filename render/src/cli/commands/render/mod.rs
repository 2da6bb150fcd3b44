//! `halfdome render`: from a scene to pictures on disk.

mod pictures;
mod report;
mod resumed;
mod sequence;
mod statistics;
mod summary;
mod watch;

use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Instant;

use super::cache::{cached_options, read_cache};
use crate::cache::{MORE_RECORDS, missed_accuracy};
use crate::cli::args::RenderArguments;
use crate::cli::checkpoint::Checkpoint;
use crate::cli::error::{CliError, EXIT_DONE, EXIT_INTERRUPTED, EXIT_LIMIT, invalid};
use crate::cli::messages::{Style, print_text};
use crate::cli::prepare::{prepare, thread_pool};
use crate::cli::progress::Progress;
use crate::cli::progress::stages::StageProgress;
use crate::cli::tev::Tev;
use crate::cli::{denoiser, inputs, interrupt, memory};
use crate::denoise::DenoiseError;
use crate::driver::{self, Plan};
use crate::executor::RayonExecutor;
use crate::film::{BadSamples, Film};
use crate::integrator::unmatched_labels;
use crate::output::{self, OutputFile, ToneMapping};
use crate::scene::{Scene, count};
use crate::settings::{Integrator, Settings};
use crate::world::World;
use pictures::{is_black, is_exr, shown_name, without_aov};
pub(crate) use pictures::{refuse_failures, write_all};
use resumed::{begun, more_samples, refuse_to_replace};
use sequence::sequence;
use statistics::{Options, Recorder, SceneFacts, Seconds, Statistics};
use summary::{End, RenderReport, Told};
use watch::RenderWatch;

/// Renders a picture or a sequence; the exit code says whether every sample was taken.
pub(crate) fn run(arguments: &RenderArguments) -> Result<u8, CliError> {
    match arguments.sequence.numbers() {
        Some(frames) => sequence(arguments, frames),
        None => render(arguments, &Told::default()),
    }
}

/// Renders a picture. Warnings that were `told` about other pictures of a sequence are not printed again.
fn render(arguments: &RenderArguments, told: &Told) -> Result<u8, CliError> {
    let begin = Instant::now();
    let mut recorder = Recorder::start();
    let (film_path, paths) = arguments.film.places(&arguments.outputs()?)?;
    for path in &paths {
        output::check(path).map_err(CliError::input)?;
    }
    if let Some(path) = &film_path
        && arguments.film.checkpoint.is_some()
    {
        refuse_to_replace(path, arguments.film.resume)?;
    }
    inputs::check_report(arguments.report.as_deref())?;
    let reports: Vec<&PathBuf> = arguments.reports().collect();
    let all: Vec<&PathBuf> = paths.iter().chain(&film_path).chain(reports.iter().copied()).collect();
    inputs::refuse(&all, arguments.cache.as_slice())?;
    let style = arguments.common.progress.style(std::io::stderr().is_terminal());
    let pool = thread_pool(&arguments.common)?;
    let overrides = arguments.overriding.overrides();
    let (mut scene, mut settings) = pool.install(|| prepare(&arguments.scene, overrides, &all, style))?;
    let wants_aov = settings.aov;
    // Errors are estimated by them.
    settings.halves |= arguments.film.noise.is_some() || !reports.is_empty();
    let method = arguments.denoise.map(|denoiser| denoiser.for_render(&settings)).transpose()?;
    if method.is_some() {
        if let Some(part) = arguments.film.part() {
            let remedy =
                "leave --denoise out, render with --aov --aov-through, merge, and denoise with `halfdome denoise`";
            return Err(invalid(format!("{part} is no picture that could be denoised"), remedy));
        }
        settings = denoiser::prepare(settings);
    }
    memory::check_denoised(&settings, method.as_ref())?;
    let has_aovs =
        wants_aov || settings.light_groups || !settings.aovs.is_empty() || !settings.cryptomatte.kinds.is_empty();
    if has_aovs && film_path.is_none() && arguments.tev.is_none() && !paths.iter().any(|path| is_exr(path)) {
        let warning = "AOVs were requested, but PNG has none: add an .exr output (-o)";
        scene.warnings.push(warning.to_owned());
    }
    let [stats_file, report_file] = [&arguments.stats_json, &arguments.report]
        .map(|path| path.as_deref().map(|path| OutputFile::check(path).map_err(CliError::input)).transpose());
    let (stats_file, report_file) = (stats_file?, report_file?);
    let film_file = film_path.as_deref().map(|path| OutputFile::check(path).map_err(CliError::input)).transpose()?;
    let checkpoint = match (&film_path, arguments.film.interval()) {
        (Some(path), Some(interval)) => Some(Checkpoint::new(path, interval)?),
        _ => None,
    };
    let tev = match &arguments.tev {
        Some(address) => Some(Tev::connect(address, &shown_name(&paths, &arguments.scene), style)?),
        None => None,
    };
    let lit = scene.has_light();
    if settings.integrator.needs_light() && !lit {
        scene.warnings.push(without_light(&scene));
    }

    let mut warnings = std::mem::take(&mut scene.warnings);
    let scene_name = arguments.scene.display().to_string();
    let facts = SceneFacts::of(scene_name.clone(), &scene);
    let model = scene.files.first().cloned();
    let mut seconds = Seconds { load: recorder.lap(), ..Seconds::default() };
    let building = StageProgress::of_build(style, scene.triangle_count());
    let watch = |fraction| building.advance(fraction);
    let world = pool.install(|| World::build(scene, &settings.build.into(), &RayonExecutor(&watch)));
    let world = world.map_err(CliError::input)?;
    drop(building);
    seconds.build = recorder.lap();
    let facts = facts.with_world(&world);
    if settings.integrator == Integrator::HeatLights {
        print_light_colors(style, &world);
    }
    let cache = match &arguments.cache {
        Some(path) => Some(read_cache(Some(path), &cached_options(&settings)?, &world)?),
        None => None,
    };
    warnings.extend(world.dropped(model.as_deref()));
    let far = world.instances_out_of_range();
    if far > 0 {
        let far = count(far, "instance reaches", "instances reach");
        warnings.push(format!(
            "{far} beyond {:e} from the origin, too far away to be seen",
            halfdome_kernel::MAX_COORDINATE
        ));
    }
    warnings.extend(unmatched_labels(&world, &settings.aovs));
    let before = match &film_path {
        Some(path) if arguments.film.resume => begun(path, &world, &settings, cache.as_ref(), style)?,
        _ => None,
    };
    warnings.extend(before.as_ref().and_then(|film| more_samples(film, settings.spp)));
    let mut report =
        RenderReport { scene: scene_name, settings: &settings, threads: pool.current_num_threads(), warnings, told };
    report.print_start(style);

    interrupt::catch()?;
    let progress = Progress::start(style, samples(&settings) / u64::from(arguments.film.shard().count()));
    if let Some(film) = &before {
        crate::watch::Watch::advance(&progress, film.total_samples(), 0);
    }
    let tone = arguments.tone.mapping();
    let watch = RenderWatch {
        progress: &progress,
        coarsest: arguments.progressive,
        paths: &paths,
        tone: &tone,
        style,
        deadline: arguments.film.time.map(|time| begin + time),
        checkpoint: checkpoint.as_ref(),
        recorder: (!reports.is_empty()).then_some(&recorder),
        tev: tev.as_ref(),
    };
    let (shard, first_sample) = (arguments.film.shard(), arguments.film.first_sample);
    let plan = Plan { cache, film: before, shard, first_sample, noise: arguments.film.noise };
    let mut result = pool.install(|| driver::render_plan(&world, &settings, plan, &watch)).map_err(CliError::input)?;
    let mut end = match result.finished {
        true if result.is_precise => End::Done,
        true => End::Limit,
        false if interrupt::requested() => End::Interrupted,
        false => End::Limit,
    };
    drop(progress);
    recorder.lap();
    let mut denoised = Ok(());
    if let Some(method) = &method {
        denoised = if end == End::Interrupted {
            Err(DenoiseError::Stopped)
        } else {
            // A picture that cannot be denoised is still written.
            denoiser::denoise(method, result.picture.clone(), &pool, style).map(|picture| {
                result.picture = if wants_aov { picture } else { without_aov(picture) };
            })
        };
    }
    if denoised == Err(DenoiseError::Stopped) {
        end = End::Interrupted;
        let warning =
            "interrupted before the picture was denoised: it is noisy; an .exr has all that `halfdome denoise` needs";
        report.warn(style, warning.to_owned());
    }
    if let Some(tev) = &tev {
        tev.show(&result.picture, false);
    }
    let is_whole = result.finished && arguments.film.part().is_none();
    if settings.integrator.needs_light() && lit && is_whole && is_black(&result.picture) {
        let warning = "the picture is black although the scene has lights: emitters may face away (try --emission both), \
                       or the camera may see nothing that is lit";
        report.warn(style, warning.to_owned());
    }
    if let (Integrator::Cached(options), Some(estimated)) = (&settings.integrator, result.cache_error)
        && let Some(warning) = options.accuracy.and_then(|asked| missed_accuracy(asked, estimated, MORE_RECORDS))
    {
        report.warn(style, warning);
    }
    if let Some(warning) = bad_samples(&result.film) {
        report.warn(style, warning);
    }

    if end == End::Interrupted && arguments.sequence.frames.is_some() && checkpoint.is_none() {
        // A frame of a sequence that is there is taken for a whole one.
        report.warn(style, "interrupted: this frame is not written".to_owned());
        report.print_end(style, &result, end, &[]);
        return Ok(EXIT_INTERRUPTED);
    }
    let (mut written, mut failures) = write_all(&paths, &result.picture, &tone);
    if let (Some(file), Some(path)) = (&film_file, film_path) {
        match file.write(&result.film.encode()) {
            Ok(()) => written.push(path),
            Err(error) => failures.push(error.to_string()),
        }
    }
    if !reports.is_empty() {
        seconds = Seconds { render: result.elapsed.as_secs_f64(), output: recorder.lap(), ..seconds };
        let options = Options::of(&settings, arguments.film.noise);
        let files = written.iter().map(|path| path.display().to_string()).collect();
        let statistics = Statistics {
            seconds,
            files,
            threads: report.threads,
            warnings: report.warnings.clone(),
            ..Statistics::of(facts, options, &result, recorder.into_history(), end)
        };
        let json = serde_json::to_string_pretty(&statistics).map(|json| json + "\n").map_err(|it| it.to_string());
        let html = report::html(&statistics, &result.picture, &result.film, &tone).map_err(|it| it.to_string());
        let texts = [(&stats_file, &arguments.stats_json, json), (&report_file, &arguments.report, html)];
        for (file, path, text) in texts {
            let (Some(file), Some(path)) = (file, path) else { continue };
            match text.and_then(|text| file.write(text.as_bytes()).map_err(|error| error.to_string())) {
                Ok(()) => written.push(path.clone()),
                Err(error) => failures.push(error),
            }
        }
    }
    if let Err(DenoiseError::Failed(message)) = denoised {
        failures.push(format!("the picture is noisy, as it could not be denoised: {message}"));
    }
    refuse_failures(&written, failures)?;
    report.print_end(style, &result, end, &written);
    Ok(match end {
        End::Done => EXIT_DONE,
        End::Interrupted => EXIT_INTERRUPTED,
        End::Limit => EXIT_LIMIT,
    })
}

/// As many lights as are named with their colours.
const NAMED_LIGHTS: usize = 24;

/// Says which colour is which light's.
fn print_light_colors(style: Style, world: &World) {
    let colors = world.light_colors();
    let tone = ToneMapping::default();
    for (name, color) in colors.iter().take(NAMED_LIGHTS) {
        let [red, green, blue] = tone.to_srgb8(color.to_array());
        print_text(style, &format!("#{red:02x}{green:02x}{blue:02x} {name}"));
    }
    if colors.len() > NAMED_LIGHTS {
        print_text(style, &format!("and {} more", colors.len() - NAMED_LIGHTS));
    }
}

/// The warning about samples that are not finite, if there are any.
pub(crate) fn bad_samples(film: &Film) -> Option<String> {
    let BadSamples { count: number, first: Some((row, column)) } = film.bad_samples() else { return None };
    let samples =
        count(number as usize, "sample is not a finite number and counts", "samples are not finite numbers and count");
    Some(format!("{samples} as black, the first at pixel ({column}, {row})"))
}

/// The warning about a scene without light.
fn without_light(scene: &Scene) -> String {
    if !scene.lights.is_empty() {
        return "all lights of the scene have a strength of 0, so the picture is black".to_owned();
    }
    let from_gltf = scene.meshes.iter().any(|mesh| mesh.origin.is_some());
    let export = match from_gltf {
        true => ", or export the lights: Blender leaves them out unless Include > Punctual Lights is on",
        false => "",
    };
    format!("the scene has no light, so the picture is black; give it a --sky{export}")
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
