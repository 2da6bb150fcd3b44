//! The error of a picture relative to the reference.

use halfdome_benches::measure::median;

/// Keeps dark pixels from deciding the relative error (Rousselle, Knaus and Zwicker 2011).
const DARK: f64 = 0.01;

/// A picture of many samples, as the mean of two independent halves; their difference gives its own error.
pub(crate) struct Reference {
    pixels: Vec<f64>,
    /// The root of its mean squared error, by the halves.
    pub(crate) rmse: f64,
    /// Its own part in [`trimmed_error`](Self::trimmed_error).
    pub(crate) own_trimmed_error: f64,
}

impl Reference {
    pub(crate) fn new(first: &[f32], second: &[f32]) -> Self {
        let halves = || first.iter().zip(second).map(|(&a, &b)| (f64::from(a), f64::from(b)));
        let pixels = halves().map(|(a, b)| 0.5 * (a + b)).collect();
        // The mean's variance is a quarter of the variance of the difference.
        let rmse = mean(halves().map(|(a, b)| 0.25 * (a - b).powi(2))).sqrt();
        let mut reference = Self { pixels, rmse, own_trimmed_error: 0.0 };
        let variances = halves().map(|(a, b)| 0.25 * (a - b).powi(2));
        reference.own_trimmed_error = reference.trimmed(variances);
        reference
    }

    /// The picture itself.
    pub(crate) fn pixels(&self) -> Vec<f32> {
        self.pixels.iter().map(|&value| value as f32).collect()
    }

    /// The middle of all values.
    pub(crate) fn median(&self) -> f64 {
        median(self.pixels.clone())
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

    /// The mean of the squared relative errors without the worst thousandth, less the reference's own.
    pub(crate) fn trimmed_error(&self, picture: &[f32]) -> f64 {
        self.trimmed(self.pairs(picture).map(|(value, exact)| (value - exact).powi(2))) - self.own_trimmed_error
    }

    /// The same of the variance among pictures of different seeds: their error, were their mean exact. NaN for one.
    pub(crate) fn noise(&self, pictures: &[Vec<f32>]) -> f64 {
        let count = pictures.len() as f64;
        self.trimmed((0..self.pixels.len()).map(|number| {
            let values = || pictures.iter().map(|picture| f64::from(picture[number]));
            let middle = mean(values());
            values().map(|value| (value - middle).powi(2)).sum::<f64>() / (count - 1.0)
        }))
    }

    /// The mean of `squares` relative to the pixels, without the worst thousandth.
    fn trimmed(&self, squares: impl Iterator<Item = f64>) -> f64 {
        let mut relative: Vec<f64> =
            squares.zip(&self.pixels).map(|(square, exact)| square / (exact * exact + DARK)).collect();
        relative.sort_unstable_by(f64::total_cmp);
        relative.truncate(relative.len() - relative.len() / 1000);
        mean(relative.into_iter())
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

    #[test]
    fn the_worst_thousandth_and_the_reference_s_own_error_do_not_count() {
        let reference = Reference::new(&[1.0; 2000], &[1.0; 2000]);
        let mut picture = [1.5; 2000];
        let near = |value: f64, exact: f64| (value - exact).abs() < 1e-12;
        assert!(near(reference.trimmed_error(&picture), 0.25 / 1.01));
        picture[7] = 1e6;
        picture[1999] = -1e6;
        assert!(near(reference.trimmed_error(&picture), 0.25 / 1.01));
        picture[8] = 1e6;
        assert!(reference.trimmed_error(&picture) > 1e6);
        // Halves that differ by 0.5 have a mean that is off by 0.25.
        let reference = Reference::new(&[0.75; 8], &[1.25; 8]);
        assert!(near(reference.own_trimmed_error, 0.0625 / 1.01));
        assert!(near(reference.trimmed_error(&[1.5; 8]), 0.1875 / 1.01));
    }

    #[test]
    fn noise_is_the_variance_among_pictures() {
        let reference = Reference::new(&[1.0, 1.0], &[1.0, 1.0]);
        // Both values have a variance of 1 about a mean that may well be wrong.
        let pictures = [vec![4.0, 9.0], vec![5.0, 8.0], vec![6.0, 7.0]];
        assert_eq!(reference.noise(&pictures), 1.0 / 1.01);
        assert!(reference.noise(&pictures[..1]).is_nan());
    }
}
