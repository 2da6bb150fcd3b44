//! What a point of a surface receives, estimated. Knows no cache and no path.

mod direct;
mod gather;
mod horizon;

pub(crate) use direct::{emitted_density, sample_light};
pub(crate) use gather::{Follow, GATHER_FIRST_SET, GatherPoint, Gathered, Gatherer};
pub use horizon::SECTORS;
pub(crate) use horizon::sector;
