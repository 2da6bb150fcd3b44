//! halfdome: a renderer for people who light scenes, on top of [`halfdome_kernel`].
#![forbid(unsafe_code)]

pub mod cli;
pub mod driver;
pub mod film;
pub mod output;
pub mod scene;
mod seam;
pub mod settings;
