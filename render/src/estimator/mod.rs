//! What a point of a surface receives, estimated. Knows no cache and no path.

mod direct;
mod hemisphere;
mod weight;

pub(crate) use direct::{Connection, connect, emitted_density, sky_density};
pub(crate) use hemisphere::Hemisphere;
