//! The status numbers of the C interface. They are part of the ABI: never reused, never renumbered.

use std::ffi::{CStr, c_char};

use crate::error::Error;

/// What every fallible call returns: PERION_OK, or the kind of failure; perion_last_error() has the
/// text. Since 0.1.
#[allow(non_camel_case_types)] // the name in C
pub type perion_status = i32;

/// The call did what it says.
pub const PERION_OK: perion_status = 0;
/// A pointer that must not be NULL is NULL.
pub const PERION_ERROR_NULL: perion_status = 1;
/// A value, a count, a name or a combination of them is not allowed; nothing was changed.
pub const PERION_ERROR_ARGUMENT: perion_status = 2;
/// The call does not fit the state of the handle, or the handle is in use by another call.
pub const PERION_ERROR_STATE: perion_status = 3;
/// The memory that the call needs could not be had; the handle is unchanged.
pub const PERION_ERROR_MEMORY: perion_status = 4;
/// A file could not be read or written.
pub const PERION_ERROR_IO: perion_status = 5;
/// A file was read, but what is in it is not understood.
pub const PERION_ERROR_FORMAT: perion_status = 6;
/// A computed quantity is not finite; the text names the point.
pub const PERION_ERROR_NUMERIC: perion_status = 7;
/// An iteration did not converge; the state is that of the last completed step.
pub const PERION_ERROR_CONVERGENCE: perion_status = 8;
/// A callback asked to stop.
pub const PERION_ERROR_INTERRUPTED: perion_status = 9;
/// The request makes sense but is not offered; the text says what is.
pub const PERION_ERROR_UNSUPPORTED: perion_status = 10;
/// An earlier internal error left the handle unusable: get and destroy still work.
pub const PERION_ERROR_POISONED: perion_status = 11;
/// A defect of the library: please report the text.
pub const PERION_ERROR_INTERNAL: perion_status = 12;

/// The number that stands for `error`.
pub(crate) fn status_of(error: &Error) -> perion_status {
    match error {
        Error::Argument(_) => PERION_ERROR_ARGUMENT,
        Error::State(_) => PERION_ERROR_STATE,
        Error::Memory { .. } => PERION_ERROR_MEMORY,
        Error::Io(_) => PERION_ERROR_IO,
        Error::Format(_) => PERION_ERROR_FORMAT,
        Error::Numeric(_) => PERION_ERROR_NUMERIC,
        Error::Convergence(_) => PERION_ERROR_CONVERGENCE,
        Error::Interrupted(_) => PERION_ERROR_INTERRUPTED,
        Error::Unsupported(_) => PERION_ERROR_UNSUPPORTED,
        Error::Internal(_) => PERION_ERROR_INTERNAL,
    }
}

/// Two or three words for a status number, "unknown status" for a number that is none. The text is
/// static: valid for ever, not to be freed. Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn perion_status_string(status: perion_status) -> *const c_char {
    words(status).as_ptr()
}

fn words(status: perion_status) -> &'static CStr {
    match status {
        PERION_OK => c"ok",
        PERION_ERROR_NULL => c"null pointer",
        PERION_ERROR_ARGUMENT => c"invalid argument",
        PERION_ERROR_STATE => c"wrong state",
        PERION_ERROR_MEMORY => c"out of memory",
        PERION_ERROR_IO => c"input or output failed",
        PERION_ERROR_FORMAT => c"file not understood",
        PERION_ERROR_NUMERIC => c"not a finite number",
        PERION_ERROR_CONVERGENCE => c"no convergence",
        PERION_ERROR_INTERRUPTED => c"interrupted by a callback",
        PERION_ERROR_UNSUPPORTED => c"not supported",
        PERION_ERROR_POISONED => c"poisoned handle",
        PERION_ERROR_INTERNAL => c"internal error",
        _ => c"unknown status",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_status_has_words_of_its_own() {
        let mut known = HashSet::from([c"unknown status"]);
        assert!((PERION_OK..=PERION_ERROR_INTERNAL).all(|status| known.insert(words(status))));
    }

    #[test]
    fn a_number_that_is_no_status_is_called_unknown() {
        for status in [-1, PERION_ERROR_INTERNAL + 1, i32::MIN, i32::MAX] {
            // SAFETY: the function returns static C strings.
            let text = unsafe { CStr::from_ptr(perion_status_string(status)) };
            assert_eq!(text, c"unknown status");
        }
    }

    #[test]
    fn an_error_keeps_its_kind_as_a_number() {
        let memory = Error::Memory { bytes: 1, purpose: "a test" };
        assert_eq!(status_of(&memory), PERION_ERROR_MEMORY);
        assert_eq!(status_of(&Error::Internal(String::new())), PERION_ERROR_INTERNAL);
    }
}
