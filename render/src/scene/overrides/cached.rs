//! The options of the irradiance cache.

use clap::Args;

use super::super::value::{self, argument};
use super::replace;
use crate::settings::{CachedOptions, GatherLayout, Gradients, Metric};

/// Options that are set here; the others are `None` and leave the defaults.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Irradiance cache")]
pub struct CachedOverrides {
    /// Allowed error of records, more than 0 and at most 1; their reach is proportional to it [default: 0.3]
    #[arg(long, value_name = "A", value_parser = argument(value::cache_error), allow_negative_numbers = true)]
    pub cache_error: Option<f32>,
    /// Gradients by which records are extrapolated: off, rotation or both (rotation and translation) [default: both]
    #[arg(long, value_name = "WHICH", value_parser = argument(value::gradients))]
    pub gradients: Option<Gradients>,
    /// What limits the reach of records: split-sphere, bounded (split-sphere, bounded by the gradient) or hessian
    /// [default: hessian]
    #[arg(long, value_name = "NAME", value_parser = argument(value::metric))]
    pub metric: Option<Metric>,
    /// Sampling of a record's hemisphere: stratified or hemicube [default: stratified]
    #[arg(long, value_name = "NAME", value_parser = argument(value::gather_layout))]
    pub layout: Option<GatherLayout>,
    /// Approximate number of rays per record [default: 2048]
    #[arg(long, value_name = "N", value_parser = argument(value::record_rays), allow_negative_numbers = true)]
    pub record_rays: Option<u32>,
    /// Reflections of light on its way to a record, with one cache for each [default: unlimited, by path tracing]
    #[arg(long, value_name = "N", value_parser = argument(value::cache_bounces), allow_negative_numbers = true)]
    pub cache_bounces: Option<u32>,
    /// Root mean square error of irradiance that is asked for, as a part of its mean: 1%, 0.03. Rays of records, their reach
    /// and, where direct light is sampled besides, its samples follow from it
    #[arg(long, value_name = "ERROR", value_parser = argument(value::accuracy), allow_negative_numbers = true)]
    #[arg(conflicts_with_all = ["cache_error", "record_rays"])]
    pub accuracy: Option<f32>,
}

impl CachedOverrides {
    /// The names of all of them.
    pub(crate) const NAMES: [&str; 7] =
        ["cache_error", "gradients", "metric", "layout", "record_rays", "cache_bounces", "accuracy"];

    /// These options, and those of `fallback` where these are not set.
    pub(super) fn or(self, fallback: Self) -> Self {
        // Who says how records are to be made does not ask for an accuracy.
        let is_by_hand = self.cache_error.is_some() || self.record_rays.is_some();
        Self {
            accuracy: self.accuracy.or(fallback.accuracy.filter(|_| !is_by_hand)),
            cache_error: self.cache_error.or(fallback.cache_error),
            gradients: self.gradients.or(fallback.gradients),
            metric: self.metric.or(fallback.metric),
            layout: self.layout.or(fallback.layout),
            record_rays: self.record_rays.or(fallback.record_rays),
            cache_bounces: self.cache_bounces.or(fallback.cache_bounces),
        }
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

    /// Whether each of the options is set.
    pub(super) fn given(&self) -> [(&'static str, bool); 7] {
        let given = [
            self.cache_error.is_some(),
            self.gradients.is_some(),
            self.metric.is_some(),
            self.layout.is_some(),
            self.record_rays.is_some(),
            self.cache_bounces.is_some(),
            self.accuracy.is_some(),
        ];
        std::array::from_fn(|i| (Self::NAMES[i], given[i]))
    }
}
