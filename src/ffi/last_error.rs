//! The text of this thread's last failure, in a buffer that is part of the thread.
//!
//! It is fixed in size and has no destructor: failing for want of memory needs none to be told, and
//! the pointer given to the host holds as long as the thread.

use std::cell::Cell;
use std::ffi::c_char;
use std::fmt::{self, Display, Write};

const CAPACITY: usize = 1024;
const ELLIPSIS: &[u8] = b"...";

thread_local! {
    static LAST: Cell<[u8; CAPACITY]> = const { Cell::new([0; CAPACITY]) };
}

/// The last failure on the calling thread as one line of text: function, argument, value, limit,
/// what to do; "" when nothing has failed. A later success leaves it. The buffer belongs to the
/// thread: the next failure overwrites it, the end of the thread ends it. Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn perion_last_error() -> *const c_char {
    LAST.with(|last| last.as_ptr().cast_const().cast())
}

/// Keeps "function: text" as the last failure of this thread, shortened with "..." if need be.
pub(crate) fn set(function: &str, text: impl Display) {
    let mut line = Line { bytes: [0; CAPACITY], length: 0, boundary: 0, full: false };
    // The only failure is a full line, which shows itself by its ellipsis.
    let _ = write!(line, "{function}: {text}");
    LAST.set(line.bytes);
}

/// Text that ends in NUL however much is written; a NUL within it is replaced.
struct Line {
    bytes: [u8; CAPACITY],
    length: usize,
    /// The longest prefix of whole characters that leaves room for the ellipsis.
    boundary: usize,
    full: bool,
}

impl Line {
    fn push(&mut self, character: char) -> fmt::Result {
        let end = self.length + character.len_utf8();
        if self.full || end >= CAPACITY {
            self.shorten();
            return Err(fmt::Error);
        }
        character.encode_utf8(&mut self.bytes[self.length..end]);
        self.length = end;
        if end + ELLIPSIS.len() < CAPACITY {
            self.boundary = end;
        }
        Ok(())
    }

    fn shorten(&mut self) {
        let (_, rest) = self.bytes.split_at_mut(self.boundary);
        rest.fill(0);
        rest[..ELLIPSIS.len()].copy_from_slice(ELLIPSIS);
        self.full = true;
    }
}

impl Write for Line {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.chars().try_for_each(|character| match character {
            '\0' => self.push(char::REPLACEMENT_CHARACTER),
            _ => self.push(character),
        })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::ffi::CStr;

    /// What the host would read.
    pub(crate) fn text() -> String {
        // SAFETY: the buffer ends in NUL and outlives this call on the same thread.
        unsafe { CStr::from_ptr(perion_last_error()) }.to_str().unwrap().to_owned()
    }

    #[test]
    fn a_thread_on_which_nothing_failed_has_no_text() {
        set("perion_here", "a failure");
        assert_eq!(std::thread::spawn(text).join().unwrap(), "");
        assert_eq!(text(), "perion_here: a failure");
    }

    #[test]
    fn a_text_that_just_fits_is_whole_and_one_byte_more_is_shortened() {
        let longest = "x".repeat(CAPACITY - 1 - "f: ".len());
        set("f", &longest);
        assert_eq!(text(), format!("f: {longest}"));

        set("f", format!("{longest}x"));
        assert_eq!(text().len(), CAPACITY - 1);
        assert!(text().ends_with("xxx..."));
    }

    #[test]
    fn a_long_text_is_cut_between_characters() {
        for shift in 0..4 {
            set(&"f".repeat(1 + shift), "\u{1F980}".repeat(CAPACITY));
            let cut = text();
            assert!(cut.ends_with("\u{1F980}..."), "{cut}");
            assert!(cut.len() > CAPACITY - 1 - 4 && cut.len() < CAPACITY);
        }
    }

    #[test]
    fn a_nul_within_the_text_does_not_hide_the_rest() {
        set("f", "before\0after");
        assert_eq!(text(), "f: before\u{FFFD}after");
    }

    #[test]
    fn a_text_that_ignores_a_full_buffer_writes_no_more() {
        struct Stubborn;
        impl Display for Stubborn {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                let _ = formatter.write_str(&"x".repeat(2 * CAPACITY));
                let _ = formatter.write_str("more");
                Ok(())
            }
        }
        set("f", Stubborn);
        assert!(text().ends_with("xxx..."));
    }
}
