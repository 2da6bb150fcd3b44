//! Memory for trees in pages of 2 MiB, where the system supports them.
//!
//! Rays visit a large tree at random places: in pages of 4 KiB each visit costs a walk through the page table besides
//! (3 million triangles: 5 to 7% of the time). Linux gives large pages to memory that asks for them before it is used;
//! this changes nothing but speed.

use alloc::vec::Vec;

/// The least memory worth a request, in bytes.
const MIN_BYTES: usize = 4 << 20;

/// `len` copies of `value`, in large pages if possible.
pub(super) fn filled<T: Copy>(value: T, len: usize) -> Vec<T> {
    let mut memory = Vec::with_capacity(len);
    ask(&mut memory);
    memory.resize(len, value);
    memory
}

/// The same elements, in large pages if possible.
pub(super) fn moved<T: Copy>(elements: Vec<T>) -> Vec<T> {
    if size_of_val(&elements[..]) < MIN_BYTES {
        return elements;
    }
    let mut memory = Vec::with_capacity(elements.len());
    ask(&mut memory);
    memory.extend_from_slice(&elements);
    memory
}

/// Asks for large pages behind an empty vector.
#[cfg(all(feature = "std", target_os = "linux", not(miri)))]
#[expect(
    unsafe_code,
    reason = "nobody but the system can give large pages, and safe wrappers only map memory of their own"
)]
fn ask<T>(memory: &mut Vec<T>) {
    /// As large as a page of the usual kind gets.
    const PAGE: usize = 1 << 16;
    let memory = memory.spare_capacity_mut();
    let start = memory.as_mut_ptr().cast::<u8>();
    let before = start.align_offset(PAGE);
    let bytes = size_of_val(memory).saturating_sub(before) / PAGE * PAGE;
    if bytes >= MIN_BYTES {
        // SAFETY: these are whole pages of memory that this vector owns, and the advice does not change its contents.
        // If it is refused, the pages stay small.
        let _ = unsafe { libc::madvise(start.add(before).cast(), bytes, libc::MADV_HUGEPAGE) };
    }
}

/// No huge pages on this system.
#[cfg(not(all(feature = "std", target_os = "linux", not(miri))))]
fn ask<T>(_: &mut Vec<T>) {}
