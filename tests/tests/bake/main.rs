//! `halfdome bake`, from model to model.

mod check;
mod command;
mod level;
