//! The film: pixel filters, and the picture that samples add up to.

mod filter;
mod filter_sampler;
mod picture;
mod tile;

pub use filter::{Filter, FilterError};
pub use filter_sampler::{FilterSample, FilterSampler};
pub use picture::{Channel, Metadata, Picture};
pub(crate) use tile::{Features, TILE_SIDE, Tile, channels, tiles};
