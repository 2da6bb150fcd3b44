//! What crosses the border: pointers from C become slices and references, or a [`Failure`] that names the argument.

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

/// A reference that outlives what it is told to.
///
/// # Safety
/// What it refers to stays where and as it is for as long as the reference, or anything made of it, is used.
pub(crate) unsafe fn forever<T: ?Sized>(reference: &T) -> &'static T {
    // SAFETY: the caller's promise.
    unsafe { &*std::ptr::from_ref(reference) }
}

/// A structure that may grow with later versions of the header.
///
/// # Safety
/// The first field is a `usize`, `struct_size`, and any bits are a value.
pub(crate) unsafe trait Versioned: Copy {
    /// Its name in C.
    const NAME: &'static str;
}

/// Checks the `struct_size` of the structure at `pointer`: version 1 of the header has one of each.
///
/// # Safety
/// If `pointer` is not null, a structure of as many bytes lies there as its first field says, which nobody else uses
/// meanwhile.
unsafe fn check_version<T: Versioned>(name: &str, pointer: *const T) -> Result<(), Failure> {
    check(name, pointer, 1)?;
    // SAFETY: the pointer is aligned and not null, and the caller promises the field.
    let size = unsafe { pointer.cast::<usize>().read() };
    if size == size_of::<T>() {
        return Ok(());
    }
    let (known, which) = (size_of::<T>(), T::NAME);
    fail(HD_ERROR_VERSION, format!("{name}->struct_size is {size}; this library knows {which} of {known} bytes"))
}

/// The structure that a function reads.
///
/// # Safety
/// If `pointer` is not null, a structure of as many bytes lies there as its first field says.
pub(crate) unsafe fn versioned<T: Versioned>(name: &str, pointer: *const T) -> Result<T, Failure> {
    // SAFETY: the caller's promise; the structure is all there if its size is right.
    unsafe {
        check_version(name, pointer)?;
        Ok(pointer.read())
    }
}

/// The structure that a function writes; its `struct_size` is set.
///
/// # Safety
/// If `pointer` is not null, a structure of as many bytes lies there as its first field says, which nobody else uses
/// during `'a`.
pub(crate) unsafe fn versioned_room<'a, T: Versioned>(name: &str, pointer: *mut T) -> Result<&'a mut T, Failure> {
    // SAFETY: the caller's promise; the structure is all there if its size is right, and any bits are a value.
    unsafe {
        check_version(name, pointer)?;
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

    #[test]
    fn handles_are_null_if_they_cannot_be_made() {
        let mut place = std::ptr::dangling_mut::<u8>();
        // SAFETY: the place is there.
        let result = unsafe { make("x", &raw mut place, || fail(HD_ERROR_VALUE, "no".to_owned())) };
        assert_eq!(result.unwrap_err().status, HD_ERROR_VALUE);
        assert!(place.is_null());
    }
}
