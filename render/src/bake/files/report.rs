//! The HTML report of a bake.
//!
//! Each page is shown as a row of pictures: its light, its charts in colours, the density of texels, where the cache
//! put its records, and an estimate of the error if there is one. Pictures larger than 1024 texels leave texels out.

use std::path::Path;

use glam::Vec3;

use crate::output::false_color;
use crate::output::html::{Html, OUTSIDE, Plane, escaped, percentile};
use crate::output::{OutputError, ToneMapping};

/// The contents of the report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Its headline.
    pub title: String,
    /// Names and values of all figures.
    pub statistics: Vec<(String, String)>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// The pages of the lightmap.
    pub pages: Vec<ReportPage>,
}

/// A page of the lightmap. Lists of texels are row by row from the top, `width * height` long.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReportPage {
    /// Its file's name.
    pub name: String,
    /// Texels across, at least 1.
    pub width: u32,
    /// Texels down, at least 1.
    pub height: u32,
    /// The index of each texel's chart; `None` outside of all.
    pub charts: Vec<Option<u32>>,
    /// Texels per unit of length at each texel; not a number outside.
    pub density: Vec<f32>,
    /// Irradiance, W/m².
    pub map: Vec<Vec3>,
    /// Where the cache's records are, in 0..=1 from the upper left.
    pub records: Vec<[f32; 2]>,
    /// An estimate of each texel's relative error; not a number outside.
    pub error: Option<Vec<f32>>,
}

/// A record, on dark charts.
const RECORD: [u8; 3] = [255, 214, 64];

/// The report as HTML.
///
/// # Errors
/// If a page has not as many texels as its size says.
pub fn html(report: &Report) -> Result<String, OutputError> {
    let mut html = Html::new(&report.title);
    report.warnings.iter().for_each(|warning| html.warning(warning));
    html.table(&report.statistics);
    for page in &report.pages {
        page.check()?;
        let plane = page.plane();
        let charts = page.charts.iter().flatten().max().map_or(0, |last| last + 1);
        html.line(&format!("<h2>{} <small>{} × {}</small></h2>", escaped(&page.name), page.width, page.height));
        html.line("<div class=\"page\">");
        let exposure = page.exposure();
        let tone = ToneMapping { exposure, ..ToneMapping::default() };
        let light = format!("Light, brightened by {exposure:+.1} stops");
        html.figure(&plane, ["", &light, ""], |texel| tone.to_srgb8(page.map[texel].to_array()))?;
        let shown = format!("{charts} charts");
        html.figure(&plane, ["", &shown, ""], |texel| page.charts[texel].map_or(OUTSIDE, color))?;
        html.heat(&plane, "Density, texels per unit", &page.density)?;
        if !page.records.is_empty() {
            let records = page.record_texels();
            html.figure(&plane, ["", &format!("{} records", page.records.len()), ""], |texel| {
                let dim = page.charts[texel].map_or(OUTSIDE, |chart| color(chart).map(|code| code / 3));
                if records[texel] { RECORD } else { dim }
            })?;
        }
        if let Some(error) = &page.error {
            html.heat(&plane, "Relative error, estimated", error)?;
        }
        html.line("</div>");
    }
    Ok(html.finish())
}

impl ReportPage {
    fn check(&self) -> Result<(), OutputError> {
        let texels = self.width as usize * self.height as usize;
        let lists = [self.charts.len(), self.density.len(), self.map.len()];
        let all = lists.into_iter().chain(self.error.as_ref().map(Vec::len));
        if texels == 0 || all.into_iter().any(|length| length != texels) {
            let problem = format!("the report has not {} x {} texels of everything", self.width, self.height);
            return Err(OutputError::new(Path::new(&self.name), problem, "give one value for each texel"));
        }
        Ok(())
    }

    /// Stops by which the map is brightened so that 99% of its texels are no brighter than the screen.
    fn exposure(&self) -> f32 {
        let bright = percentile(self.map.iter().map(|texel| texel.max_element()));
        if bright > 0.0 { (1.0 / bright).log2() } else { 0.0 }
    }

    fn record_texels(&self) -> Vec<bool> {
        let mut texels = vec![false; self.charts.len()];
        let place = |part: f32, size: u32| ((part * size as f32) as u32).min(size - 1) as usize;
        // Records of large pages are drawn as large as a texel of the picture.
        let step = self.plane().step() as usize;
        for &[x, y] in &self.records {
            let (x, y) = (place(x, self.width) / step * step, place(y, self.height) / step * step);
            texels[y * self.width as usize + x] = true;
        }
        texels
    }

    fn plane(&self) -> Plane<'_> {
        Plane { name: &self.name, width: self.width, height: self.height }
    }
}

