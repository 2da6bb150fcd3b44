//! What functions give: a status, and a message for each thread.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

use halfdome_kernel::{Error, InvalidScene, InvalidTree};

/// The version of this interface: what a program compiled with this header needs.
pub const HD_ABI_VERSION: u32 = 1;

/// What became of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum hd_status {
    /// Done.
    HD_OK = 0,
    /// A pointer is NULL that must not be.
    HD_ERROR_NULL = 1,
    /// A count, a length or a stride is wrong.
    HD_ERROR_SIZE = 2,
    /// A pointer is not aligned as it must be.
    HD_ERROR_ALIGNMENT = 3,
    /// A number is NaN, infinite or out of range, an index too.
    HD_ERROR_VALUE = 4,
    /// A structure's struct_size, or a blob, is of a version that this library does not know.
    HD_ERROR_VERSION = 5,
    /// A blob is none, is truncated or is damaged.
    HD_ERROR_BLOB = 6,
    /// There is more than a tree or a scene can hold.
    HD_ERROR_LIMIT = 7,
    /// A mistake in this library. All handles can be used as before.
    HD_ERROR_INTERNAL = 8,
}

use hd_status::*;

/// A status, and what exactly is wrong.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) status: hd_status,
    pub(crate) message: String,
}

impl Failure {
    pub(crate) fn new(status: hd_status, message: impl Into<String>) -> Self {
        Self { status, message: message.into() }
    }

    /// The same, with what is wrong of several: "item", and its index.
    pub(crate) fn of(self, what: &str, number: usize) -> Self {
        Self { message: format!("{what} {number}: {}", self.message), ..self }
    }

    fn of_panic(panic: Box<dyn Any + Send>) -> Self {
        let said = panic.downcast_ref::<&str>().copied().or_else(|| panic.downcast_ref::<String>().map(String::as_str));
        let failure = Self::new(HD_ERROR_INTERNAL, format!("internal error: {}", said.unwrap_or("no message")));
        // Whatever it was thrown with could panic again when it is dropped.
        std::mem::forget(panic);
        failure
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let status = match error {
            Error::TooManyPrimitives { .. } | Error::InvalidTree(InvalidTree::TooLarge { .. }) => HD_ERROR_LIMIT,
            Error::InvalidScene(
                InvalidScene::TooManyItems { .. } | InvalidScene::TooManyPaths { .. } | InvalidScene::TooDeep { .. },
            ) => HD_ERROR_LIMIT,
            Error::InvalidScene(_) | Error::InvalidMesh(_) | Error::Refit(_) => HD_ERROR_VALUE,
            Error::InvalidTree(InvalidTree::BadKeys { .. }) => HD_ERROR_VALUE,
            Error::Misaligned { .. } => HD_ERROR_ALIGNMENT,
            Error::WrongEndianness | Error::UnsupportedVersion { .. } => HD_ERROR_VERSION,
            _ => HD_ERROR_BLOB,
        };
        Self::new(status, error.to_string())
    }
}

/// Room for a message and the zero behind it.
const ROOM: usize = 512;

thread_local! {
    /// Always at the same place, so that its address may be taken before the call that fails, as where both are
    /// arguments of printf.
    static LAST_ERROR: RefCell<[u8; ROOM]> = const { RefCell::new([0; ROOM]) };
}

/// Makes this the thread's message, cut off where the room ends.
fn keep(message: &str) {
    let end = message.char_indices().map(|(place, char)| place + char.len_utf8()).take_while(|&end| end < ROOM).last();
    let message = &message[..end.unwrap_or(0)];
    // A thread that is ending has no message any more.
    let _ = LAST_ERROR.try_with(|last| {
        let mut last = last.borrow_mut();
        last[..message.len()].copy_from_slice(message.as_bytes());
        last[message.len()] = 0;
    });
}

/// Runs `work` for a caller in C. Its failure or panic becomes a status, and the thread's message.
pub(crate) fn guard(work: impl FnOnce() -> Result<(), Failure>) -> hd_status {
    let failure = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => return HD_OK,
        Ok(Err(failure)) => failure,
        Err(panic) => Failure::of_panic(panic),
    };
    keep(&failure.message);
    failure.status
}

