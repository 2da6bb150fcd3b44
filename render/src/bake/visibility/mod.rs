//! What sees light and what is seen: viewpoints inside of a level, surfaces that none of them sees, texels that lie in
//! bodies.

pub(super) mod covered;
mod inside;
mod outside;
