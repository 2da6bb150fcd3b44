//! A figure as SVG (Scalable Vector Graphics 1.1), readable on its own and without a script or a web font.

use std::fmt::Write as _;

use super::{Figure, Point, Series, Style};

const WIDTH: f64 = 680.0;
const HEIGHT: f64 = 440.0;
/// The area inside the axes: left, top, right, bottom.
const FRAME: [f64; 4] = [74.0, 44.0, 664.0, 386.0];
/// Colours that people with any colour vision tell apart (Okabe and Ito, "Color Universal Design", 2008).
const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];
const LINE: f64 = 19.0;

/// The figure's file.
pub(crate) fn svg(figure: &Figure) -> String {
    let [left, top, right, bottom] = FRAME;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
         width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"Helvetica, Arial, 'Liberation Sans', sans-serif\" font-size=\"13\" fill=\"#222\">\n\
         <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"white\"/>\n"
    );
    text(
        &mut out,
        [(left + right) / 2.0, 26.0],
        "text-anchor=\"middle\" font-size=\"15\" font-weight=\"bold\"",
        &figure.title,
    );
    axes(&mut out, figure);
    let colours = colours(&figure.series);
    for (series, &colour) in figure.series.iter().zip(&colours) {
        match series.style {
            Style::Dashed => curve(&mut out, figure, series, COLOURS[colour]),
            Style::Marks => marks(&mut out, figure, series, colour),
        }
    }
    legend(&mut out, figure, &colours);
    let _ = writeln!(
        out,
        "<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#222\"/>\n</svg>",
        right - left,
        bottom - top
    );
    out
}

/// The index of each series' colour.
fn colours(series: &[Series]) -> Vec<usize> {
    let mut colour = 0;
    let mut colours = vec![0];
    for pair in series.windows(2) {
        colour += usize::from(pair[0].label != pair[1].label);
        colours.push(colour % COLOURS.len());
    }
    colours
}

fn text(out: &mut String, [x, y]: [f64; 2], style: &str, content: &str) {
    let content = content.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let _ = writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" {style}>{content}</text>");
}

fn line(out: &mut String, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], stroke: &str) {
    let _ = writeln!(out, "<path d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\" stroke=\"{stroke}\"/>");
}

/// Ticks, a grid at those with labels, and what the axes mean.
fn axes(out: &mut String, figure: &Figure) {
    let [left, top, right, bottom] = FRAME;
    for tick in figure.x.ticks() {
        let x = left + (right - left) * figure.x.clamped(tick.value);
        let length = if tick.label.is_empty() { 3.0 } else { 6.0 };
        if !tick.label.is_empty() {
            line(out, [x, top], [x, bottom], "#e4e4e4");
        }
        line(out, [x, bottom], [x, bottom - length], "#222");
        text(out, [x, bottom + 18.0], "text-anchor=\"middle\"", &tick.label);
    }
    for tick in figure.y.ticks() {
        let y = bottom - (bottom - top) * figure.y.clamped(tick.value);
        let length = if tick.label.is_empty() { 3.0 } else { 6.0 };
        if !tick.label.is_empty() {
            line(out, [left, y], [right, y], "#e4e4e4");
        }
        line(out, [left, y], [left + length, y], "#222");
        text(out, [left - 8.0, y + 4.5], "text-anchor=\"end\"", &tick.label);
    }
    text(out, [(left + right) / 2.0, bottom + 42.0], "text-anchor=\"middle\"", figure.x.label());
    let (x, y) = (20.0, (top + bottom) / 2.0);
    text(out, [x, y], &format!("text-anchor=\"middle\" transform=\"rotate(-90 {x} {y})\""), figure.y.label());
}

/// Where a point lies in the picture, if it is within both axes.
fn place(figure: &Figure, point: &Point) -> Option<[f64; 2]> {
    let [left, top, right, bottom] = FRAME;
    let (x, y) = (figure.x.place(point.x)?, figure.y.place(point.y)?);
    Some([left + (right - left) * x, bottom - (bottom - top) * y])
}

