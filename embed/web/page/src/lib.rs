//! The renderer behind functions that JavaScript calls: `engine.js`, beside, is their only caller.
//!
//! An instance is one worker's: it has a scene, and renders its share of the tiles step by step. JavaScript requests
//! memory, writes the next function's input there, and reads the answer at [`output`]; no function keeps an address. So
//! this border needs no unsafe code but the names of its functions. Functions give `DONE`, `FAILED`, where the answer
//! is a message, or `NOTHING`.

mod files;
mod page;
mod view;

use std::cell::RefCell;

use page::Page;

/// The answer is as promised.
const DONE: u32 = 0;
/// The answer is a message about what is wrong; all is as it was before.
const FAILED: u32 = 1;
/// There was nothing to do.
const NOTHING: u32 = 2;

thread_local! {
    static PAGE: RefCell<Page> = RefCell::default();
    static INPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static OUTPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

#[cfg(target_family = "wasm")]
#[link(wasm_import_module = "page")]
unsafe extern "C" {
    /// Hears that a number of rays more were traced by a function that takes long.
    safe fn progress(rays: f64);
    /// Hears why the instance is about to come to its end: UTF-8 text at an address.
    safe fn panicked(message: *const u8, length: usize);
}

#[cfg(not(target_family = "wasm"))]
fn progress(_rays: f64) {}

/// To be called before all else: has the page told of a panic's message, which would be lost.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn init() {
    #[cfg(target_family = "wasm")]
    std::panic::set_hook(Box::new(|info| {
        let message = info.to_string();
        panicked(message.as_ptr(), message.len());
    }));
}

/// Room for the `length` bytes that the next function reads: its address, or 0 if there is no memory left.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn input(length: usize) -> *mut u8 {
    INPUT.with_borrow_mut(|input| {
        input.clear();
        if input.try_reserve_exact(length).is_err() {
            return std::ptr::null_mut();
        }
        input.resize(length, 0);
        input.as_mut_ptr()
    })
}

/// The address of the last function's answer.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn output() -> *const u8 {
    OUTPUT.with_borrow(|output| output.as_ptr())
}

/// The bytes of the last function's answer.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn output_length() -> usize {
    OUTPUT.with_borrow(|output| output.len())
}

/// Reads a file of `length` bytes and then its name, and keeps it for [`open`].
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn add_file(length: usize) -> u32 {
    call(|page, input| page.add_file(input, length))
}

/// Reads the name of a model among the files, or nothing for the Cornell box, opens it in place of the scene that was
/// there, and forgets the files. The answer is a `Summary` as JSON.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn open() -> u32 {
    call(Page::open)
}

/// Reads a `View` as JSON and fills the cache for it. The answer: the number of records that the view shows, their
/// places on the film, x and y as 32-bit floats, and the cache.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn fill() -> u32 {
    call(Page::fill)
}

/// Reads a cache, for the next [`fill`] or [`start`].
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn cache() -> u32 {
    call(Page::take_cache)
}

/// Reads a `View` as JSON, and prepares to render it as worker `number` of `count`.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn start(number: usize, count: usize) -> u32 {
    call(|page, input| page.start(&input, number, count))
}

/// Renders a tile a little further. The answer: its left and upper edge, its width and height, samples taken and rays
/// traced as 32-bit numbers, and its pixels as sRGB with alpha.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn step() -> u32 {
    OUTPUT.with_borrow_mut(|output| PAGE.with_borrow_mut(|page| if page.step(output) { DONE } else { NOTHING }))
}

/// Gives the page the input, and keeps its answer.
fn call(function: impl FnOnce(&mut Page, Vec<u8>) -> Result<Vec<u8>, String>) -> u32 {
    let input = INPUT.take();
    let answer = PAGE.with_borrow_mut(|page| function(page, input));
    let (code, answer) = answer.map_or_else(|message| (FAILED, message.into_bytes()), |answer| (DONE, answer));
    OUTPUT.set(answer);
    code
}
