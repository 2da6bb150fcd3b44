//! Scene files (TOML), and the options that they share with the command line.

mod aov_table;
pub(super) mod file;
pub(super) mod light_table;
pub(super) mod material_table;
mod material_text;
mod moving;
pub(super) mod objects;
pub(super) mod overrides;
mod table_reader;
mod toml_text;
pub(crate) mod value;
