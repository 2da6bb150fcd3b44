//! Renders the view on its own threads: from coarse to fine, then wave by wave, like `halfdome render`.
//!
//! A thread waits for orders and hands them to the driver, so that pictures are those of [`driver::render_plan`]. A new
//! order ends the current picture; one that differs only in its number of samples continues the film. Frames only have
//! the shown channels, as a film with all AOVs has dozens.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::driver::{self, Plan};
use crate::film::{Film, Picture};
use crate::scene::CameraPose;
use crate::settings::Settings;
use crate::watch::Watch;
use crate::world::World;

/// The side of the squares that a picture begins with.
pub const COARSEST: u32 = 32;

/// How often a frame is made at least, as long as there is anything new, and at most.
const SELDOM: Duration = Duration::from_millis(700);
const OFTEN: Duration = Duration::from_millis(40);

/// An order for a picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Order {
    /// The camera.
    pub pose: CameraPose,
    /// All else.
    pub settings: Settings,
}

/// A picture so far.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The number of its order.
    pub order: u64,
    /// The channels that are shown.
    pub picture: Picture,
    /// The side of the squares that are each one sample; 1 once each pixel has one.
    pub side: u32,
    /// The least and the most samples of a pixel.
    pub samples: Range<u32>,
    /// Rays traced for it.
    pub rays: u64,
    /// Whether all samples are taken.
    pub finished: bool,
}

/// Renders what is ordered, until it is dropped.
pub(super) struct Renderer {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// The shared state of both sides.
struct Shared {
    world: RwLock<World>,
    desk: Mutex<Desk>,
    /// Something was put on the desk.
    wake: Condvar,
    /// The number of the newest order; of none when it is over.
    newest: AtomicU64,
    /// The channels on the desk have changed since the last frame.
    wants_frame: AtomicBool,
    notify: Box<dyn Fn() + Send + Sync>,
}

struct Desk {
    order: Option<(u64, Order)>,
    channels: Vec<String>,
    frame: Option<Frame>,
    /// Why no picture can be made.
    error: Option<String>,
    is_over: bool,
}

impl Renderer {
    /// A renderer without an order. `notify` is called when there is a new frame, from another thread.
    ///
    /// # Panics
    /// If the system has no thread left.
    pub(super) fn new(world: World, pool: rayon::ThreadPool, notify: Box<dyn Fn() + Send + Sync>) -> Self {
        let desk = Desk { order: None, channels: Vec::new(), frame: None, error: None, is_over: false };
        let shared = Arc::new(Shared {
            world: RwLock::new(world),
            desk: Mutex::new(desk),
            wake: Condvar::new(),
            newest: AtomicU64::new(0),
            wants_frame: AtomicBool::new(false),
            notify,
        });
        let own = shared.clone();
        let thread = std::thread::Builder::new().name("renderer".to_owned()).spawn(move || own.work(&pool));
        Self { shared, thread: Some(thread.expect("the system has threads")) }
    }

    /// The world, from wherever it was looked at last.
    pub(super) fn world(&self) -> RwLockReadGuard<'_, World> {
        self.shared.world.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Renders this instead of whatever was rendered, and shows these channels of it; gives its number.
    pub(super) fn order(&self, order: Order, channels: &[String]) -> u64 {
        let mut desk = self.shared.desk();
        let number = self.shared.newest.fetch_add(1, Ordering::SeqCst) + 1;
        desk.order = Some((number, order));
        desk.channels = channels.to_vec();
        self.shared.wake.notify_all();
        number
    }

    /// Shows these channels from now on.
    pub(super) fn show(&self, channels: &[String]) {
        let mut desk = self.shared.desk();
        desk.channels = channels.to_vec();
        desk.frame = None;
        drop(desk);
        self.shared.wants_frame.store(true, Ordering::SeqCst);
        self.shared.wake.notify_all();
    }

