//! Axes: ranges, ticks and where a value lies between them.

/// A labelled axis from one value to another.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    label: String,
    logarithmic: bool,
    from: f64,
    to: f64,
}

/// A mark on an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub value: f64,
    /// Empty for the ticks between.
    pub label: String,
}

impl Axis {
    /// An even axis.
    pub(crate) fn linear(label: &str, from: f64, to: f64) -> Self {
        Self { label: label.to_owned(), logarithmic: false, from, to }
    }

    /// A logarithmic axis between positive values.
    pub(crate) fn logarithmic(label: &str, from: f64, to: f64) -> Self {
        Self { label: label.to_owned(), logarithmic: true, from, to }
    }

    /// The quantity, with its unit.
    pub(super) fn label(&self) -> &str {
        &self.label
    }

    /// Where `value` lies: 0 at the lower end, 1 at the upper, `None` if it is beyond them.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        let place = self.unbounded(value);
        // A value at the very end may be rounded out.
        (-1e-9..=1.0 + 1e-9).contains(&place).then_some(place)
    }

    /// Like [`place`](Self::place), but what is beyond an end is put there.
    pub(super) fn clamped(&self, value: f64) -> f64 {
        let place = self.unbounded(value);
        if place.is_nan() { 0.0 } else { place.clamp(0.0, 1.0) }
    }

    fn unbounded(&self, value: f64) -> f64 {
        if self.logarithmic {
            (value.max(0.0) / self.from).ln() / (self.to / self.from).ln()
        } else {
            (value - self.from) / (self.to - self.from)
        }
    }

    /// The ticks, some of them with labels.
    pub(super) fn ticks(&self) -> Vec<Tick> {
        if self.logarithmic { self.decades() } else { self.steps() }
    }

    /// Steps of 1, 2 or 5 times a power of ten, four to nine of them.
    fn steps(&self) -> Vec<Tick> {
        let rough = (self.to - self.from) / 9.0;
        let power = 10f64.powf(rough.log10().floor());
        let step = power * [1.0, 2.0, 5.0, 10.0].into_iter().find(|&m| m * power >= 0.999_999 * rough).unwrap_or(10.0);
        let digits = (-step.log10().floor()).max(0.0) as usize;
        let (first, last) = ((self.from / step - 1e-6).ceil() as i64, (self.to / step + 1e-6).floor() as i64);
        let tick = |i: i64| Tick { value: i as f64 * step, label: format!("{:.digits$}", i as f64 * step) };
        (first..=last).map(tick).collect()
    }

    /// Powers of ten with labels, at most eight of these, and up to five decades their multiples without.
    fn decades(&self) -> Vec<Tick> {
        let (first, last) = (self.from.log10().floor() as i32, self.to.log10().ceil() as i32);
        let every = ((last - first) / 8 + 1).max(1);
        let mut ticks = Vec::new();
        for exponent in first..=last {
            for multiple in 1..10 {
                let value = f64::from(multiple) * 10f64.powi(exponent);
                let label = match multiple {
                    1 if exponent % every == 0 => power_of_ten(exponent),
                    2 | 5 if last - first <= 1 => format!("{value}"),
                    _ => String::new(),
                };
                let shown = multiple == 1 || last - first <= 7;
                if shown && self.place(value).is_some() {
                    ticks.push(Tick { value, label });
                }
            }
        }
        ticks
    }
}

/// 0.001 to 1000 in full, others as a power.
fn power_of_ten(exponent: i32) -> String {
    if (-3..=3).contains(&exponent) {
        return format!("{}", 10f64.powi(exponent));
    }
    let superscript = |digit| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + (digit as u32 - '0' as u32)).unwrap_or('?'),
    };
    format!("10{}", exponent.to_string().chars().map(superscript).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|tick| tick.label).filter(|label| !label.is_empty()).collect()
    }

    #[test]
    fn even_axes_have_round_ticks() {
        assert_eq!(labels(&Axis::linear("", 0.0, 16.0)), ["0", "2", "4", "6", "8", "10", "12", "14", "16"]);
        assert_eq!(
            labels(&Axis::linear("", -0.1, 0.31)),
            ["-0.10", "-0.05", "0.00", "0.05", "0.10", "0.15", "0.20", "0.25", "0.30"]
        );
        assert_eq!(labels(&Axis::linear("", 0.0, 1.0)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
    }

    #[test]
    fn logarithmic_axes_have_powers_of_ten() {
        let axis = Axis::logarithmic("", 1e-4, 10.0);
        assert_eq!(labels(&axis), ["10⁻⁴", "0.001", "0.01", "0.1", "1", "10"]);
        assert_eq!(axis.ticks().len(), 5 * 9 + 1);
        assert_eq!(labels(&Axis::logarithmic("", 1e-12, 1e12)).len(), 7);
        assert_eq!(power_of_ten(-13), "10⁻¹³");
        assert_eq!(labels(&Axis::logarithmic("", 1.0, 10.0)), ["1", "2", "5", "10"]);
    }

    #[test]
    fn places_are_shares_of_the_axis() {
        let even = Axis::linear("", 2.0, 6.0);
        assert_eq!((even.place(3.0), even.place(7.0), even.clamped(7.0)), (Some(0.25), None, 1.0));
        let logarithmic = Axis::logarithmic("", 0.01, 100.0);
        assert!((logarithmic.place(1.0).unwrap() - 0.5).abs() < 1e-12);
        assert_eq!((logarithmic.place(0.0), logarithmic.clamped(0.0), logarithmic.clamped(-1.0)), (None, 0.0, 0.0));
    }
}
