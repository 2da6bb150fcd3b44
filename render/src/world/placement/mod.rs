//! Where things are: instances of objects, and what moves while the shutter is open.

pub(super) mod instances;
pub(super) mod motion;
mod moved;