    /// The newest frame, if there is one that was not taken; or why there are none.
    ///
    /// # Errors
    /// If no picture can be made as ordered.
    pub(super) fn take_frame(&self) -> Result<Option<Frame>, String> {
        let mut desk = self.shared.desk();
        match desk.error.take() {
            Some(error) => Err(error),
            None => Ok(desk.frame.take()),
        }
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        self.shared.desk().is_over = true;
        self.shared.newest.fetch_add(1, Ordering::SeqCst);
        self.shared.wake.notify_all();
        if let Some(thread) = self.thread.take() {
            // A panic there has been printed.
            let _ = thread.join();
        }
    }
}

/// A film that no thread works on.
struct Kept {
    number: u64,
    order: Order,
    film: Film,
    rays: u64,
    finished: bool,
}

impl Shared {
    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn work(&self, pool: &rayon::ThreadPool) {
        let mut kept: Option<Kept> = None;
        while let Some(order) = self.next_order(&mut kept) {
            let (number, order) = order;
            let before = kept.take().filter(|kept| kept.order.goes_on_as(&order));
            let mut world = self.world.write().unwrap_or_else(PoisonError::into_inner);
            if world.camera() != order.pose {
                let world: &mut World = &mut world;
                pool.install(|| world.look_through(order.pose));
            }
            drop(world);
            let guard = self.world.read().unwrap_or_else(PoisonError::into_inner);
            let world: &World = &guard;
            let (film, rays) = before.map_or((None, 0), |kept| (Some(kept.film), kept.rays));
            let watch =
                OrderWatch { shared: self, number, rays: AtomicU64::new(rays), last_frame: Mutex::new(Instant::now()) };
            let plan = Plan { film, ..Plan::default() };
            let render = pool.install(|| driver::render_plan(world, &order.settings, plan, &watch));
            drop(guard);
            match render {
                Err(error) => {
                    self.desk().error = Some(error.to_string());
                    (self.notify)();
                }
                // In a picture that was given up some pixels may have no samples.
                Ok(render) if render.finished || render.film.samples().start > 0 => {
                    let rays = watch.rays.into_inner();
                    let new = Kept { number, order, film: render.film, rays, finished: render.finished };
                    self.put_film(new.number, &new.film, new.rays, new.finished);
                    kept = Some(new);
                }
                Ok(_) => {}
            }
        }
    }

    /// Waits for an order; in the meantime shows what is wanted of the film that there is.
    fn next_order(&self, kept: &mut Option<Kept>) -> Option<(u64, Order)> {
        let mut desk = self.desk();
        loop {
            if desk.is_over {
                return None;
            }
            if let Some(order) = desk.order.take() {
                return Some(order);
            }
            if let (true, Some(kept)) = (self.wants_frame.load(Ordering::SeqCst), kept.as_ref()) {
                drop(desk);
                self.put_film(kept.number, &kept.film, kept.rays, kept.finished);
                desk = self.desk();
                continue;
            }
            desk = self.wake.wait(desk).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn put_film(&self, order: u64, film: &Film, rays: u64, finished: bool) {
        self.wants_frame.store(false, Ordering::SeqCst);
        let channels = self.desk().channels.clone();
        let picture = film.picture_of(|name| channels.iter().any(|channel| channel == name));
        self.put(Frame { order, picture, side: 1, samples: film.samples(), rays, finished });
    }

    /// Puts a frame on the desk, unless another picture or other channels are wanted by now.
    fn put(&self, frame: Frame) {
        let mut desk = self.desk();
        let is_shown = |name: &String| desk.channels.contains(name);
        let is_wanted = frame.picture.channels.iter().all(|channel| is_shown(&channel.name));
        if is_wanted && frame.order == self.newest.load(Ordering::SeqCst) {
            desk.frame = Some(frame);
            drop(desk);
            (self.notify)();
        }
    }
}

impl Order {
    /// Whether its film is one of this order too, with another number of samples.
    fn goes_on_as(&self, other: &Self) -> bool {
        let settings = Settings { spp: other.settings.spp, ..self.settings.clone() };
        self.pose == other.pose && settings == other.settings
    }
}

/// Makes frames of a picture.
struct OrderWatch<'a> {
    shared: &'a Shared,
    number: u64,
    rays: AtomicU64,
    last_frame: Mutex<Instant>,
}

impl OrderWatch<'_> {
    fn is_older_than(&self, age: Duration) -> bool {
        self.last_frame.lock().unwrap_or_else(PoisonError::into_inner).elapsed() > age
    }

    fn shown(&self) {
        *self.last_frame.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
    }
}

impl Watch for OrderWatch<'_> {
    fn advance(&self, _samples: u64, rays: u64) {
        self.rays.fetch_add(rays, Ordering::Relaxed);
    }

    fn stop(&self) -> bool {
        self.gives_up()
    }

    fn gives_up(&self) -> bool {
        self.shared.newest.load(Ordering::Relaxed) != self.number
    }

    fn coarsest(&self) -> u32 {
        COARSEST
    }

    fn wants_channel(&self, name: &str) -> bool {
        self.shared.desk().channels.iter().any(|channel| channel == name)
    }

    fn level(&self, side: u32, picture: &Picture) {
        self.shared.wants_frame.store(false, Ordering::SeqCst);
        let rays = self.rays.load(Ordering::Relaxed);
        let (picture, samples) = (picture.clone(), u32::from(side == 1)..1);
        self.shared.put(Frame { order: self.number, picture, side, samples, rays, finished: false });
        self.shown();
    }

    fn wave(&self, film: &Film) {
        if self.is_older_than(OFTEN) {
            self.film(film);
        }
    }

    fn wants_film(&self) -> bool {
        self.shared.wants_frame.load(Ordering::Relaxed) || self.is_older_than(SELDOM)
    }

    fn film(&self, film: &Film) {
        self.shared.put_film(self.number, film, self.rays.load(Ordering::Relaxed), false);
        self.shown();
    }
}
