//! The options of the irradiance cache.

use super::super::value;
use super::options::options;
use super::replace;
use crate::settings::{CachedOptions, GatherLayout, Gradients, Metric};

options! {
    /// Options that are set here; the others are `None` and leave the defaults.
    #[command(next_help_heading = "Irradiance cache")]
    pub struct CachedOverrides;
    options {
        /// Allowed error of records, more than 0 and at most 1; their radii are proportional to it [default: 0.3]
        #[arg(value_name = "A", allow_hyphen_values = true)]
        cache_error: f32 = value::cache_error, in "render";
        /// Gradients by which records are extrapolated: off, rotation or both (rotation and translation) [default:
        /// both]
        #[arg(value_name = "WHICH")]
        gradients: Gradients = value::gradients, in "render";
        /// Metric of the records' radii: split-sphere, bounded (split-sphere, bounded by the gradient) or hessian
        /// [default: hessian]
        #[arg(value_name = "NAME")]
        metric: Metric = value::metric, in "render";
        /// Sampling of a record's hemisphere: stratified or hemicube [default: stratified]
        #[arg(value_name = "NAME")]
        layout: GatherLayout = value::gather_layout, in "render";
        /// Approximate number of rays per record [default: 2048]
        #[arg(value_name = "N", allow_hyphen_values = true)]
        record_rays: u32 = value::record_rays, in "render";
        /// Number of reflections before a record, with one cache for each [default: unlimited, by path tracing]
        #[arg(value_name = "N", allow_hyphen_values = true)]
        cache_bounces: u32 = value::cache_bounces, in "render";
        /// Requested root mean square error of irradiance, relative to its mean: 1%, 0.03. It determines the rays and
        /// radii of records and, in bakes and sensors, the samples of direct light
        #[arg(value_name = "ERROR", allow_hyphen_values = true)]
        #[arg(conflicts_with_all = ["cache_error", "record_rays"])]
        accuracy: f32 = value::accuracy, in "render";
    }
    others {}
}

impl CachedOverrides {
    /// These options, and those of `fallback` where these are not set.
    pub(super) fn or(self, mut fallback: Self) -> Self {
        // Who says how records are to be made does not ask for an accuracy.
        if self.cache_error.is_some() || self.record_rays.is_some() {
            fallback.accuracy = None;
        }
        self.or_each(fallback)
    }

    /// The defaults with these options in their places.
    pub fn options(&self) -> CachedOptions {
        let mut options = CachedOptions::default();
        replace(&mut options.error, self.cache_error);
        replace(&mut options.gradients, self.gradients);
        replace(&mut options.metric, self.metric);
        replace(&mut options.layout, self.layout);
        replace(&mut options.rays, self.record_rays);
        options.bounces = self.cache_bounces;
        options.accuracy = self.accuracy;
        options
    }
}
