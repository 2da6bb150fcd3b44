//! The picture on a Cortex-M4F, printed through semihosting, with what it took: memory by the paint that is left on the
//! stack, time by the system timer. Lines with figures begin with `#`.
#![no_std]
#![no_main]

use core::fmt::{self, Write};
use core::panic::PanicInfo;

use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{Peripherals, SYST};
use cortex_m_rt::{STACK_PAINT_VALUE, entry};
use cortex_m_semihosting::{debug, hio};
use glam::{Vec3, vec3};
use halfdome_cortex_m::{CORNELL, Traced, draw};
use halfdome_kernel::{BvhView, Hit, Ray};

/// Turns of the loop that the clock is measured by, of two instructions each.
const TURNS: u32 = 2_000_000;

#[entry]
fn main() -> ! {
    let done = run();
    debug::exit(if done.is_ok() { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    loop {}
}

fn run() -> fmt::Result {
    let mut out = hio::hstdout().map_err(|()| fmt::Error)?;
    let mut clock = Clock::start(Peripherals::take().ok_or(fmt::Error)?.SYST);
    let Ok(tree) = BvhView::from_bytes(CORNELL) else {
        writeln!(out, "the blob in flash is damaged")?;
        return Err(fmt::Error);
    };
    let opened = (clock.ticks(), used_stack());
    // One ray, for what it needs: the picture keeps a row of them besides.
    let mut middle = [Hit::MISS];
    tree.intersect_many(&[Ray::new(vec3(0.278, 0.273, -0.8), Vec3::Z)], &mut middle);
    let traced = used_stack();
    if !middle[0].is_hit() {
        return Err(fmt::Error);
    }
    let report = draw(&tree, &mut out, || clock.ticks())?;

    // How many instructions a tick is, by a loop of known length.
    let start = clock.ticks();
    cortex_m::asm::delay(TURNS);
    let ticks = clock.ticks() - start;
    let instructions = |time: u64| time * u64::from(2 * TURNS) / ticks.max(1);
    writeln!(out, "# opening the blob of {} bytes: {} instructions", CORNELL.len(), instructions(opened.0))?;
    for (name, Traced { rays, time }) in [("closest", report.closest), ("any", report.any)] {
        writeln!(out, "# {name}: {} instructions a ray", instructions(time) / u64::from(rays))?;
    }
    let (open, ray, picture) = (opened.1, traced, used_stack());
    writeln!(out, "# stack: {open} bytes to open the blob, {ray} to trace a ray, {picture} for all, of {}", stack().1)
}

/// The system timer, which counts down 24 bits, as a clock that goes on.
struct Clock {
    timer: SYST,
    last: u32,
    total: u64,
}

impl Clock {
    const PERIOD: u32 = 1 << 24;

    fn start(mut timer: SYST) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(Self::PERIOD - 1);
        timer.clear_current();
        timer.enable_counter();
        Self { timer, last: 0, total: 0 }
    }

    /// Ticks since the start. To be asked at least once a period.
    fn ticks(&mut self) -> u64 {
        let _ = &self.timer;
        let now = SYST::get_current();
        self.total += u64::from(self.last.wrapping_sub(now) % Self::PERIOD);
        self.last = now;
        self.total
    }
}

/// The lowest word of the stack, and its size in bytes.
fn stack() -> (*const u32, usize) {
    unsafe extern "C" {
        static _stack_start: u32;
        static _stack_end: u32;
    }
    // It grows down from its start.
    let (top, bottom) = (&raw const _stack_start, &raw const _stack_end);
    (bottom, top as usize - bottom as usize)
}

/// The bytes of the stack that were used up to now.
fn used_stack() -> usize {
    let (bottom, size) = stack();
    let words = (0..size / size_of::<u32>()).map(|index| bottom.wrapping_add(index));
    // SAFETY: all words of the stack are memory, which the start-up code has painted. They are read as what they are,
    // volatile, since some belong to functions that are running.
    let painted = words.take_while(|word| unsafe { word.read_volatile() } == STACK_PAINT_VALUE);
    size - size_of::<u32>() * painted.count()
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    if let Ok(mut out) = hio::hstdout() {
        let _ = writeln!(out, "{info}");
    }
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}
