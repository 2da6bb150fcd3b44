//! What crosses the border: pointers from C become slices and references, or a [`Failure`] that names the argument.

use std::mem::MaybeUninit;
use std::slice;

use bytemuck::{AnyBitPattern, Zeroable};

use crate::status::hd_status::*;
use crate::status::{Failure, hd_status};

fn fail<T>(status: hd_status, message: String) -> Result<T, Failure> {
    Err(Failure::new(status, message))
}

/// Checks that `count` elements may lie at `pointer`, which is not looked into.
pub(crate) fn check<T>(name: &str, pointer: *const T, count: usize) -> Result<(), Failure> {
    if pointer.is_null() {
        return fail(HD_ERROR_NULL, format!("{name} is NULL"));
    }
    if !pointer.is_aligned() {
        return fail(HD_ERROR_ALIGNMENT, format!("{name} is at {pointer:p}, and not aligned to {}", align_of::<T>()));
    }
    if count.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return fail(HD_ERROR_SIZE, format!("{name} cannot have {count} elements: there is no such memory"));
    }
    Ok(())
}

/// The elements that a function reads. There need not be a pointer to none.
///
/// # Safety
/// If `pointer` is not null, `count` elements lie there, which nobody changes during `'a`.
pub(crate) unsafe fn elements<'a, T: AnyBitPattern>(
    name: &str,
    pointer: *const T,
    count: usize,
) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    check(name, pointer, count)?;
    // SAFETY: the pointer is aligned and not null, and the caller promises the rest; any bits are an element.
    Ok(unsafe { slice::from_raw_parts(pointer, count) })
}

/// Room for the elements that a function writes, filled with zeros: what lay there need not have been any.
///
/// # Safety
/// If `pointer` is not null, there is memory for `count` elements, which nobody else uses during `'a`.
pub(crate) unsafe fn room<'a, T: Zeroable>(name: &str, pointer: *mut T, count: usize) -> Result<&'a mut [T], Failure> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(name, pointer, count)?;
    // SAFETY: the pointer is aligned and not null, and the caller promises the rest; zeros are an element.
    unsafe {
        pointer.write_bytes(0, count);
        Ok(slice::from_raw_parts_mut(pointer, count))
    }
}

/// Room for one element.
///
/// # Safety
/// That of [`room`].
pub(crate) unsafe fn room_for_one<'a, T: Zeroable>(name: &str, pointer: *mut T) -> Result<&'a mut T, Failure> {
    // SAFETY: the caller's promise.
    unsafe { room(name, pointer, 1) }.map(|elements| &mut elements[0])
}

/// The handle behind a pointer.
pub(crate) fn handle<'a, T>(name: &str, handle: Option<&'a T>) -> Result<&'a T, Failure> {
    handle.ok_or_else(|| Failure::new(HD_ERROR_NULL, format!("{name} is NULL")))
}

/// The handle behind a pointer, to be changed.
pub(crate) fn handle_mut<'a, T>(name: &str, handle: Option<&'a mut T>) -> Result<&'a mut T, Failure> {
    handle.ok_or_else(|| Failure::new(HD_ERROR_NULL, format!("{name} is NULL")))
}

/// Makes a new handle and writes it to where C wants it; NULL if it cannot be made.
///
/// # Safety
/// That of [`room`] for one pointer.
pub(crate) unsafe fn make<T>(
    name: &str,
    place: *mut *mut T,
    made: impl FnOnce() -> Result<T, Failure>,
) -> Result<(), Failure> {
    check(name, place, 1)?;
    // SAFETY: the pointer is aligned and not null, and the caller promises room.
    unsafe { place.write(std::ptr::null_mut()) };
    let made = Box::into_raw(Box::new(made()?));
    // SAFETY: as before.
    unsafe { place.write(made) };
    Ok(())
}

/// A structure that may grow with later versions of the header.
///
/// # Safety
/// The first field is a `usize`, `struct_size`, any bits are a value, and zeros are what a program wants that knows no
/// more than the first [`FIRST_SIZE`](Self::FIRST_SIZE) bytes.
pub(crate) unsafe trait Versioned: Copy {
    /// Its name in C.
    const NAME: &'static str;
    /// Its size in the first header that had it.
    const FIRST_SIZE: usize = size_of::<Self>();
}

