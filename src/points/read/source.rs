//! A file in memory, what is wrong with it and where, and the numbers in its text.

use std::fmt::Display;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::{Error, Result};
use crate::memory;

/// Letters of a file that a message shows at most.
const SHOWN: usize = 40;

/// The contents of a file and its name for messages.
pub(super) struct Source {
    name: String,
    pub(super) bytes: Vec<u8>,
}

impl Source {
    /// Reads a whole file. What is no file, such as a directory or a device, is refused.
    pub(super) fn load(path: &Path) -> Result<Self> {
        let name = path.display().to_string();
        let failed = |reason| Error::Io(format!("'{name}' cannot be read: {reason}"));
        // Opening a pipe would wait for somebody to write to it.
        let kind = std::fs::metadata(path).map_err(failed)?;
        if !kind.is_file() {
            return Err(Error::Io(format!("'{name}' is not a file")));
        }
        let mut file = File::open(path).map_err(failed)?;
        let size = file.metadata().map_err(failed)?.len();
        let size = usize::try_from(size).unwrap_or(usize::MAX);
        let mut bytes = memory::filled(0, size, "the contents of a file")?;
        file.read_exact(&mut bytes).map_err(failed)?;
        if bytes.starts_with(b"\xef\xbb\xbf") {
            // The mark of UTF-8, which says nothing.
            bytes.drain(..3);
        }
        Ok(Self { name, bytes })
    }

    /// The file is not what it should be, at a line of it; from 1, 0 where the file has none.
    pub(super) fn flaw<T>(&self, line: usize, text: impl Display) -> Result<T> {
        Err(Error::Format(format!("{}: {text}", self.place(line))))
    }

    /// The file as a whole is not what it should be.
    pub(super) fn flaw_of_all<T>(&self, text: impl Display) -> Result<T> {
        self.flaw(0, text)
    }

    /// A line of the file asks for what is not offered.
    pub(super) fn unsupported<T>(&self, line: usize, text: impl Display) -> Result<T> {
        Err(Error::Unsupported(format!("{}: {text}", self.place(line))))
    }

    fn place(&self, line: usize) -> String {
        let at = if line == 0 { String::new() } else { format!(", line {line}") };
        format!("'{}'{at}", self.name)
    }

    /// Line (from 1) of a byte.
    pub(super) fn line_of(&self, place: usize) -> usize {
        let before = &self.bytes[..place.min(self.bytes.len())];
        1 + before.iter().filter(|&&byte| byte == b'\n').count()
    }

    /// The lines with their numbers from 1, without blanks around them.
    pub(super) fn lines(&self) -> impl Iterator<Item = (usize, &[u8])> {
        let lines = self.bytes.split(|&byte| byte == b'\n').enumerate();
        lines.map(|(place, line)| (place + 1, line.trim_ascii()))
    }
}

/// What blanks and commas separate.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|byte| byte.is_ascii_whitespace() || *byte == b',').filter(|word| !word.is_empty())
}

/// A piece of the file for a message: cut, and without letters that are none.
pub(super) fn shown(piece: &[u8]) -> String {
    let piece = piece.trim_ascii();
    let text = String::from_utf8_lossy(&piece[..piece.len().min(4 * SHOWN)]);
    let mut cut = String::new();
    for letter in text.chars().take(SHOWN) {
        if letter.is_control() {
            cut.extend(letter.escape_debug());
        } else {
            cut.push(letter);
        }
    }
    let dots = if text.chars().count() > SHOWN { "..." } else { "" };
    format!("'{cut}{dots}'")
}

/// A whole number.
pub(super) fn integer(word: &[u8]) -> Option<i64> {
    str::from_utf8(word).ok()?.parse().ok()
}

/// A finite number, in Fortran's forms too: 1.5d-3, 1.5-103.
pub(super) fn real(word: &[u8]) -> Option<f64> {
    const LONGEST: usize = 64;
    let text = str::from_utf8(word).ok()?;
    let value = text.parse().ok().or_else(|| {
        let mut letters = [0; LONGEST];
        let mut count = 0;
        for (place, &byte) in word.iter().enumerate() {
            let follows_digit = place > 0 && matches!(word[place - 1], b'0'..=b'9' | b'.');
            if matches!(byte, b'+' | b'-') && follows_digit {
                *letters.get_mut(count)? = b'e';
                count += 1;
            }
            *letters.get_mut(count)? = if matches!(byte, b'd' | b'D') { b'e' } else { byte };
            count += 1;
        }
        str::from_utf8(&letters[..count]).ok()?.parse().ok()
    });
    value.filter(|value: &f64| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_in_the_forms_of_c_and_fortran() {
        for (word, value) in [
            ("1.5", 1.5),
            ("-.5", -0.5),
            ("2.", 2.0),
            ("+1e3", 1000.0),
            ("1.5D-3", 1.5e-3),
            ("1.d0", 1.0),
            ("1.5-103", 1.5e-103),
            ("-2+10", -2e10),
        ] {
            assert_eq!(real(word.as_bytes()), Some(value), "{word}");
        }
        for word in ["", "x", "nan", "inf", "1e999", "1,5", "--1", "1e", "\u{b9}", &"9".repeat(400)]
        {
            assert_eq!(real(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn a_message_shows_little_of_what_is_wrong_and_no_control_characters() {
        assert_eq!(shown(b" 1.x\r"), "'1.x'");
        assert_eq!(shown(b"a\x1b\xffb"), "'a\\u{1b}\u{fffd}b'");
        assert_eq!(shown(&[b'x'; 1000]).len(), SHOWN + 5);
    }
}
