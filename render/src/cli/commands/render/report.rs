//! The HTML report of a render (`--report`): the picture, its error against time and over the picture, times, the
//! options, in one file.

use std::path::Path;

use super::statistics::{Moment, RayFacts, Statistics};
use crate::cli::memory;
use crate::film::{Film, Picture};
use crate::output::html::{Html, Plane};
use crate::output::plot::{Axis, Figure, Point, Series, svg};
use crate::output::{OutputError, ToneMapping};

/// The report of a render with this picture, as PNG pictures are made.
pub(super) fn html(
    statistics: &Statistics,
    picture: &Picture,
    film: &Film,
    tone: &ToneMapping,
) -> Result<String, OutputError> {
    let plane = Plane { name: "report", width: picture.width, height: picture.height };
    let mut html = Html::new(&statistics.scene.name);
    statistics.warnings.iter().for_each(|warning| html.warning(warning));
    let colors = ["R", "G", "B"].map(|name| picture.channel(name).map(|channel| &channel.values));
    if let [Some(red), Some(green), Some(blue)] = colors {
        let caption = format!("{} × {}, {} samples", picture.width, picture.height, samples(statistics));
        html.figure(&plane, ["wide", &caption, ""], |i| tone.to_srgb8([red[i], green[i], blue[i]]))?;
    }
    html.line("<h2>Figures</h2>");
    html.table(&rows(statistics));
    html.line("<h2>Error</h2>");
    match convergence(&statistics.history) {
        Some(figure) => html.line(&svg(&figure)),
        None => html.line("<p>There are too few samples to tell.</p>"),
    }
    html.line("<div class=\"page\">");
    if let Some(errors) = film.relative_errors() {
        html.heat(&plane, "Relative error of tiles, estimated", &errors)?;
    }
    if statistics.least_samples != statistics.most_samples {
        html.heat(&plane, "Samples of pixels", &film.sample_counts())?;
    }
    html.line("</div>");
    Ok(html.finish())
}

fn samples(statistics: &Statistics) -> String {
    match (statistics.least_samples, statistics.most_samples) {
        (least, most) if least == most => format!("{most}"),
        (least, most) => format!("{least} to {most}"),
    }
}

/// Names and values of all figures.
fn rows(statistics: &Statistics) -> Vec<(String, String)> {
    let (scene, options, seconds) = (&statistics.scene, &statistics.options, &statistics.seconds);
    let mut rows = Vec::new();
    let mut row = |name: &str, value: String| rows.push((name.to_owned(), value));
    row("Ended", statistics.end.to_owned());
    row(
        "Estimated relative error",
        statistics.error.map_or("unknown".to_owned(), |error| format!("{:.2}%", 100.0 * error)),
    );
    if let Some(target) = options.target {
        row("Target", format!("{:.2}%", 100.0 * target));
    }
    row("Samples of a pixel", format!("{} of {}", samples(statistics), options.spp));
    row("Integrator", options.integrator.to_owned());
    row("Sampler, seed", format!("{}, {}", options.sampler, options.seed));
    let time = |seconds: f64| format!("{seconds:.2} s");
    row("Time, in all", time(statistics.duration().as_secs_f64()));
    row("Reading the scene", time(seconds.load));
    row("Building", time(seconds.build));
    row("Rendering", time(seconds.render));
    row("Denoising and writing", time(seconds.output));
    row("Threads", statistics.threads.to_string());
    let (rays, rate) = (statistics.rays as f64 / 1e6, statistics.rays_per_second / 1e6);
    row("Rays", format!("{rays:.1} million, {rate:.2} million a second"));
    let RayFacts { preparation, camera, bounce, shadow } = statistics.rays_by_kind;
    for (name, count) in [
        ("Rays from the camera", camera),
        ("Rays from surfaces", bounce),
        ("Shadow rays", shadow),
        ("Rays before the first sample", preparation),
    ] {
        if count > 0 {
            let part = 100.0 * count as f64 / statistics.rays as f64;
            row(name, format!("{:.1} million ({part:.0}%)", count as f64 / 1e6));
        }
    }
    row(
        "Rays for each camera sample",
        format!("{:.2}", statistics.rays as f64 / statistics.camera_samples.max(1) as f64),
    );
    if statistics.bad_samples > 0 {
        row("Samples that are not numbers", statistics.bad_samples.to_string());
    }
    let kept = if scene.instances > 0 {
        format!(", {} kept, {} instances", scene.stored_triangles, scene.instances)
    } else {
        String::new()
    };
    row("Triangles", format!("{}{kept}", scene.triangles));
    row("Meshes, materials, textures", format!("{}, {}, {}", scene.meshes, scene.materials, scene.textures));
    row("Trees", memory::size((scene.tree_bytes + scene.instance_bytes) as u64));
    if let Some(seconds) = statistics.processor_seconds {
        row("Processor time", format!("{seconds:.1} s"));
    }
    if let Some(peak) = statistics.peak_memory {
        row("Memory, at most", memory::size(peak));
    }
    row("Scene's hash", scene.hash.clone());
    row("Picture's hash", statistics.picture_hash.clone());
    row("Instruction set", statistics.instruction_set.to_owned());
    row("Version", statistics.version.to_owned());
    row("Arguments", statistics.arguments.join(" "));
    let names = statistics.files.iter().map(|file| Path::new(file).file_name().unwrap_or_default().to_string_lossy());
    row("Files", names.collect::<Vec<_>>().join(", "));
    rows
}