/// A colour for chart `number`, of any hue.
fn color(number: u32) -> [u8; 3] {
    let hue = false_color::categorical_hue(number) * 6.0;
    let channel = |offset: f64| {
        let distance = ((hue + offset) % 6.0 - 3.0).abs() - 1.0;
        (70.0 + 170.0 * distance.clamp(0.0, 1.0)).round() as u8
    };
    [channel(0.0), channel(4.0), channel(2.0)]
}

#[cfg(test)]
mod tests {
    use base64::Engine as _;
    use base64::engine::general_purpose::STANDARD;

    use super::*;

    fn page(width: u32, height: u32) -> ReportPage {
        let texels = (width * height) as usize;
        ReportPage {
            name: "a <b>.ktx2".to_owned(),
            width,
            height,
            charts: (0..texels).map(|texel| (texel > 0).then_some(texel as u32 % 3)).collect(),
            density: (0..texels).map(|texel| if texel > 0 { texel as f32 } else { f32::NAN }).collect(),
            map: vec![Vec3::splat(4.0); texels],
            records: vec![[0.0, 0.0], [1.0, 1.0]],
            error: Some(vec![0.01; texels]),
        }
    }

    /// The codes of each picture of the report.
    fn pictures(html: &str) -> Vec<(u32, Vec<u8>)> {
        let sources = html.split("base64,").skip(1).map(|rest| rest.split('"').next().unwrap());
        let decode = |base64| {
            let png = STANDARD.decode(base64).unwrap();
            let mut reader = png::Decoder::new(std::io::Cursor::new(&png)).read_info().unwrap();
            let mut codes = vec![0; reader.output_buffer_size().unwrap()];
            let width = reader.next_frame(&mut codes).unwrap().width;
            (width, codes)
        };
        sources.map(decode).collect()
    }

    #[test]
    fn pages_are_shown_in_five_pictures() {
        let report = Report {
            title: "level & more".to_owned(),
            statistics: vec![("Texels".to_owned(), "6".to_owned())],
            warnings: vec!["<careful>".to_owned()],
            pages: vec![page(3, 2)],
        };
        let html = html(&report).unwrap();
        for text in ["<h1>level &amp; more</h1>", "<th>Texels</th><td>6</td>", "&lt;careful&gt;", "a &lt;b&gt;.ktx2"] {
            assert!(html.contains(text), "{text}");
        }
        assert!(!html.contains("http") && !html.contains("<careful>"), "nothing is fetched, and text is escaped");
        let pictures = pictures(&html);
        assert_eq!(pictures.iter().map(|(width, codes)| (*width, codes.len())).collect::<Vec<_>>(), [(3, 18); 5]);
        let [light, charts, density, records, error] = <[_; 5]>::try_from(pictures).unwrap().map(|(_, codes)| codes);
        assert_eq!(light, [255; 18], "the brightest 99% fill the screen");
        assert!(html.contains("brightened by -2.0 stops"));
        assert_eq!((&charts[..3], &charts[3..6]), (OUTSIDE.as_slice(), color(1).as_slice()));
        assert_eq!((&charts[6..9], &charts[9..12]), (color(2).as_slice(), color(0).as_slice()));
        assert_eq!((&density[..3], &density[15..]), (OUTSIDE.as_slice(), false_color::color(1.0).as_slice()));
        assert_eq!((&records[..3], &records[15..]), (RECORD.as_slice(), RECORD.as_slice()));
        assert_eq!(error, false_color::color(1.0).repeat(6));
    }

    #[test]
    fn large_pages_are_shown_smaller() {
        let report = Report { pages: vec![page(2500, 2)], ..Report::default() };
        let pictures = pictures(&html(&report).unwrap());
        assert!(pictures.iter().all(|(width, codes)| (*width, codes.len()) == (834, 834 * 3)));
        let records: Vec<_> = pictures[3].1.chunks_exact(3).enumerate().filter(|(_, code)| *code == RECORD).collect();
        assert_eq!(records.len(), 2, "no record is lost between the texels that are shown");
    }

    #[test]
    fn a_page_of_the_wrong_size_is_an_error() {
        let mut page = page(3, 2);
        page.density.pop();
        let error = html(&Report { pages: vec![page], ..Report::default() }).unwrap_err();
        assert_eq!(error.problem, "the report has not 3 x 2 texels of everything");
    }

    #[test]
    fn neighbouring_charts_differ() {
        for number in 0..200 {
            let [a, b] = [color(number), color(number + 1)];
            let difference: i32 = (0..3).map(|i| (i32::from(a[i]) - i32::from(b[i])).abs()).sum();
            assert!(difference > 60, "{number}: {a:?}, {b:?}");
        }
    }
}
