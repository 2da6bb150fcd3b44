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
use halfdome_cortex_m::{CORNELL, Traced, draw};
use halfdome_kernel::BvhView;

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
    let tree = match BvhView::from_bytes(CORNELL) {
        Ok(tree) => tree,
        Err(error) => {
            writeln!(out, "{error}")?;
            return Err(fmt::Error);
        }
    };
    let opened = clock.ticks();
    let report = draw(&tree, &mut out, || clock.ticks())?;

    // How many instructions a tick is, by a loop of known length.
    let start = clock.ticks();
    cortex_m::asm::delay(TURNS);
    let ticks = clock.ticks() - start;
    let instructions = |time: u64| time * u64::from(2 * TURNS) / ticks.max(1);
    writeln!(out, "# opening the blob: {} instructions", instructions(opened))?;
    for (name, Traced { rays, time }) in [("closest", report.closest), ("any", report.any)] {
        writeln!(out, "# {name}: {} instructions a ray", instructions(time) / u64::from(rays))?;
    }
    let (used, size) = stack();
    writeln!(out, "# stack: {used} bytes used of {size}; blob: {} bytes in flash", CORNELL.len())
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

/// The bytes of the stack that were ever used, and all that there are.
fn stack() -> (usize, usize) {
    unsafe extern "C" {
        static _stack_start: u32;
        static _stack_end: u32;
    }
    // The stack grows down from its start.
    let (top, bottom) = (&raw const _stack_start, &raw const _stack_end);
    let mut unused = bottom;
    // SAFETY: all words of the stack are memory, which the start-up code has painted. They are read as what they are,
    // volatile, since some belong to functions that are running.
    while unused < top && unsafe { unused.read_volatile() } == STACK_PAINT_VALUE {
        unused = unused.wrapping_add(1);
    }
    (top as usize - unused as usize, top as usize - bottom as usize)
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    if let Ok(mut out) = hio::hstdout() {
        let _ = writeln!(out, "{info}");
    }
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}