/// The error against time; `None` with fewer than two points.
fn convergence(history: &[Moment]) -> Option<Figure> {
    let points = history.iter().filter_map(|moment| {
        let y = 100.0 * moment.error.filter(|error| *error > 0.0)?;
        (moment.seconds > 0.0).then_some(Point { x: moment.seconds, y, error: 0.0 })
    });
    let points: Vec<Point> = points.collect();
    let ([first, .., last], true) = (&points[..], points.len() > 1) else { return None };
    let decade = |value: f64, up: bool| 10f64.powf(if up { value.log10().ceil() } else { value.log10().floor() });
    let (least, most) = points.iter().fold((f64::MAX, 0.0), |(least, most), it| (it.y.min(least), it.y.max(most)));
    let slope = |x: f64| first.y * (first.x / x).sqrt();
    let (from, to) = (decade(first.x, false), decade(last.x, true));
    Some(Figure {
        name: "convergence",
        title: "Error against time".to_owned(),
        x: Axis::logarithmic("seconds", from, to.max(10.0 * from)),
        y: Axis::logarithmic(
            "estimated relative error, %",
            decade(least, false),
            decade(most, true).max(10.0 * decade(least, false)),
        ),
        series: vec![
            Series::measured("this render", points.clone()),
            Series::exact("as 1 / √time", [first.x, last.x], slope),
        ],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_drawn_from_two_points_on() {
        let at = |seconds: f64, error: Option<f64>| Moment { seconds, camera_samples: 1, error };
        assert!(convergence(&[]).is_none());
        assert!(convergence(&[at(1.0, None), at(2.0, Some(0.1))]).is_none());
        assert!(convergence(&[at(1.0, Some(0.0)), at(2.0, Some(0.1))]).is_none());
        let figure = convergence(&[at(0.5, None), at(1.0, Some(0.2)), at(4.0, Some(0.1))]).unwrap();
        let places: Vec<[f64; 2]> = figure.series[0].points.iter().map(|point| [point.x, point.y]).collect();
        assert_eq!(places, [[1.0, 20.0], [4.0, 10.0]]);
        let slope: Vec<f64> = figure.series[1].points.iter().map(|point| point.y).collect();
        assert_eq!(slope, [20.0, 10.0]);
        assert!(svg(&figure).contains("Error against time"));
    }
}
