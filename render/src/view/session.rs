//! The state of the viewer, changed by commands. It is independent of any window: callers send it commands and take the
//! picture and the text from it.

use glam::Vec3;

use super::orbit;
use super::outline::OutlineLine;
use super::pick::Pick;
use super::renderer::{Frame, Order, Renderer};
use super::save::{CameraFile, number};
use super::{Layer, outline};
use crate::output::{ToneCurve, ToneMapping};
use crate::scene::{CameraPose, Projection, Scene};
use crate::settings::{Integrator, Settings};
use crate::world::World;

/// The greatest magnitude of an exposure, in stops, as on the command line.
const MAX_EXPOSURE: f32 = 64.0;
/// The samples that a pixel may be asked to have.
const MAX_SAMPLES: u32 = 1 << 24;
/// Samples with which a pixel's paths are listed again as the picture grows.
const EARLY: u32 = 8;

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

/// A scene that is looked at.
pub struct Session {
    pub(super) name: String,
    renderer: Renderer,
    pub(super) settings: Settings,
    pub(super) pose: CameraPose,
    home: CameraPose,
    /// Whether the camera has a pose, and a field of view.
    is_movable: bool,
    is_perspective: bool,
    pub(super) bounds: (Vec3, Vec3),
    layers: Vec<Layer>,
    layer: usize,
    pub(super) tone: ToneMapping,
    first_tone: ToneMapping,
    pub(super) outline: Vec<OutlineLine>,
    camera_file: CameraFile,
    order: u64,
    pub(super) frame: Option<Frame>,
    pub(super) pick: Option<Pick>,
    /// A pixel to be picked once there is a frame of the newest order.
    awaited_pick: Option<(u32, u32)>,
    pub(super) page: Page,
    pub(super) scroll: usize,
    /// The last action or error.
    pub(super) message: Option<String>,
}

/// The initial state of a session besides the scene.
pub struct Start {
    /// The name of the scene.
    pub name: String,
    /// The settings of its pictures.
    pub settings: Settings,
    /// Their tone mapping.
    pub tone: ToneMapping,
    /// The file of saved cameras.
    pub camera_file: CameraFile,
    /// Their renderer.
    pub pool: rayon::ThreadPool,
    /// Is called when there is a new picture to [take](Session::update), from another thread.
    pub notify: Box<dyn Fn() + Send + Sync>,
}

impl Session {
    /// Looks at a world from its camera; `outline` is its scene's tree.
    pub fn new(world: World, outline: Vec<OutlineLine>, start: Start) -> Self {
        let Start { name, settings, tone, camera_file, pool, notify } = start;
        let box_of = world.bounds();
        let bounds = if box_of.is_empty() { (Vec3::ZERO, Vec3::ZERO) } else { (box_of.min, box_of.max) };
        let pose = world.camera();
        let is_movable = !matches!(world.optics().projection, Projection::Rays(_));
        let is_perspective = matches!(world.optics().projection, Projection::Perspective);
        let layers = Layer::all(&world, &settings);
        let mut session = Self {
            name,
            renderer: Renderer::new(world, pool, notify),
            settings,
            pose,
            home: pose,
            is_movable,
            is_perspective,
            bounds,
            layers,
            layer: 0,
            tone,
            first_tone: tone,
            outline,
            camera_file,
            order: 0,
            frame: None,
            pick: None,
            awaited_pick: None,
            page: Page::default(),
            scroll: 0,
            message: None,
        };
        session.render();
        session
    }

    /// A scene's tree, which is lost when a world is made of it.
    pub fn outline(scene: &Scene, name: &str) -> Vec<OutlineLine> {
        outline(scene, name)
    }

    /// The settings of the pictures.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The camera.
    pub fn pose(&self) -> CameraPose {
        self.pose
    }

    /// The shown layer.
    pub fn layer(&self) -> &Layer {
        &self.layers[self.layer]
    }

    /// How.
    pub fn tone(&self) -> ToneMapping {
        self.tone
    }

    /// The newest frame.
    pub fn frame(&self) -> Option<&Frame> {
        self.frame.as_ref()
    }

    /// The picked surface.
    pub fn pick(&self) -> Option<&Pick> {
        self.pick.as_ref()
    }

    /// The last action or error.
    pub fn message(&self) -> Option<&str> {
        self.message.as_deref()
    }

    /// The sRGB codes of the picture so far, row by row from the top; `None` before there is one.
    pub fn codes(&self) -> Option<Vec<[u8; 3]>> {
        self.frame.as_ref().map(|frame| self.layer().codes(&frame.picture, &self.tone, self.bounds))
    }

    /// Takes the newest frame; whether anything has changed.
    pub fn update(&mut self) -> bool {
        let frame = match self.renderer.take_frame() {
            Ok(Some(frame)) if frame.order == self.order => frame,
            Ok(_) => return false,
            Err(error) => {
                self.message = Some(error);
                return true;
            }
        };
        let before = self.frame.replace(frame);
        if let Some(pixel) = self.awaited_pick.take() {
            self.pick_at(pixel);
        } else if let Some(pick) = &self.pick {
            // There may be other last samples by now.
            let finished = self.frame.as_ref().is_some_and(|frame| frame.finished);
            if finished || before.is_none_or(|frame| frame.samples.start < EARLY) {
                self.pick_at(pick.pixel);
            }
        }
        true
    }

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

    /// Restarts the render, or continues it.
    fn render(&mut self) {
        let order = Order { pose: self.pose, settings: self.settings.clone() };
        self.order = self.renderer.order(order, &self.layers[self.layer].channels);
    }

    /// Picks a pixel of the frame, which is of the newest order, so that the world is seen from its pose.
    fn pick_at(&mut self, pixel: (u32, u32)) {
        let samples = self.frame.as_ref().map_or(0, |frame| frame.samples.start);
        let world = self.renderer.world();
        self.pick = Some(Pick::new(&world, &self.pose, &self.settings, pixel, samples));
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

    /// The camera as options of `halfdome render`.
    pub fn camera_options(&self) -> String {
        let point = |point: Vec3| point.to_array().map(number).join(",");
        let CameraPose { eye, target, up, vfov } = self.pose;
        let vfov = if self.is_perspective { format!(" --vfov {}", number(vfov)) } else { String::new() };
        format!("--eye {} --target {} --up {}{vfov}", point(eye), point(target), point(up))
    }

    /// Whether the integrator learns or fills a cache before the first sample.
    pub(super) fn prepares(&self) -> bool {
        match &self.settings.integrator {
            Integrator::Cached(_) => true,
            Integrator::Path(options) => options.guide.is_some(),
            _ => false,
        }
    }

    fn say(&mut self, text: &str) {
        self.message = Some(text.to_owned());
    }
}
