//! The window: its events become commands, and what it shows is drawn into a buffer of its pixels, without a GPU.

use std::num::NonZeroU32;
use std::rc::Rc;

use softbuffer::{Context, SoftBufferError, Surface};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop, OwnedDisplayHandle};
use winit::keyboard::{Key, ModifiersState, NamedKey};
use winit::window::WindowId;

use crate::cli::error::{CliError, EXIT_DONE};
use crate::view::{self, Command, Screen, Session, ZOOM_STEP, panel_width};

/// Radians for a drag across the picture.
const TURN: f64 = 3.0;
/// Pixels that a hand moves which only clicks.
const STILL: f64 = 4.0;
/// Pixels of a wheel's step.
const WHEEL: f64 = 20.0;
/// Lines of text for a wheel's step.
const LINES: f64 = 3.0;
/// The least height, for the text, and the greatest size that a window has at first.
const MIN_HEIGHT: u32 = 720;
const MAX_SIZE: (u32, u32) = (1600, 1000);

/// A display on which a window can be opened.
pub(super) struct Window {
    events: EventLoop<()>,
}

impl Window {
    /// Finds the display.
    pub(super) fn open() -> Result<Self, CliError> {
        let events = EventLoop::with_user_event().build().map_err(|error| no_display(&error))?;
        Ok(Self { events })
    }

    /// Wakes the window, from any thread.
    pub(super) fn notify(&self) -> Box<dyn Fn() + Send + Sync> {
        let proxy = self.events.create_proxy();
        Box::new(move || {
            // A window that is closed needs no waking.
            let _ = proxy.send_event(());
        })
    }

    /// Shows a session until the window is closed.
    pub(super) fn show(self, session: Session) -> Result<u8, CliError> {
        let context = Context::new(self.events.owned_display_handle()).map_err(|error| no_display(&error))?;
        let mut shown = Shown {
            session,
            context,
            surface: None,
            codes: Vec::new(),
            has_panel: true,
            cursor: (0.0, 0.0),
            modifiers: ModifiersState::empty(),
            drag: None,
            failure: None,
        };
        self.events.run_app(&mut shown).map_err(CliError::system)?;
        match shown.failure {
            Some(failure) => Err(CliError::System(failure)),
            None => Ok(EXIT_DONE),
        }
    }
}

fn no_display(error: &dyn std::fmt::Display) -> CliError {
    // winit names a place in its source before what is wrong.
    let error = error.to_string();
    let reason = error.rsplit(": ").next().unwrap_or(&error).trim_end_matches('.');
    CliError::System(format!(
        "there is no display to open a window on ({reason})\n  help: run it where there is a screen (DISPLAY is set, also \
         by `ssh -X`), or watch the picture grow without a window: `halfdome render --tev=HOST:PORT`, or `--progressive`, \
         which writes it early"
    ))
}

/// The contents of the window.
struct Shown {
    session: Session,
    context: Context<OwnedDisplayHandle>,
    surface: Option<Surface<OwnedDisplayHandle, Rc<winit::window::Window>>>,
    /// The pixels of the picture that was shown last.
    codes: Vec<[u8; 3]>,
    has_panel: bool,
    cursor: (f64, f64),
    modifiers: ModifiersState,
    drag: Option<Drag>,
    failure: Option<String>,
}

/// A button that is held.
struct Drag {
    button: MouseButton,
    last: (f64, f64),
    /// How far it went.
    distance: f64,
}

impl ApplicationHandler for Shown {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.surface.is_some() {
            return;
        }
        let settings = self.session.settings();
        let width = (settings.width + panel_width() as u32).min(MAX_SIZE.0);
        let height = settings.height.clamp(MIN_HEIGHT, MAX_SIZE.1);
        let attributes = winit::window::Window::default_attributes()
            .with_title("halfdome view")
            .with_inner_size(PhysicalSize::new(width, height));
        let opened = events.create_window(attributes).map_err(|error| error.to_string());
        let opened =
            opened.and_then(|window| Surface::new(&self.context, Rc::new(window)).map_err(|error| error.to_string()));
        match opened {
            Ok(surface) => self.surface = Some(surface),
            Err(error) => self.fail(events, format!("cannot open a window: {error}")),
        }
    }

    fn user_event(&mut self, _events: &ActiveEventLoop, (): ()) {
        if self.session.update() {
            self.look();
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(_) => self.redraw(),
            WindowEvent::RedrawRequested => {
                if let Err(error) = self.draw() {
                    self.fail(events, format!("cannot draw into the window: {error}"));
                }
            }
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, .. } if event.state == ElementState::Pressed => {
                self.press(events, &event.logical_key);
            }
            WindowEvent::CursorMoved { position, .. } => self.point((position.x, position.y)),
            WindowEvent::MouseInput { state: ElementState::Pressed, button, .. } if !self.is_on_panel() => {
                self.drag = Some(Drag { button, last: self.cursor, distance: 0.0 });
            }
            WindowEvent::MouseInput { state: ElementState::Released, button, .. } => self.release(button),
            WindowEvent::MouseWheel { delta, .. } => {
                let steps = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / WHEEL,
                };
                self.apply(match self.is_on_panel() {
                    true => Command::Scroll(-(steps * LINES).round() as isize),
                    false => Command::Zoom(ZOOM_STEP.powf(steps)),
                });
            }
            _ => {}
        }
    }
}

