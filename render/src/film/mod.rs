//! The film: pixel filters, and the picture that samples add up to.

mod filter;
mod picture;

pub use filter::Filter;
pub use picture::{Channel, Metadata, Picture};
