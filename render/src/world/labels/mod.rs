//! What surfaces and lights are called, and the colours that tell them apart in pictures.

mod light_colors;
mod names;
