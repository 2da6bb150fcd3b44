//! The commands, and what they change.

use super::Session;
use crate::output::ToneCurve;
use crate::scene::CameraPose;
use crate::view::orbit;

/// The greatest magnitude of an exposure, in stops, as on the command line.
const MAX_EXPOSURE: f32 = 64.0;
/// The samples that a pixel may be asked to have.
const MAX_SAMPLES: u32 = 1 << 24;

/// The commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Go around the target: to the right and up, radians.
    Orbit(f64, f64),
    /// Move across the view: to the right and up, in lengths of the distance to the target.
    Pan(f64, f64),
    /// Go to this part of the distance to the target.
    Zoom(f64),
    /// Back to the first camera.
    Home,
    /// Look at the surface that was picked, and go around it.
    LookAtPicked,
    /// Show what a pixel is, by its column and row.
    Pick(u32, u32),
    /// Show the layer this many places further.
    Layer(isize),
    /// Make the picture brighter by this many stops.
    Expose(f32),
    /// The exposure and tone curve that it began with.
    ResetTone,
    /// The next tone curve.
    NextCurve,
    /// Twice as many samples.
    MoreSamples,
    /// Show this beside the picture, or what is shown at first if it is shown already.
    Show(Page),
    /// Scroll the text by this many lines.
    Scroll(isize),
    /// Save the camera.
    Save,
}

/// The text beside the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Page {
    /// The picture, the camera, and what was picked.
    #[default]
    Picture,
    /// The scene's tree.
    Scene,
    /// Keys and mouse.
    Help,
}

impl Session {
    /// Does what a command says.
    pub fn apply(&mut self, command: Command) {
        self.message = None;
        let diagonal = (self.bounds.1 - self.bounds.0).length();
        match command {
            Command::Orbit(azimuth, elevation) => self.move_to(orbit::orbit(self.aimed(), azimuth, elevation)),
            Command::Pan(right, up) => self.move_to(orbit::pan(self.aimed(), right, up)),
            Command::Zoom(factor) => self.move_to(orbit::zoom(self.aimed(), factor, diagonal)),
            Command::Home => self.move_to(self.home),
            Command::LookAtPicked => match self.pick.as_ref().and_then(|pick| pick.surface.as_ref()) {
                Some(surface) => self.move_to(orbit::look_at(self.pose, surface.position)),
                None => self.say("nothing is picked: click on a surface first"),
            },
            Command::Pick(x, y) => {
                let (x, y) = (x.min(self.settings.width - 1), y.min(self.settings.height - 1));
                if self.page != Page::Picture {
                    (self.page, self.scroll) = (Page::Picture, 0);
                }
                match &self.frame {
                    Some(frame) if frame.order == self.order => self.pick_at((x, y)),
                    _ => self.awaited_pick = Some((x, y)),
                }
            }
            Command::Layer(places) => {
                let count = self.layers.len() as isize;
                self.layer = (self.layer as isize + places).rem_euclid(count) as usize;
                self.show_layer();
            }
            Command::Expose(stops) => {
                self.tone.exposure = (self.tone.exposure + stops).clamp(-MAX_EXPOSURE, MAX_EXPOSURE);
            }
            Command::ResetTone => self.tone = self.first_tone,
            Command::NextCurve => {
                let names = ToneCurve::NAMES;
                let place = names.iter().position(|name| *name == self.tone.curve.name()).unwrap_or(0);
                self.tone.curve = ToneCurve::from_name(names[(place + 1) % names.len()]).unwrap_or_default();
            }
            Command::MoreSamples => {
                self.settings.spp = self.settings.spp.saturating_mul(2).min(MAX_SAMPLES).max(self.settings.spp);
                self.render();
            }
            Command::Show(page) => {
                self.page = if self.page == page { Page::Picture } else { page };
                self.scroll = 0;
            }
            Command::Scroll(lines) => self.scroll = self.scroll.saturating_add_signed(lines),
            Command::Save => self.save(),
        }
    }

    /// Shows a layer by its name, if there is one.
    pub fn show(&mut self, name: &str) -> bool {
        let place = self.layers.iter().position(|layer| layer.name == name);
        if let Some(place) = place {
            self.layer = place;
            self.show_layer();
        }
        place.is_some()
    }

    fn show_layer(&mut self) {
        if self.layer().needs_aov && !self.settings.aov {
            // As `--aov` does. The picture is begun again, which comes out the same.
            (self.settings.aov, self.settings.halves) = (true, true);
            self.render();
        } else {
            self.renderer.show(&self.layers[self.layer].channels);
        }
        self.frame = None;
    }

    /// The pose with a target to go around: that of the first camera may be anywhere along its view.
    fn aimed(&self) -> CameraPose {
        if self.pose == self.home { orbit::aim(self.pose, self.bounds) } else { self.pose }
    }

    fn move_to(&mut self, pose: CameraPose) {
        if !self.is_movable {
            return self.say("the rays of this camera come from a file: it cannot be moved");
        }
        let is_whole = [pose.eye, pose.target].iter().all(|point| point.is_finite());
        if is_whole && pose != self.pose && pose.eye != pose.target {
            self.pose = pose;
            self.pick = None;
            self.render();
        }
    }

    fn save(&mut self) {
        self.message = Some(if !self.is_movable {
            "this camera's rays are in a file already".to_owned()
        } else {
            match self.camera_file.save(&self.pose) {
                Ok(path) => format!("saved the camera in {}", path.display()),
                Err(error) => {
                    format!("not saved: {}; the camera is {}", error.replace('\n', " "), self.camera_options())
                }
            }
        });
    }

    fn say(&mut self, text: &str) {
        self.message = Some(text.to_owned());
    }
}
