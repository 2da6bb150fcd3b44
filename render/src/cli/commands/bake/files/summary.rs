//! The summary of a bake: its report, and what is printed at its end.

use std::path::PathBuf;

use serde_json::json;

use super::Files;
use crate::bake::atlas::NO_CHART;
use crate::bake::report::{Report, ReportPage};
use crate::bake::{self, Bake};
use crate::cli::commands::bake::print_text;
use crate::cli::messages::{Style, print_line};
use crate::cli::progress::job::accuracy_text;
use crate::scene::{Scene, count};

impl Files {
    /// The report, in which pages are shown.
    pub(super) fn report(&self, scene: &Scene, bake: &Bake, warnings: &[String]) -> Report {
        let s = &bake.statistics;
        // No rays: a bake that was resumed counts its own alone, and its report is that of one that was not.
        let figures: [(&str, u64); 7] = [
            ("meshes", scene.meshes.len() as u64),
            ("charts", bake.atlas.charts.len() as u64),
            ("texels on surfaces", s.texels),
            ("hemispheres gathered", s.gathers),
            ("texels moved out from under other objects", s.moved),
            ("texels covered as a whole", s.covered),
            ("points matched at seams", s.seams),
        ];
        let page = |page: usize| {
            let (size, map) = (bake.atlas.pages[page], &bake.maps[page]);
            let chart = |&owner: &u32| (owner != NO_CHART).then_some(owner);
            let density =
                |&owner: &u32| chart(&owner).map_or(f32::NAN, |owner| bake.atlas.charts[owner as usize].density());
            let known = |(&error, &source): (&f32, &bake::TexelSource)| {
                if source == bake::TexelSource::Light { error } else { f32::NAN }
            };
            ReportPage {
                name: self.page(page, "exr"),
                width: size.width,
                height: size.height,
                charts: map.owners.iter().map(chart).collect(),
                density: map.owners.iter().map(density).collect(),
                map: map.layers[0].texels.clone(),
                records: bake
                    .record_places
                    .iter()
                    .filter(|place| place.0 == page)
                    .map(|place| place.1.to_array())
                    .collect(),
                error: Some(map.errors.iter().zip(&map.sources).map(known).collect()),
            }
        };
        Report {
            title: self.model.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            statistics: figures
                .iter()
                .map(|(name, number)| ((*name).to_owned(), number.to_string()))
                .chain([("relative error, estimated".to_owned(), bake.error().text())])
                .collect(),
            warnings: bake.warnings.iter().chain(warnings).cloned().collect(),
            pages: (0..bake.maps.len()).map(page).collect(),
        }
    }

    /// Prints the figures, the error and the files.
    pub(in crate::cli::commands::bake) fn print(
        &self,
        style: Style,
        bake: &Bake,
        asked: Option<f32>,
        written: &[PathBuf],
    ) {
        let (s, error) = (&bake.statistics, bake.error());
        let share = 100.0 * s.gathers as f64 / s.texels.max(1) as f64;
        match style {
            Style::Silent => {}
            Style::Json => print_line(&json!({
                "event": "end",
                "accuracy": bake.accuracy,
                "pages": bake.maps.len(),
                "charts": bake.atlas.charts.len(),
                "texels": s.texels,
                "gathers": s.gathers,
                "rays": s.rays,
                "moved": s.moved,
                "covered": s.covered,
                "seams": s.seams,
                "misses": s.misses,
                "error": {
                    "root_mean_square": error.root_mean_square,
                    "median": error.median,
                    "percentile_95": error.percentile_95,
                    "above_5_percent": error.above_5_percent,
                },
                "files": written.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
            })),
            Style::Bar => {
                let pages = count(bake.maps.len(), "page", "pages");
                let texels = format!("{pages}, {} texels, {} gathers ({share:.1}%)", s.texels, s.gathers);
                let covered =
                    format!("{} texels moved out from under other objects, {} covered completely", s.moved, s.covered);
                print_text(style, &format!("{texels}, {} rays\n{covered}", s.rays));
                if let (Some(asked), Some(estimated)) = (asked, bake.accuracy) {
                    print_text(style, &accuracy_text(asked, estimated));
                }
                print_text(style, &format!("relative error, estimated: {}", error.text()));
                written.iter().for_each(|path| print_text(style, &format!("wrote {}", path.display())));
            }
        }
    }
}
