//! Statistics: means, variances and power laws, each with its uncertainty.

/// Two or more independent values of one quantity, summed up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    /// How many values there are.
    pub count: f64,
    /// Their mean.
    pub mean: f64,
    /// The unbiased estimate of the variance of a single value.
    pub variance: f64,
    /// The standard error of `variance`, from the fourth moment: `√((m₄ - s⁴) / n)`.
    pub variance_error: f64,
}

/// A line through points on logarithmic axes, `y = coefficient · x^exponent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PowerLaw {
    /// The slope.
    pub exponent: f64,
    /// The value at `x = 1`.
    pub coefficient: f64,
    /// The slope's standard error, from the points' distance to the line.
    pub exponent_error: f64,
}

impl Sample {
    /// The summary of two or more values.
    pub(crate) fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let moment = |power| values.iter().map(|value| (value - mean).powi(power)).sum::<f64>();
        let variance = moment(2) / (count - 1.0);
        let variance_error = ((moment(4) / count - variance * variance).max(0.0) / count).sqrt();
        Self { count, mean, variance, variance_error }
    }

    /// The standard error of the mean.
    pub(crate) fn standard_error(&self) -> f64 {
        (self.variance / self.count).sqrt()
    }

    /// How far the mean is from `exact`, in standard errors. What the values have in common, such as 32-bit rounding or
    /// the facets of a sphere, is an uncertainty of `exact`: `allowance`, more than zero, relative to it.
    pub(crate) fn z(&self, exact: f64, allowance: f64) -> f64 {
        (self.mean - exact) / self.standard_error().hypot(allowance * exact)
    }
}

/// The root of the mean square distance of `values` from `exact`.
pub(crate) fn root_mean_square_error(values: &[f64], exact: f64) -> f64 {
    (values.iter().map(|value| (value - exact).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

impl PowerLaw {
    /// The least-squares line through the logarithms of three or more points `(x, y)`, all of them positive.
    pub(crate) fn fit(points: &[(f64, f64)]) -> Self {
        let count = points.len() as f64;
        let logarithms: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
        let mean = |of: fn(&(f64, f64)) -> f64| logarithms.iter().map(of).sum::<f64>() / count;
        let (x_mean, y_mean) = (mean(|p| p.0), mean(|p| p.1));
        let spread: f64 = logarithms.iter().map(|(x, _)| (x - x_mean).powi(2)).sum();
        let exponent = logarithms.iter().map(|(x, y)| (x - x_mean) * (y - y_mean)).sum::<f64>() / spread;
        let off = |(x, y): &(f64, f64)| (y - y_mean - exponent * (x - x_mean)).powi(2);
        let residual = logarithms.iter().map(off).sum::<f64>() / (count - 2.0);
        let coefficient = (y_mean - exponent * x_mean).exp();
        Self { exponent, coefficient, exponent_error: (residual / spread).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use halfdome_kernel::sampling::Stream;

    use super::*;

    #[test]
    fn four_values_by_hand() {
        // Mean 3; squares of the distances 4, 1, 0, 9; fourth powers 16, 1, 0, 81.
        let sample = Sample::of(&[1.0, 2.0, 3.0, 6.0]);
        assert_eq!((sample.count, sample.mean), (4.0, 3.0));
        assert!((sample.variance - 14.0 / 3.0).abs() < 1e-15);
        assert!((sample.standard_error() - (14.0f64 / 12.0).sqrt()).abs() < 1e-15);
        assert!((sample.variance_error - ((98.0 / 4.0 - 196.0 / 9.0) / 4.0f64).sqrt()).abs() < 1e-15);
        assert!((sample.z(3.5, 1e-9) + 0.5 / (14.0f64 / 12.0).sqrt()).abs() < 1e-9);
        assert_eq!(root_mean_square_error(&[1.0, 2.0, 3.0, 6.0], 2.0), 4.5f64.sqrt());
    }

    #[test]
    fn values_without_scatter_have_their_allowance() {
        let sample = Sample::of(&[2.0, 2.0, 2.0]);
        assert_eq!((sample.variance, sample.variance_error), (0.0, 0.0));
        assert_eq!(sample.z(2.0, 1e-6), 0.0);
        assert!((sample.z(2.0 + 6e-6, 1e-6) + 3.0).abs() < 1e-5);
    }

    /// Of uniform numbers the mean is 1/2, the variance 1/12, and the scatter of both over many samples is as stated.
    #[test]
    fn uncertainties_are_those_of_repeated_experiments() {
        let samples: Vec<Sample> = (0..400)
            .map(|i| {
                let values: Vec<f64> = (0..100).map(|j| f64::from(Stream::new(5, i, j).uniform2(0).x)).collect();
                Sample::of(&values)
            })
            .collect();
        let means = Sample::of(&samples.iter().map(|sample| sample.mean).collect::<Vec<_>>());
        assert!(means.z(0.5, 1e-9).abs() < 3.0 && (means.variance * 1200.0 - 1.0).abs() < 0.25, "{means:?}");
        let variances = Sample::of(&samples.iter().map(|sample| sample.variance).collect::<Vec<_>>());
        assert!(variances.z(1.0 / 12.0, 1e-9).abs() < 3.0, "{variances:?}");
        let stated = samples.iter().map(|sample| sample.variance_error).sum::<f64>() / 400.0;
        assert!((stated / variances.variance.sqrt() - 1.0).abs() < 0.15, "{stated}, {variances:?}");
    }

    #[test]
    fn power_laws_are_found() {
        let exact: Vec<(f64, f64)> = (0..6).map(|i| f64::from(1 << i)).map(|x| (x, 3.0 * x.powf(-0.75))).collect();
        let law = PowerLaw::fit(&exact);
        assert!((law.exponent + 0.75).abs() < 1e-12 && (law.coefficient - 3.0).abs() < 1e-12);
        assert!(law.exponent_error < 1e-12);
        // Of the points (0, 0), (1, 1), (2, 0) in logarithms the line is level, at a third.
        let law = PowerLaw::fit(&[(1.0, 1.0), (1f64.exp(), 1f64.exp()), (2f64.exp(), 1.0)]);
        assert!(law.exponent.abs() < 1e-15 && (law.coefficient.ln() - 1.0 / 3.0).abs() < 1e-15);
        assert!((law.exponent_error - (2.0 / 3.0 / 2.0f64).sqrt()).abs() < 1e-15);
    }
}
