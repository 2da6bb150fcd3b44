//! The text beside the picture.

use glam::Vec3;

use super::keys::HELP;
use super::pick::{Pick, PickedSurface};
use super::session::{Page, Session};
use crate::driver::SampleHistory;
use crate::film::LUMINANCE;
use crate::lpe::Event;
use crate::settings::Settings;

/// Characters of a line.
pub const COLUMNS: usize = 54;
/// The column of values.
const LABEL: usize = 10;
/// Paths of less light than this part of their sample's are summed up.
const LITTLE: f32 = 0.005;

/// The style of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Of a part.
    Heading,
    /// Plain.
    Text,
    /// Of less weight.
    Faint,
    /// The picked surface.
    Chosen,
}

/// A line, of at most [`COLUMNS`] characters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// The text.
    pub text: String,
    /// The style.
    pub style: Style,
}

#[derive(Default)]
struct Lines(Vec<Line>);

impl Lines {
    fn heading(&mut self, text: impl Into<String>) {
        if !self.0.is_empty() {
            self.push("", Style::Text);
        }
        self.push(text, Style::Heading);
    }

    /// Lines of a text that is too long begin further in.
    fn push(&mut self, text: impl Into<String>, style: Style) {
        for text in wrap(&text.into(), COLUMNS) {
            self.0.push(Line { text, style });
        }
    }

    fn value(&mut self, label: &str, value: impl std::fmt::Display) {
        self.push(format!("{label:LABEL$}{value}"), Style::Text);
    }
}

impl Session {
    /// The text beside the picture, from where it is scrolled to, and no more than `rows` of it.
    pub fn text(&mut self, rows: usize) -> Vec<Line> {
        let lines = match self.page {
            Page::Picture => self.about_picture(),
            Page::Scene => self.about_scene(),
            Page::Help => help(),
        };
        self.scroll = self.scroll.min(lines.len().saturating_sub(rows));
        lines.into_iter().skip(self.scroll).take(rows).collect()
    }

    fn about_picture(&self) -> Vec<Line> {
        let mut lines = Lines::default();
        let Settings { width, height, spp, integrator, .. } = &self.settings;
        lines.heading(self.name.clone());
        lines.value("picture", format!("{width}x{height}, {}", integrator.name()));
        lines.value("samples", self.progress(*spp));
        if let Some(frame) = &self.frame {
            lines.value("rays", count(frame.rays));
        }
        let (layer, tone) = (self.layer(), self.tone);
        lines.value("shows", format!("{}  (a, A)", layer.name));
        match layer.is_toned() {
            true => lines.value("exposure", format!("{:+.1} stops, {}  ([ ] t)", tone.exposure, tone.curve.name())),
            false => lines.value("exposure", "-"),
        }
        if let Some(message) = &self.message {
            lines.heading(message.clone());
        }
        lines.heading("Camera");
        lines.value("eye", point(self.pose.eye));
        lines.value("target", point(self.pose.target));
        lines.value("distance", rounded(self.pose.eye.distance(self.pose.target)));
        match &self.pick {
            Some(pick) => self.about_pick(pick, &mut lines),
            None => lines.heading("Click on the picture to pick, h for help"),
        }
        lines.0
    }

    fn progress(&self, spp: u32) -> String {
        match &self.frame {
            None if self.prepares() => "none yet: the integrator prepares".to_owned(),
            None => "none yet".to_owned(),
            Some(frame) if frame.side > 1 => format!("1 for {side}x{side} pixels", side = frame.side),
            Some(frame) if frame.finished => format!("{spp}, done"),
            Some(frame) if frame.samples.start < frame.samples.end => {
                format!("{} to {} of {spp}", frame.samples.start, frame.samples.end)
            }
            Some(frame) => format!("{} of {spp}", frame.samples.start),
        }
    }

    fn about_pick(&self, pick: &Pick, lines: &mut Lines) {
        let (x, y) = pick.pixel;
        lines.heading(format!("Pixel {x}, {y}"));
        if let Some(frame) = &self.frame {
            let place = y as usize * self.settings.width as usize + x as usize;
            let value = |name: &String| frame.picture.channel(name)?.values.get(place).copied();
            let values: Vec<String> = self.layer().channels.iter().filter_map(value).map(rounded).collect();
            lines.value("value", values.join("  "));
        }
        match &pick.surface {
            None => lines.value("object", "none, the sky"),
            Some(surface) => {
                let PickedSurface { object, material, triangle, position, normal, shading_normal, distance } = surface;
                lines.value("object", format!("{object}, triangle {triangle}"));
                lines.value("material", material);
                lines.value("position", point(*position));
                lines.value("normal", point(*normal));
                if normal.distance(*shading_normal) > 1e-4 {
                    lines.value("shading", point(*shading_normal));
                }
                lines.value("distance", rounded(*distance));
            }
        }
        match &pick.history {
            Err(problem) => lines.heading(format!("No light paths: {problem}")),
            Ok(history) if history.is_empty() => {}
            Ok(history) => {
                lines.heading(format!("Light paths of its last {} samples", history.len()));
                history.iter().rev().for_each(|sample| about_sample(sample, lines));
            }
        }
    }

