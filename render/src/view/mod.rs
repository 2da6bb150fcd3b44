//! The viewer of `halfdome view`, without its window.
//!
//! A [`Session`] has a scene, a camera and the state of the display. [`Command`]s change these; pictures grow from
//! coarse to fine on other threads (`renderer.rs`), and are those of [`driver::render`](crate::driver::render()). A
//! window draws [`Session::codes`] and [`Session::text`], here done by `screen.rs`, and turns keys into commands
//! ([`command`]).

mod keys;
mod layer;
mod orbit;
mod outline;
mod panel;
mod pick;
mod renderer;
mod save;
#[cfg(feature = "view")]
mod screen;
mod session;
#[cfg(test)]
mod tests;

pub use keys::{HELP, ZOOM_STEP, command};
pub use layer::Layer;
pub use orbit::{aim, look_at, orbit, pan, zoom};
pub use outline::{OutlineLine, outline};
pub use panel::{COLUMNS, Line, Style};
pub use pick::{Pick, PickedSurface};
pub use renderer::{COARSEST, Frame};
pub use save::{CameraFile, optics_keys};
#[cfg(feature = "view")]
pub use screen::{Screen, panel_width};
pub use session::{Command, Page, Session, Start};
