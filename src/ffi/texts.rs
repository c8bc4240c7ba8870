//! Texts of tables, each ending in NUL, laid out when the library is compiled.

use std::ffi::c_char;

/// Defines a static with the text of every entry of a table, one after the other.
macro_rules! table_of_texts {
    ($name:ident, $count:expr, $index:ident => $text:expr) => {
        static $name: [u8; {
            let (mut total, mut $index) = (0, 0);
            while $index < $count {
                total += $text.len() + 1;
                $index += 1;
            }
            total
        }] = {
            let mut bytes = [0; _];
            let (mut place, mut $index) = (0, 0);
            while $index < $count {
                let text = $text.as_bytes();
                let mut letter = 0;
                while letter < text.len() {
                    bytes[place] = text[letter];
                    place += 1;
                    letter += 1;
                }
                place += 1;
                $index += 1;
            }
            bytes
        };
    };
}
pub(super) use table_of_texts;

/// The text of the entry `index`, or NULL when there is no such entry.
pub(super) fn entry(texts: &'static [u8], index: i64) -> *const c_char {
    let found = usize::try_from(index).ok().and_then(|index| {
        texts.split_inclusive(|&byte| byte == 0).nth(index).map(|text| text.as_ptr())
    });
    found.map_or(std::ptr::null(), |text| text.cast())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_found_and_others_are_not() {
        const WORDS: [&str; 3] = ["one", "", "three"];
        table_of_texts!(TEXTS, WORDS.len(), k => WORDS[k]);
        for (index, word) in WORDS.iter().enumerate() {
            // SAFETY: the table holds texts that end in NUL.
            let text = unsafe { std::ffi::CStr::from_ptr(entry(&TEXTS, index as i64)) };
            assert_eq!(text.to_str(), Ok(*word));
        }
        assert!(entry(&TEXTS, 3).is_null() && entry(&TEXTS, -1).is_null());
    }
}
