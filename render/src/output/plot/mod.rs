//! Figures: measured points with error bars beside exact curves, as SVG and as CSV.

mod axis;
mod svg;

pub(crate) use axis::Axis;
pub(crate) use svg::svg;

/// A figure of points and curves over two axes.
#[derive(Clone, Debug)]
pub(crate) struct Figure {
    /// In kebab-case. Figures of one name are one figure, to which several experiments add their series.
    pub name: &'static str,
    /// The title, in a line.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Drawn in this order, in a colour each; a series called as the one before shares its colour and its line of the
    /// legend.
    pub series: Vec<Series>,
}

/// Points that belong together.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    /// Its name in the legend.
    pub label: String,
    /// The style.
    pub style: Style,
    /// The points from left to right.
    pub points: Vec<Point>,
}

/// The style of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Style {
    /// Marks with error bars.
    Marks,
    /// A dashed line, for what is exact.
    Dashed,
}

/// A value and its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// Where.
    pub x: f64,
    /// The value.
    pub y: f64,
    /// Its standard error, zero if it has none.
    pub error: f64,
}

impl Figure {
    /// Adds what another figure of the same name shows, but for curves that are there already.
    pub(crate) fn extend(&mut self, other: Self) {
        let known = |series: &Series| self.series.iter().any(|s| s.style == series.style && s.label == series.label);
        let new: Vec<_> = other.series.into_iter().filter(|series| !known(series)).collect();
        self.series.extend(new);
    }
}

impl Series {
    /// Measured points.
    pub(crate) fn measured(label: &str, points: Vec<Point>) -> Self {
        Self { label: label.to_owned(), style: Style::Marks, points }
    }

    /// The exact value at each of `x`; where there is none, the curve ends.
    pub(crate) fn exact(label: &str, x: impl IntoIterator<Item = f64>, y: impl Fn(f64) -> f64) -> Self {
        let points = x.into_iter().map(|x| Point { x, y: y(x), error: 0.0 });
        Self { label: label.to_owned(), style: Style::Dashed, points: points.filter(|p| p.y.is_finite()).collect() }
    }
}

/// `count` values from `from` to `to` at equal distances, for curves.
pub(crate) fn span(from: f64, to: f64, count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| from + (to - from) * f64::from(i) / f64::from(count - 1))
}

/// The figure's points as comma-separated values: `series,x,y,standard_error`.
pub(crate) fn csv(figure: &Figure) -> String {
    let mut text = "series,x,y,standard_error\n".to_owned();
    for series in &figure.series {
        let label = match series.style {
            Style::Marks => series.label.clone(),
            Style::Dashed => format!("{} (curve)", series.label),
        };
        for Point { x, y, error } in &series.points {
            text += &format!("\"{label}\",{x},{y},{error}\n");
        }
    }
    text
}
