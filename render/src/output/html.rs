//! HTML reports in a single file, with embedded style and pictures as data URIs.

use std::fmt::Write as _;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::{OutputError, encode_png, false_color};

/// The longest side of a picture in a report; larger ones leave pixels out.
const MAX_SIDE: u32 = 1024;
const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;margin:2em auto;max-width:1200px;padding:0 1em;\
background:#fafafa;color:#222}table{border-collapse:collapse}td,th{padding:.2em 1em .2em 0;text-align:left;\
border-bottom:1px solid #ddd}td{font-variant-numeric:tabular-nums}.page{display:flex;flex-wrap:wrap;gap:1em}\
figure{margin:0;width:min(380px,100%)}figure.wide{width:100%}img{width:100%;image-rendering:pixelated;display:block}\
figcaption{font-size:13px}.scale{height:8px;margin-top:4px}.warning{color:#a40}";
/// The sRGB codes of what has no value, and of texels outside of charts.
pub(crate) const OUTSIDE: [u8; 3] = [24, 24, 28];

/// A report that is being written.
pub(crate) struct Html(String);

/// A picture in a report, row by row from the top.
pub(crate) struct Plane<'a> {
    /// The name for errors.
    pub name: &'a str,
    /// Pixels across, at least 1.
    pub width: u32,
    /// Pixels down, at least 1.
    pub height: u32,
}

impl Html {
    /// The head, and a headline.
    pub(crate) fn new(title: &str) -> Self {
        let title = escaped(title);
        Self(format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
             content=\"width=device-width\"><title>{title}</title><style>{STYLE}</style></head><body>\n<h1>{title}</h1>\n"
        ))
    }

    /// The whole file.
    pub(crate) fn finish(mut self) -> String {
        self.0.push_str("</body></html>\n");
        self.0
    }

    /// A line of HTML, which must be valid.
    pub(crate) fn line(&mut self, html: &str) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{html}");
    }

    pub(crate) fn warning(&mut self, text: &str) {
        self.line(&format!("<p class=\"warning\">Warning: {}</p>", escaped(text)));
    }

    /// Names and values.
    pub(crate) fn table(&mut self, rows: &[(String, String)]) {
        self.line("<table>");
        for (name, value) in rows {
            self.line(&format!("<tr><th>{}</th><td>{}</td></tr>", escaped(name), escaped(value)));
        }
        self.line("</table>");
    }

    /// A picture with a caption; `class` is one of the style's, `scale` is HTML between them.
    pub(crate) fn figure(
        &mut self,
        plane: &Plane<'_>,
        [class, caption, scale]: [&str; 3],
        color: impl Fn(usize) -> [u8; 3],
    ) -> Result<(), OutputError> {
        let step = plane.step();
        let size = |texels: u32| texels.div_ceil(step);
        let mut codes = Vec::with_capacity(3 * (size(plane.width) * size(plane.height)) as usize);
        for y in (0..plane.height).step_by(step as usize) {
            for x in (0..plane.width).step_by(step as usize) {
                codes.extend(color(y as usize * plane.width as usize + x as usize));
            }
        }
        let png = encode_png(Path::new(plane.name), size(plane.width), size(plane.height), &codes)?;
        let (caption, png) = (escaped(caption), STANDARD.encode(png));
        let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
        self.line(&format!(
            "<figure{class}><img alt=\"{caption}\" src=\"data:image/png;base64,{png}\">{scale}<figcaption>{caption}\
             </figcaption></figure>"
        ));
        Ok(())
    }

    /// Numbers in false colours up to their 99th percentile, with a scale; what is not a number is outside.
    pub(crate) fn heat(&mut self, plane: &Plane<'_>, caption: &str, values: &[f32]) -> Result<(), OutputError> {
        let greatest = percentile(values.iter().copied()).max(f32::MIN_POSITIVE);
        let stops: Vec<String> = (0..=8).map(|stop| hex(false_color::color(stop as f32 / 8.0))).collect();
        let scale =
            format!("<div class=\"scale\" style=\"background:linear-gradient(90deg,{})\"></div>", stops.join(","));
        let caption = format!("{caption}: {} to {}", format_number(0.0), format_number(greatest));
        self.figure(plane, ["", &caption, &scale], |texel| match values[texel] {
            value if value.is_nan() => OUTSIDE,
            value => false_color::color(value / greatest),
        })
    }
}

impl Plane<'_> {
    /// Every how many pixels one is shown.
    pub(crate) fn step(&self) -> u32 {
        self.width.max(self.height).div_ceil(MAX_SIDE)
    }
}

/// The value below which 99% of all finite ones are; 0 if there are none.
pub(crate) fn percentile(values: impl Iterator<Item = f32>) -> f32 {
    let mut sorted: Vec<f32> = values.filter(|value| value.is_finite()).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    sorted.get(sorted.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(0.0)
}

fn format_number(number: f32) -> String {
    match number {
        0.0 => "0".to_owned(),
        _ if (0.01..10_000.0).contains(&number) => format!("{number:.2}"),
        _ => format!("{number:.1e}"),
    }
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
