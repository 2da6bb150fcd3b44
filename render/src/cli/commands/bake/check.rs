//! `halfdome bake --check-uv`: a check of lightmap coordinates.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::inside::left_out;
use crate::bake::atlas::{Atlas, Layout, mesh_name};
use crate::bake::check::{Check, Lost};
use crate::bake::{BakeOptions, charts_picture};
use crate::cli::error::{CliError, EXIT_DONE, invalid};
use crate::cli::inputs;
use crate::cli::messages::Style;
use crate::cli::print::print;
use crate::output::{Format, OutputFile, encode_png};
use crate::scene::{Scene, count};
use crate::world::{LightQuery, World};

/// Pairs of charts that are listed.
const MAX_LISTED: usize = 10;

/// Checks the name of the picture, before the model is read.
pub(super) fn check_name(picture: Option<&Path>) -> Result<(), CliError> {
    match picture.filter(|path| Format::from_path(path) != Ok(Format::Png)) {
        None => Ok(()),
        Some(path) => {
            let problem = format!("{}: the picture of --check-uv is a PNG", path.display());
            Err(invalid(problem, "give a name that ends in .png"))
        }
    }
}

/// Checks, prints what was found, and writes the picture; the exit code says whether light can be baked.
pub(super) fn run(scene: &Scene, options: &BakeOptions, picture: Option<&Path>, style: Style) -> Result<u8, CliError> {
    let atlas = match Atlas::of_model(scene, options)? {
        Some(atlas) => atlas,
        None if options.skip_outside.is_some() => {
            let world = World::for_light_query(scene.clone(), LightQuery::Surfaces).map_err(CliError::input)?;
            Atlas::without(scene, &left_out(scene, &world, options, style)?, options)?
        }
        None => Atlas::new(scene, options)?,
    };
    let found = atlas.check(scene, options);
    let pictures: Vec<(PathBuf, OutputFile)> = picture
        .map(|path| pages(path, atlas.pages.len()))
        .unwrap_or_default()
        .into_iter()
        .map(|path| OutputFile::check(&path).map(|file| (path, file)))
        .collect::<Result<_, _>>()
        .map_err(CliError::input)?;
    inputs::refuse(&pictures.iter().map(|(path, _)| path).collect::<Vec<_>>(), &scene.files)?;
    print(&text(scene, &atlas, &found))?;
    for (index, (path, file)) in pictures.iter().enumerate() {
        let page = atlas.pages[index];
        let pixels = charts_picture(&atlas, &found, index);
        let bytes = encode_png(path, page.width, page.height, &pixels).map_err(CliError::system)?;
        file.write(&bytes).map_err(CliError::system)?;
    }
    if found.passes() { Ok(EXIT_DONE) } else { Err(CliError::Failed(reasons(&found))) }
}

/// Why light cannot be baked into these coordinates.
fn reasons(found: &Check) -> String {
    let lost: u64 = found.lost.iter().map(Lost::total).sum();
    let mut reasons = Vec::new();
    if found.overlapping > 0 {
        reasons.push(format!("{} overlap", count(found.overlapping as usize, "texel", "texels")));
    }
    if lost > 0 {
        reasons.push(format!("{} have no texel", count(lost as usize, "triangle", "triangles")));
    }
    let help = "unwrap the model again without overlaps, or bake with --uv new";
    format!("light cannot be baked into these coordinates: {}\n  help: {help}", reasons.join(", "))
}

/// A name for the picture of each page.
fn pages(path: &Path, pages: usize) -> Vec<PathBuf> {
    let numbered = |number: usize| {
        let mut name = path.file_stem().unwrap_or_default().to_owned();
        name.push(format!("-{number}."));
        name.push(path.extension().unwrap_or_default());
        path.with_file_name(name)
    };
    if pages == 1 { vec![path.to_owned()] } else { (0..pages).map(numbered).collect() }
}

/// The results as text.
fn text(scene: &Scene, atlas: &Atlas, found: &Check) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:14} {value}");
    };
    let own = atlas.parts.iter().any(|part| part.layout == Layout::Kept);
    line("coordinates", if own { "the model's second set".to_owned() } else { "new ones".to_owned() });
    let sizes: Vec<String> = atlas.pages.iter().map(|page| format!("{}x{}", page.width, page.height)).collect();
    line("pages", format!("{} ({})", atlas.pages.len(), sizes.join(", ")));
    line("charts", found.charts.to_string());
    line("fill", format!("{:.1}%", 100.0 * found.fill));
    line("overlapping", count(found.overlapping as usize, "texel", "texels"));
    let chart = |index: usize| {
        let mesh = atlas.parts[atlas.charts[index].part].mesh;
        format!("chart {index} of {}", mesh_name(scene, mesh))
    };
    for overlap in found.overlaps.iter().take(MAX_LISTED) {
        let texels = count(overlap.texels as usize, "texel", "texels");
        let [a, b] = overlap.charts;
        let pair = if a == b { format!("{} with itself", chart(a)) } else { format!("{} and {}", chart(a), chart(b)) };
        line("", format!("{texels}: {pair}"));
    }
    if found.overlaps.len() > MAX_LISTED {
        line("", format!("and {} pairs more", found.overlaps.len() - MAX_LISTED));
    }
    line(
        "crowded",
        format!("{} closer to another chart than the gutter", count(found.crowded as usize, "texel", "texels")),
    );
    line("stretched", count(found.stretched.len(), "chart", "charts"));
    for &index in found.stretched.iter().take(MAX_LISTED) {
        line("", format!("{}: {:.3} texels per unit", chart(index), atlas.charts[index].density()));
    }
    let lost =
        found.lost.iter().fold([0; 3], |[a, b, c], lost| [a + lost.not_finite, b + lost.outside, c + lost.no_area]);
    let [not_finite, outside, no_area] = lost;
    line("lost", count((not_finite + outside + no_area) as usize, "triangle", "triangles"));
    line("", format!("{not_finite} not finite, {outside} out of 0 to 1, {no_area} without an area"));
    text
}