/// A dashed line through the points within the axes.
fn curve(out: &mut String, figure: &Figure, series: &Series, colour: &str) {
    let mut path = String::new();
    let mut drawing = false;
    for point in &series.points {
        let Some([x, y]) = place(figure, point) else {
            drawing = false;
            continue;
        };
        let _ = write!(path, "{}{x:.1} {y:.1}", if drawing { 'L' } else { 'M' });
        drawing = true;
    }
    let _ = writeln!(
        out,
        "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.4\" stroke-dasharray=\"6 4\"/>"
    );
}

/// A mark for every point, and its standard error as a bar.
fn marks(out: &mut String, figure: &Figure, series: &Series, colour: usize) {
    let [_, top, _, bottom] = FRAME;
    for point in &series.points {
        let Some([x, y]) = place(figure, point) else { continue };
        if point.error > 0.0 {
            let [low, high] =
                [-1.0, 1.0].map(|sign| bottom - (bottom - top) * figure.y.clamped(point.y + sign * point.error));
            let _ = writeln!(
                out,
                "<path d=\"M{x:.1} {low:.1}V{high:.1}M{0:.1} {low:.1}h6M{0:.1} {high:.1}h6\" \
                 stroke=\"{1}\" fill=\"none\"/>",
                x - 3.0,
                COLOURS[colour]
            );
        }
        mark(out, [x, y], colour);
    }
}

/// Each colour has a shape of its own: disc, square, diamond, triangle.
fn mark(out: &mut String, [x, y]: [f64; 2], colour: usize) {
    let shape = match colour % 4 {
        0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.6\""),
        1 => format!("<path d=\"M{:.1} {:.1}h6.4v6.4h-6.4z\"", x - 3.2, y - 3.2),
        2 => format!("<path d=\"M{x:.1} {:.1}l4.6 4.6l-4.6 4.6l-4.6-4.6z\"", y - 4.6),
        _ => format!("<path d=\"M{x:.1} {:.1}l4.4 7.6h-8.8z\"", y - 4.8),
    };
    let _ = writeln!(out, "{shape} fill=\"{}\" stroke=\"white\" stroke-width=\"0.8\"/>", COLOURS[colour]);
}

