//! What a point of a surface receives, estimated. Knows no cache and no path.

mod direct;
mod gather;
mod hemisphere;
mod horizon;
mod incident;
mod prospect;
mod weight;

pub(crate) use direct::{
    Connection, connect, connect_lamp, connect_to, emitted_density, scattered_weight, shine, sky_density,
};
pub(crate) use gather::{Follow, GATHER_FIRST_SET, GatherPoint, Gathered, Gatherer};
pub(crate) use hemisphere::Hemisphere;
pub use horizon::SECTORS;
pub(crate) use horizon::sector;
pub(crate) use incident::{Incident, Receive};
pub(crate) use prospect::prospect;