/// The HD_ABI_VERSION of this library. A program works with it if its own is the same.
#[unsafe(no_mangle)]
pub extern "C" fn hd_abi_version() -> u32 {
    HD_ABI_VERSION
}

/// What was wrong in the last call of this thread that failed: a sentence in English, in UTF-8; empty if none failed.
/// It can be read until the thread's next call that fails, and belongs to the library.
#[unsafe(no_mangle)]
pub extern "C" fn hd_last_error() -> *const c_char {
    LAST_ERROR.try_with(|last| last.borrow().as_ptr().cast()).unwrap_or(c"".as_ptr())
}

/// The name of a status, such as "HD_ERROR_NULL"; of another number "unknown status".
#[unsafe(no_mangle)]
pub extern "C" fn hd_status_name(status: i32) -> *const c_char {
    let name: &CStr = match status {
        0 => c"HD_OK",
        1 => c"HD_ERROR_NULL",
        2 => c"HD_ERROR_SIZE",
        3 => c"HD_ERROR_ALIGNMENT",
        4 => c"HD_ERROR_VALUE",
        5 => c"HD_ERROR_VERSION",
        6 => c"HD_ERROR_BLOB",
        7 => c"HD_ERROR_LIMIT",
        8 => c"HD_ERROR_INTERNAL",
        _ => c"unknown status",
    };
    name.as_ptr()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last_error() -> String {
        // SAFETY: the message is there until the next failure, which this thread makes after it was copied.
        unsafe { CStr::from_ptr(hd_last_error()) }.to_str().unwrap().to_owned()
    }

    #[test]
    fn panics_become_a_status() {
        assert_eq!(guard(|| panic!("deliberately, {}", 7)), HD_ERROR_INTERNAL);
        assert_eq!(last_error(), "internal error: deliberately, 7");
        assert_eq!(guard(|| std::panic::panic_any(7)), HD_ERROR_INTERNAL);
        assert_eq!(last_error(), "internal error: no message");
    }

    #[test]
    fn every_thread_has_its_own_message() {
        assert_eq!(guard(|| Err(Failure::new(HD_ERROR_SIZE, "mine"))), HD_ERROR_SIZE);
        std::thread::spawn(|| {
            assert_eq!(last_error(), "");
            guard(|| Err(Failure::new(HD_ERROR_VALUE, "the other's")));
            assert_eq!(last_error(), "the other's");
        })
        .join()
        .unwrap();
        assert_eq!(guard(|| Ok(())), HD_OK);
        assert_eq!(last_error(), "mine");
    }

    #[test]
    fn messages_are_where_they_were_and_end() {
        let before = hd_last_error();
        guard(|| Err(Failure::new(HD_ERROR_VALUE, "short")));
        assert_eq!((before, last_error().as_str()), (hd_last_error(), "short"));
        // Two bytes each, and one before: the last does not fit as a whole.
        guard(|| Err(Failure::new(HD_ERROR_VALUE, format!("-{}", "é".repeat(400)))));
        assert_eq!(last_error(), format!("-{}", "é".repeat(255)));
        guard(|| Err(Failure::new(HD_ERROR_VALUE, "")));
        assert_eq!(last_error(), "");
    }

    #[test]
    fn names_are_those_of_the_statuses() {
        for status in [HD_OK, HD_ERROR_NULL, HD_ERROR_SIZE, HD_ERROR_ALIGNMENT, HD_ERROR_VALUE, HD_ERROR_VERSION]
            .into_iter()
            .chain([HD_ERROR_BLOB, HD_ERROR_LIMIT, HD_ERROR_INTERNAL])
        {
            // SAFETY: names are constants.
            let name = unsafe { CStr::from_ptr(hd_status_name(status as i32)) };
            assert_eq!(name.to_str().unwrap(), format!("{status:?}"));
        }
    }
}
