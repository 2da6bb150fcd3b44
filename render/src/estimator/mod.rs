//! What a point of a surface receives, estimated. Knows no cache and no path.

mod direct;

pub(crate) use direct::{emitted_density, sample_light};
