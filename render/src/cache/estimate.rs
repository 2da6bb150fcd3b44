//! The estimated error of a cache, and the warning where it is more than requested.

/// The estimated error of a cache that was filled to an accuracy, by independent gathers at some of its points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorEstimate {
    /// The mean irradiance of the points that it was filled for, direct light included, in W/m², over all channels.
    pub light: f32,
    /// The root mean square error of its irradiance, relative to that.
    pub root_mean_square: f32,
}

impl ErrorEstimate {
    /// The root mean square error, relative to the mean, of this and of sampled light with a mean variance, in W²/m⁴.
    pub(crate) fn with(&self, variance: f64) -> f32 {
        let relative = if self.light > 0.0 { variance / f64::from(self.light).powi(2) } else { 0.0 };
        (f64::from(self.root_mean_square).powi(2) + relative).sqrt() as f32
    }
}

/// What makes a cache more accurate than [`missed_accuracy`] says ...
pub(crate) const MORE_RECORDS: &str =
    "--cache-error and --record-rays in place of --accuracy give more and smaller records";
/// ... and paths at each point.
pub(crate) const MORE_PATHS: &str = "--brute --spp N in place of --accuracy traces more paths";

/// The warning where the estimate exceeds the requested error; both are relative to the mean. An error that rounds to
/// the same number counts as reached.
pub(crate) fn missed_accuracy(asked: f32, estimated: f32, remedy: &str) -> Option<String> {
    let hundredths = |part: f32| (1e4 * part).round();
    (hundredths(estimated) > hundredths(asked)).then(|| {
        format!(
            "the requested accuracy is not reached: the estimated error is {:.2}% of the mean light, and {}% was \
             requested; {remedy}",
            100.0 * estimated,
            hundredths(asked) / 100.0
        )
    })
}
