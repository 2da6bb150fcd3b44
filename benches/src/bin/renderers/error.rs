//! How far a picture is from the reference.

/// Keeps dark pixels from deciding the relative error (Rousselle, Knaus and Zwicker 2011).
const DARK: f64 = 0.01;

/// A picture of many samples, as the mean of two independent halves; their difference tells its own error.
pub(crate) struct Reference {
    pixels: Vec<f64>,
    /// Root of its mean squared error, as the halves tell it.
    pub(crate) rmse: f64,
}

impl Reference {
    pub(crate) fn new(first: &[f32], second: &[f32]) -> Self {
        let halves = || first.iter().zip(second).map(|(&a, &b)| (f64::from(a), f64::from(b)));
        let pixels = halves().map(|(a, b)| 0.5 * (a + b)).collect();
        // The mean's variance is a quarter of the variance of the difference.
        let rmse = mean(halves().map(|(a, b)| 0.25 * (a - b).powi(2))).sqrt();
        Self { pixels, rmse }
    }

    /// The mean of all values.
    pub(crate) fn mean(&self) -> f64 {
        mean(self.pixels.iter().copied())
    }

    /// The mean squared error of a picture, over all pixels and channels.
    pub(crate) fn mse(&self, picture: &[f32]) -> f64 {
        mean(self.pairs(picture).map(|(value, exact)| (value - exact).powi(2)))
    }

    /// The mean of the squared relative errors, `(value - exact)² / (exact² + 0.01)`.
    pub(crate) fn relative_mse(&self, picture: &[f32]) -> f64 {
        mean(self.pairs(picture).map(|(value, exact)| (value - exact).powi(2) / (exact * exact + DARK)))
    }

    /// How much brighter a picture is than the reference on the whole, as a part of the reference's mean.
    pub(crate) fn brighter(&self, picture: &[f32]) -> f64 {
        mean(picture.iter().map(|&value| f64::from(value))) / self.mean() - 1.0
    }

    fn pairs(&self, picture: &[f32]) -> impl Iterator<Item = (f64, f64)> {
        picture.iter().map(|&value| f64::from(value)).zip(self.pixels.iter().copied())
    }
}

/// NaN of nothing.
pub(crate) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_held_against_the_mean_of_the_halves() {
        let reference = Reference::new(&[1.0, 0.0, 4.0, 0.5], &[3.0, 0.0, 4.0, 0.5]);
        assert_eq!(reference.pixels, [2.0, 0.0, 4.0, 0.5]);
        // One of four values is off by 1 in each half.
        assert_eq!(reference.rmse, 0.5);
        assert_eq!(reference.mean(), 1.625);
        let picture = [2.0, 1.0, 1.0, 0.5];
        assert_eq!(reference.mse(&picture), (1.0 + 9.0) / 4.0);
        assert_eq!(reference.relative_mse(&picture), (1.0 / 0.01 + 9.0 / 16.01) / 4.0);
        assert_eq!(reference.brighter(&picture), 4.5 / 6.5 - 1.0);
        assert_eq!(reference.brighter(&[2.0, 0.0, 4.0, 0.5]), 0.0);
    }
}
