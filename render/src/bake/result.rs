//! What a bake gives: maps with their layers, and what it took.

use glam::{Vec2, Vec3};

use super::finish::dilate::TexelSource;
use super::finish::errors::ErrorSummary;
use super::layout::atlas::Atlas;

/// Light for every page of an atlas.
#[derive(Clone, Debug)]
pub struct Bake {
    /// The contents of the pages.
    pub atlas: Atlas,
    /// A map for each page.
    pub maps: Vec<Map>,
    /// Where the cache's records are: the page, and the place there from 0 to 1.
    pub record_places: Vec<(usize, Vec2)>,
    /// The cost.
    pub statistics: Statistics,
    /// Warnings about the light, a line each.
    pub warnings: Vec<String>,
    /// An estimate of the root mean square error of texels, relative to their mean, if an accuracy was requested.
    pub accuracy: Option<f32>,
}

/// The map of a page.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Irradiance and the requested moments.
    pub layers: Vec<Layer>,
    /// The chart of each texel, [`NO_CHART`](super::atlas::NO_CHART) outside of all; gutters belong to their chart.
    pub owners: Vec<u32>,
    /// The source of each texel's value.
    pub sources: Vec<TexelSource>,
    /// An estimate of the error of irradiance at each texel with light of its own, 0 for others, relative to its
    /// irradiance or to a tenth of the mean of all, whichever is more. It knows noise, and how far the cache's records
    /// disagree, but no bias.
    pub errors: Vec<f32>,
}

/// A value for each texel, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Empty for irradiance; `hl2.0` to `hl2.2` or `sh.0`, `sh.1-1`, `sh.10` and `sh.11` for what is kept of
    /// directions.
    pub name: &'static str,
    /// In linear sRGB; of ambient occlusion, how open it is in all channels.
    pub texels: Vec<Vec3>,
}

/// The cost of a bake.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Texels on surfaces.
    pub texels: u64,
    /// Hemispheres gathered: by texels, or by records and by texels without any.
    pub gathers: u64,
    /// Rays traced; of a bake that was resumed, since then.
    pub rays: u64,
    /// Texels that something covers, with a free point beside.
    pub moved: u64,
    /// Texels that something covers as a whole: they took the light of others.
    pub covered: u64,
    /// Texels of gutters.
    pub gutter: u64,
    /// Points along seams where samples were made to agree.
    pub seams: u64,
    /// Points along seams where they were not, as charts are too close.
    pub mixed: u64,
    /// Texels without a valid record.
    pub misses: u64,
    /// Records whose extrapolation had a negative channel, which counted as 0.
    pub negative: u64,
}

impl Bake {
    /// The relative errors that are estimated for texels with light of their own.
    pub fn error(&self) -> ErrorSummary {
        let texels = self.maps.iter().flat_map(|map| map.errors.iter().zip(&map.sources));
        let own = texels.filter(|(_, source)| **source == TexelSource::Light).map(|(error, _)| *error);
        ErrorSummary::of(own.collect())
    }
}