    fn about_scene(&self) -> Vec<Line> {
        let mut lines = Lines::default();
        let picked = self.pick.as_ref().and_then(|pick| pick.surface.as_ref()).map(|surface| &surface.object);
        for line in &self.outline {
            let style = match line.depth {
                0 => Style::Heading,
                _ if line.object.is_some() && line.object.as_ref() == picked => Style::Chosen,
                1 => Style::Text,
                _ => Style::Faint,
            };
            lines.push(format!("{}{}", "  ".repeat(line.depth), line.text), style);
        }
        lines.0
    }
}

fn about_sample(SampleHistory { sample, radiance, paths }: &SampleHistory, lines: &mut Lines) {
    let total = luminance(*radiance);
    lines.push(format!("sample {sample}: {}", color(*radiance)), Style::Text);
    let mut bright: Vec<_> = paths.iter().filter(|path| luminance(path.light) >= LITTLE * total).collect();
    bright.sort_by(|a, b| luminance(b.light).total_cmp(&luminance(a.light)));
    for path in &bright {
        let events: Vec<String> = path.events.iter().map(Event::to_string).collect();
        lines.push(format!("  {}  {}", rounded(luminance(path.light)), events.join(" > ")), Style::Faint);
    }
    if bright.len() < paths.len() {
        let rest: f32 = paths.iter().map(|path| luminance(path.light)).sum::<f32>()
            - bright.iter().map(|path| luminance(path.light)).sum::<f32>();
        lines.push(
            format!("  {}  in {} darker paths", rounded(rest.max(0.0)), paths.len() - bright.len()),
            Style::Faint,
        );
    }
}

fn help() -> Vec<Line> {
    let mut lines = Lines::default();
    lines.heading("Keys and mouse");
    for (keys, what) in HELP {
        lines.push(format!("{keys:24}{what}"), Style::Text);
    }
    lines.0
}

/// A text in lines of at most so many characters, all but the first with an indentation.
fn wrap(text: &str, columns: usize) -> Vec<String> {
    const INDENT: &str = "      ";
    let mut lines = Vec::new();
    let mut rest: Vec<char> = text.chars().collect();
    while rest.len() > columns {
        let space = (columns / 2..=columns).rev().find(|&i| rest[i] == ' ');
        let tail = rest.split_off(space.unwrap_or(columns));
        lines.push(rest.iter().collect::<String>());
        let tail: String = tail.into_iter().collect();
        rest = INDENT.chars().chain(tail.trim_start().chars()).collect();
    }
    lines.push(rest.into_iter().collect());
    lines
}

fn luminance(light: Vec3) -> f32 {
    light.dot(LUMINANCE.as_vec3())
}

/// Four digits that matter.
fn rounded(value: f32) -> String {
    let size = value.abs();
    match size {
        0.0 => "0".to_owned(),
        _ if !(1e-3..1e5).contains(&size) => format!("{value:.3e}"),
        _ => {
            let decimals = (3 - size.log10().floor() as i32).max(0) as usize;
            format!("{value:.decimals$}")
        }
    }
}

fn point(point: Vec3) -> String {
    // What is next to nothing beside the others is 0.
    let least = 1e-6 * point.abs().max_element();
    point.to_array().map(|value| rounded(if value.abs() < least { 0.0 } else { value })).join("  ")
}

fn color(color: Vec3) -> String {
    color.to_array().map(rounded).join("  ")
}

fn count(rays: u64) -> String {
    match rays {
        0..10_000 => rays.to_string(),
        10_000..10_000_000 => format!("{:.1} thousand", rays as f64 / 1e3),
        _ => format!("{:.1} million", rays as f64 / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_wrapped_between_words() {
        assert_eq!(wrap("short", 20), ["short"]);
        let lines = wrap("RD back wall > RD tall block > O light", 20);
        assert_eq!(lines, ["RD back wall > RD", "      tall block > O", "      light"]);
        assert!(wrap(&"x".repeat(50), 20).iter().all(|line| line.chars().count() <= 20));
    }

    #[test]
    fn numbers_have_four_digits() {
        assert_eq!(
            [0.0, 1.0, -0.25, 123.456, 1e7, 1e-5].map(rounded),
            ["0", "1.000", "-0.2500", "123.5", "1.000e7", "1.000e-5"]
        );
        assert_eq!(point(Vec3::new(1.0, -1e-9, 0.5)), "1.000  0  0.5000");
        assert_eq!([9_999, 25_000, 25_000_000].map(count), ["9999", "25.0 thousand", "25.0 million"]);
    }
}