/// The `struct_size` of the structure at `pointer`, if this library knows structures of that size.
///
/// # Safety
/// If `pointer` is not null, a structure of as many bytes lies there as its first field says, which nobody else uses
/// meanwhile.
unsafe fn known_size<T: Versioned>(name: &str, pointer: *const T) -> Result<usize, Failure> {
    check(name, pointer, 1)?;
    // SAFETY: the pointer is aligned and not null, and the caller promises the field.
    let size = unsafe { pointer.cast::<usize>().read() };
    let (first, known, which) = (T::FIRST_SIZE, size_of::<T>(), T::NAME);
    if size == first || size == known {
        return Ok(size);
    }
    let sizes = if first == known { known.to_string() } else { format!("{first} or {known}") };
    fail(HD_ERROR_VERSION, format!("{name}->struct_size is {size}; this library knows {which} of {sizes} bytes"))
}

/// The structure that a function reads; what an older program does not know of is zero.
///
/// # Safety
/// If `pointer` is not null, a structure of as many bytes lies there as its first field says.
pub(crate) unsafe fn versioned<T: Versioned>(name: &str, pointer: *const T) -> Result<T, Failure> {
    // SAFETY: the caller's promise; as many bytes are there as are copied, and zeros are a value of the rest.
    unsafe {
        let size = known_size(name, pointer)?;
        let mut structure = MaybeUninit::<T>::zeroed();
        structure.as_mut_ptr().cast::<u8>().copy_from_nonoverlapping(pointer.cast(), size);
        Ok(structure.assume_init())
    }
}

/// The bytes from one structure of an array to the next: as many as the first says that it has. An array of none may be
/// null.
///
/// # Safety
/// That of [`versioned`].
pub(crate) unsafe fn stride<T: Versioned>(name: &str, first: *const T, count: usize) -> Result<usize, Failure> {
    if count == 0 {
        return Ok(0);
    }
    check(name, first, count)?;
    // SAFETY: the caller's promise.
    unsafe { known_size(name, first) }
}

/// The structure that a function writes; its `struct_size` is set.
///
/// # Safety
/// If `pointer` is not null, a structure of as many bytes lies there as its first field says, which nobody else uses
/// during `'a`.
pub(crate) unsafe fn versioned_room<'a, T: Versioned>(name: &str, pointer: *mut T) -> Result<&'a mut T, Failure> {
    const { assert!(T::FIRST_SIZE == size_of::<T>(), "what is written has not grown yet") };
    // SAFETY: the caller's promise; the structure is all there if its size is right, and any bits are a value.
    unsafe {
        known_size(name, pointer)?;
        Ok(&mut *pointer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pointers_are_checked() {
        let numbers = [1u32, 2, 3];
        let at = numbers.as_ptr();
        // SAFETY: all that is read is there, and the others are refused.
        unsafe {
            assert_eq!(elements("x", at, 3).unwrap(), numbers);
            assert_eq!(elements::<u32>("x", std::ptr::null(), 0).unwrap(), []);
            let status = |result: Result<&[u32], Failure>| result.unwrap_err().status;
            assert_eq!(status(elements("x", std::ptr::null(), 1)), HD_ERROR_NULL);
            assert_eq!(status(elements("x", at.byte_add(2), 1)), HD_ERROR_ALIGNMENT);
            assert_eq!(status(elements("x", at, usize::MAX / 4)), HD_ERROR_SIZE);
            assert_eq!(status(elements("x", at, usize::MAX)), HD_ERROR_SIZE);
        }
    }

    /// Grew by its last field.
    #[derive(Clone, Copy)]
    #[repr(C)]
    struct Grown {
        struct_size: usize,
        old: usize,
        new: usize,
    }

    // SAFETY: struct_size comes first, and numbers may have any bits.
    unsafe impl Versioned for Grown {
        const NAME: &'static str = "Grown";
        const FIRST_SIZE: usize = 2 * size_of::<usize>();
    }

    #[test]
    fn structures_of_older_headers_end_in_zeros() {
        let (old, new) = (2 * size_of::<usize>(), 3 * size_of::<usize>());
        for (struct_size, expected) in [(old, Some(0)), (new, Some(9)), (0, None), (old + 1, None), (new + 8, None)] {
            let grown = Grown { struct_size, old: 7, new: 9 };
            // SAFETY: it is there, and sizes beyond its own are refused.
            let read = unsafe { versioned("x", &raw const grown) };
            match expected {
                Some(new) => assert_eq!(read.map(|read| (read.old, read.new)).unwrap(), (7, new)),
                None => assert_eq!(read.err().unwrap().status, HD_ERROR_VERSION),
            }
        }
    }

    #[test]
    fn handles_are_null_if_they_cannot_be_made() {
        let mut place = std::ptr::dangling_mut::<u8>();
        // SAFETY: the place is there.
        let result = unsafe { make("x", &raw mut place, || fail(HD_ERROR_VALUE, "no".to_owned())) };
        assert_eq!(result.unwrap_err().status, HD_ERROR_VALUE);
        assert!(place.is_null());
    }
}