impl Shown {
    fn fail(&mut self, events: &ActiveEventLoop, failure: String) {
        self.failure = Some(failure);
        events.exit();
    }

    fn press(&mut self, events: &ActiveEventLoop, key: &Key) {
        let name = match key {
            Key::Character(text) => text.as_str(),
            Key::Named(NamedKey::Escape) => "q",
            Key::Named(NamedKey::ArrowLeft) => "ArrowLeft",
            Key::Named(NamedKey::ArrowRight) => "ArrowRight",
            Key::Named(NamedKey::ArrowUp) => "ArrowUp",
            Key::Named(NamedKey::ArrowDown) => "ArrowDown",
            Key::Named(NamedKey::PageUp) => "PageUp",
            Key::Named(NamedKey::PageDown) => "PageDown",
            Key::Named(NamedKey::Home) => "Home",
            Key::Named(NamedKey::Tab) => {
                self.has_panel = !self.has_panel;
                return self.redraw();
            }
            _ => return,
        };
        if name == "q" {
            return events.exit();
        }
        if let Some(command) = view::command(name, self.modifiers.shift_key()) {
            self.apply(command);
        }
    }

    fn point(&mut self, to: (f64, f64)) {
        self.cursor = to;
        let width = self.picture_width().max(1) as f64;
        let pans = self.modifiers.shift_key();
        let Some(drag) = &mut self.drag else { return };
        let (right, down) = (to.0 - drag.last.0, to.1 - drag.last.1);
        drag.distance += right.hypot(down);
        drag.last = to;
        if drag.distance < STILL {
            return;
        }
        let pans = pans || drag.button != MouseButton::Left;
        self.apply(match pans {
            true => Command::Pan(-right / width, down / width),
            false => Command::Orbit(-right * TURN / width, down * TURN / width),
        });
    }

    fn release(&mut self, button: MouseButton) {
        let Some(drag) = self.drag.take_if(|drag| drag.button == button) else { return };
        let settings = self.session.settings();
        let size = (settings.width, settings.height);
        let is_click = drag.distance < STILL && button == MouseButton::Left;
        if let Some((x, y)) = Screen::pixel_at(self.size(), self.has_panel, size, self.cursor).filter(|_| is_click) {
            self.apply(Command::Pick(x, y));
        }
    }

    fn apply(&mut self, command: Command) {
        self.session.apply(command);
        if let (Command::Save, Some(message)) = (command, self.session.message()) {
            eprintln!("{message}");
        }
        self.look();
    }

    /// Takes the newest colours, if there are any: until then the old ones are shown.
    fn look(&mut self) {
        if let Some(codes) = self.session.codes() {
            self.codes = codes;
        }
        self.redraw();
    }

    fn redraw(&self) {
        if let Some(surface) = &self.surface {
            surface.window().request_redraw();
        }
    }

    fn size(&self) -> (usize, usize) {
        let size = self.surface.as_ref().map(|surface| surface.window().inner_size()).unwrap_or_default();
        (size.width as usize, size.height as usize)
    }

    fn picture_width(&self) -> usize {
        Screen::picture_width(self.size().0, self.has_panel)
    }

    fn is_on_panel(&self) -> bool {
        self.has_panel && self.cursor.0 >= self.picture_width() as f64
    }

    fn draw(&mut self) -> Result<(), SoftBufferError> {
        let (width, height) = self.size();
        let settings = self.session.settings();
        let picture = (settings.width, settings.height);
        let (Some(columns), Some(rows)) = (NonZeroU32::new(width as u32), NonZeroU32::new(height as u32)) else {
            return Ok(());
        };
        let mut screen = Screen::new(width, height);
        if !self.codes.is_empty() {
            screen.draw_picture(&self.codes, picture.0, self.has_panel);
        }
        if let Some(pick) = self.session.pick() {
            screen.mark(pick.pixel, picture, self.has_panel);
        }
        if self.has_panel {
            screen.draw_panel(&self.session.text(Screen::rows(height)));
        }
        let Some(surface) = &mut self.surface else { return Ok(()) };
        surface.resize(columns, rows)?;
        let mut buffer = surface.buffer_mut()?;
        for (pixel, [r, g, b]) in buffer.iter_mut().zip(screen.pixels()) {
            *pixel = u32::from_be_bytes([0, *r, *g, *b]);
        }
        buffer.present()
    }
}
