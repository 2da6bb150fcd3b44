//! The state of the viewer, changed by commands. It is independent of any window: callers send it commands and take the
//! picture and the text from it.

mod commands;

use glam::Vec3;

use super::outline::OutlineLine;
use super::pick::Pick;
use super::renderer::{Frame, Order, Renderer};
use super::save::{CameraFile, number};
use super::{Layer, outline};
use crate::output::ToneMapping;
use crate::scene::{CameraPose, Projection, Scene};
use crate::settings::{Integrator, Settings};
use crate::world::World;

pub use commands::{Command, Page};

/// Samples with which a pixel's paths are listed again as the picture grows.
const EARLY: u32 = 8;

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
}
