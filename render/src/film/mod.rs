//! The film: samples of pixel filters, and the picture that samples add up to.

mod filter_sampler;
mod picture;
mod tile;

pub use filter_sampler::{FilterSample, FilterSampler};
pub use picture::{Channel, Metadata, Picture};
pub(crate) use tile::{Features, TILE_SIDE, Tile, channels, tiles};