/// The names of the series, in the corner where they hide least.
fn legend(out: &mut String, figure: &Figure, colours: &[usize]) {
    let [left, top, right, bottom] = FRAME;
    let mut entries: Vec<(&str, usize, Vec<Style>)> = Vec::new();
    for (series, &colour) in figure.series.iter().zip(colours) {
        match entries.last_mut() {
            Some((label, _, styles)) if *label == series.label => styles.push(series.style),
            _ => entries.push((&series.label, colour, vec![series.style])),
        }
    }
    // Letters of Helvetica are half as wide as they are high, more or less.
    let letters = entries.iter().map(|(label, ..)| label.chars().count()).max().unwrap_or(0);
    let (width, height) = (54.0 + 7.1 * letters as f64, 10.0 + LINE * entries.len() as f64);
    let corners = [right - width - 10.0, left + 10.0]
        .into_iter()
        .flat_map(|x| [top + 10.0, bottom - height - 10.0].map(|y| [x, y]));
    let points = || figure.series.iter().flat_map(|series| &series.points).filter_map(|point| place(figure, point));
    let hidden = |[x, y]: &[f64; 2]| {
        points()
            .filter(|p| (x - 6.0..x + width + 6.0).contains(&p[0]) && (y - 6.0..y + height + 6.0).contains(&p[1]))
            .count()
    };
    let [x, y] = corners.min_by_key(hidden).unwrap_or([left, top]);
    let _ = writeln!(
        out,
        "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"white\" \
         fill-opacity=\"0.9\" stroke=\"#bbb\"/>"
    );
    for (row, (label, colour, styles)) in entries.iter().enumerate() {
        let y = y + 5.0 + LINE * (row as f64 + 0.5);
        if styles.contains(&Style::Dashed) {
            let _ = writeln!(
                out,
                "<path d=\"M{:.1} {y:.1}h30\" stroke=\"{}\" stroke-width=\"1.4\" stroke-dasharray=\"6 4\"/>",
                x + 7.0,
                COLOURS[*colour]
            );
        }
        if styles.contains(&Style::Marks) {
            mark(out, [x + 22.0, y], *colour);
        }
        text(out, [x + 44.0, y + 4.5], "", label);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::plot::{Axis, csv};

    fn figure() -> Figure {
        let point = |x, y, error| Point { x, y, error };
        Figure {
            name: "test",
            title: "a < b & c".to_owned(),
            x: Axis::linear("x", 0.0, 10.0),
            y: Axis::logarithmic("y (W)", 0.01, 100.0),
            series: vec![
                Series::exact("line", [0.0, 5.0, 10.0], |x| if x < 7.0 { 1.0 } else { f64::INFINITY }),
                Series::measured("line", vec![point(5.0, 1.0, 0.9), point(5.0, 0.0, 1.0), point(11.0, 1.0, 1.0)]),
                Series::measured("other", vec![point(10.0, 100.0, 0.0)]),
            ],
        }
    }

    #[test]
    fn points_lie_where_the_axes_say() {
        let svg = svg(&figure());
        let [left, top, right, bottom] = FRAME;
        let (x, y) = ((left + right) / 2.0, (top + bottom) / 2.0);
        // Half way on both axes; the point at 0 has no place on a logarithmic axis, that at 11 is beyond the other.
        assert_eq!(svg.matches("<circle").count(), 2, "the point and its mark in the legend: {svg}");
        assert!(svg.contains(&format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.6\" fill=\"{}\"", COLOURS[0])));
        // Its bar ends a decade below and at 1.9; a corner of the other mark is 3.2 from the corner of the frame.
        let high = bottom - (bottom - top) * (190f64.log10() / 4.0);
        assert!(svg.contains(&format!("M{x:.1} {:.1}V{high:.1}", bottom - (bottom - top) * 0.25)), "{svg}");
        assert!(svg.contains(&format!("M{:.1} {:.1}h6.4", right - 3.2, top - 3.2)));
        // The curve has no infinite part.
        assert!(svg.contains(&format!("<path d=\"M{left:.1} {y:.1}L{x:.1} {y:.1}\" fill=\"none\"")));
    }

    #[test]
    fn text_is_escaped_and_names_are_in_the_legend_once() {
        let svg = svg(&figure());
        assert!(svg.contains(">a &lt; b &amp; c</text>") && svg.contains(">y (W)</text>"));
        assert_eq!((svg.matches(">line<").count(), svg.matches(">other<").count()), (1, 1));
        assert_eq!(svg.matches("<text").count(), svg.matches("</text>").count());
    }

    #[test]
    fn points_are_written_in_full() {
        let expected = "series,x,y,standard_error\n\"line (curve)\",0,1,0\n\"line (curve)\",5,1,0\n\"line\",5,1,0.9\n\
                        \"line\",5,0,1\n\"line\",11,1,1\n\"other\",10,100,0\n";
        assert_eq!(csv(&figure()), expected);
    }

    #[test]
    fn figures_of_one_name_become_one() {
        let mut both = figure();
        let mut second = figure();
        second.series[2].label = "third".to_owned();
        both.extend(second);
        let labels: Vec<_> = both.series.iter().map(|series| (series.label.as_str(), series.style)).collect();
        let expected =
            [("line", Style::Dashed), ("line", Style::Marks), ("other", Style::Marks), ("third", Style::Marks)];
        assert_eq!(labels, expected);
    }
}
