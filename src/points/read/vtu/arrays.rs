//! The numbers of arrays: as text, base64 or raw, packed by ZLib or not.

use std::cell::Cell;

use miniz_oxide::inflate::decompress_slice_iter_to_slice;

use super::header::{Array, Data, Document, Number};
use crate::error::Result;
use crate::memory;
use crate::points::read::source::{Source, integer, real, shown, words};

/// ZLib packs at most about a thousand bytes into one.
const MOST_PACKED: u64 = 1040;

/// What a file without compression holds at most: each byte a number.
const MOST_PLAIN: u64 = size_of::<f64>() as u64;

pub(super) struct Decoder<'a> {
    source: &'a Source,
    document: &'a Document<'a>,
    /// Bytes of numbers that the file may still give: what stands in it once must not count many times.
    budget: Cell<u64>,
}

impl<'a> Decoder<'a> {
    pub(super) fn new(source: &'a Source, document: &'a Document<'a>) -> Self {
        let each = if document.compressed { MOST_PACKED } else { MOST_PLAIN };
        let budget = Cell::new((source.bytes.len() as u64).saturating_mul(each));
        Self { source, document, budget }
    }

    /// Takes the room of some numbers out of what the file may give.
    fn spend(&self, array: &Array, numbers: u64) -> Result<()> {
        let needed = numbers.saturating_mul(size_of::<f64>() as u64);
        match self.budget.get().checked_sub(needed) {
            Some(left) => {
                self.budget.set(left);
                Ok(())
            }
            None => array.flaw(
                self.source,
                "expected no more numbers than the file has room for, found the same bytes used again",
            ),
        }
    }

    /// The numbers of an array; `count`: how many there must be, if that is known.
    pub(super) fn reals(&self, array: &Array, count: Option<u64>) -> Result<Vec<f64>> {
        let Data::Text(text) = &array.data else {
            return self.numbers(array, count, |bytes| match array.kind {
                Number::Float(4) => f32::from_bits(unsigned(bytes) as u32).into(),
                Number::Float(_) => f64::from_bits(unsigned(bytes)),
                Number::Signed(_) => signed(bytes) as f64,
                Number::Unsigned(_) => unsigned(bytes) as f64,
            });
        };
        self.written(array, text, count, "a number", real)
    }

    /// The whole numbers of an array; `count`: how many there must be, if that is known.
    pub(super) fn integers(&self, array: &Array, count: Option<u64>) -> Result<Vec<i64>> {
        if let Number::Float(_) = array.kind {
            return array.flaw(self.source, "expected whole numbers, found floating-point ones");
        }
        let Data::Text(text) = &array.data else {
            return self.numbers(array, count, |bytes| match array.kind {
                Number::Signed(_) => signed(bytes),
                // More than an i64 holds is no index of anything.
                _ => i64::try_from(unsigned(bytes)).unwrap_or(i64::MAX),
            });
        };
        self.written(array, text, count, "a whole number", integer)
    }

    /// Numbers as text.
    fn written<T>(
        &self,
        array: &Array,
        text: &[u8],
        count: Option<u64>,
        what: &str,
        read: impl Fn(&[u8]) -> Option<T>,
    ) -> Result<Vec<T>> {
        let mut numbers = Vec::new();
        for word in words(text) {
            let Some(number) = read(word) else {
                return array
                    .flaw(self.source, format_args!("expected {what}, found {}", shown(word)));
            };
            memory::push(&mut numbers, number, "an array")?;
        }
        self.check_count(array, count, numbers.len() as u64)?;
        Ok(numbers)
    }

    /// Binary numbers; `read` takes the bytes of one, the lowest first.
    fn numbers<T>(
        &self,
        array: &Array,
        count: Option<u64>,
        read: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>> {
        let size = array.kind.bytes();
        let expected = count.map(|count| count.saturating_mul(size as u64));
        let mut bytes = self.bytes(array, expected)?;
        if !bytes.len().is_multiple_of(size) {
            return array.flaw(
                self.source,
                format_args!("expected numbers of {size} bytes, found {} bytes", bytes.len()),
            );
        }
        self.check_count(array, count, (bytes.len() / size) as u64)?;
        self.spend(array, (bytes.len() / size) as u64)?;
        if self.document.big_endian {
            bytes.chunks_exact_mut(size).for_each(<[u8]>::reverse);
        }
        memory::collected(bytes.chunks_exact(size).map(read), "an array")
    }

    fn check_count(&self, array: &Array, expected: Option<u64>, found: u64) -> Result<()> {
        match expected {
            Some(expected) if expected != found => {
                array.flaw(self.source, format_args!("expected {expected} numbers, found {found}"))
            }
            _ => Ok(()),
        }
    }

    /// The bytes of an array, unpacked.
    fn bytes(&self, array: &Array, expected: Option<u64>) -> Result<Vec<u8>> {
        let (bytes, base64) = match &array.data {
            Data::Text(text) | Data::Base64(text) => (&text[..], true),
            Data::Appended(offset) => match &self.document.appended {
                Some(appended) => {
                    let from = usize::try_from(*offset).ok();
                    let Some(rest) = from.and_then(|from| appended.bytes.get(from..)) else {
                        return array.flaw(
                            self.source,
                            format_args!(
                                "expected an offset up to {}, found {offset}",
                                appended.bytes.len()
                            ),
                        );
                    };
                    (rest, appended.base64)
                }
                None => return array.flaw(self.source, "expected AppendedData, found none"),
            },
        };
        let mut stream = Stream { rest: bytes, base64, left: [0; 3], left_count: 0 };
        if base64 && bytes.trim_ascii().is_empty() {
            return Ok(Vec::new());
        }
        let decoded = self.unpack(&mut stream, expected)?;
        decoded.map_or_else(|text| array.flaw(self.source, text), Ok)
    }

    /// Reads what leads an array and then the array, or says what is wrong with it.
    fn unpack(
        &self,
        stream: &mut Stream,
        expected: Option<u64>,
    ) -> Result<std::result::Result<Vec<u8>, String>> {
        let cut = || Ok(Err(String::from("expected more bytes, found the end of the data")));
        let Some(first) = self.lead(stream)? else { return cut() };
        let another = |found: u64| {
            let expected = expected.filter(|&expected| expected != found)?;
            Some(format!("expected {expected} bytes, found {found}"))
        };
        if !self.document.compressed {
            if let Some(text) = another(first) {
                return Ok(Err(text));
            }
            return Ok(match stream.take(first)? {
                Some(bytes) => Ok(bytes),
                None => Err(format!("expected {first} bytes, found fewer")),
            });
        }
        let (Some(block), Some(last)) = (self.lead(stream)?, self.lead(stream)?) else {
            return cut();
        };
        let rest = stream.rest.len() as u64;
        let whole = if last == 0 { first } else { first.saturating_sub(1) };
        let total = whole.checked_mul(block).and_then(|total| total.checked_add(last));
        let total = if first == 0 { Some(0) } else { total };
        let Some(total) =
            total.filter(|&it| first <= rest && it <= rest.saturating_mul(MOST_PACKED))
        else {
            let text = "expected as much as the file has room for, found";
            return Ok(Err(format!("{text} {first} blocks of {block} bytes")));
        };
        if let Some(text) = another(total) {
            return Ok(Err(text));
        }
        let mut sizes = memory::reserved(first as usize, "an array")?;
        for _ in 0..first {
            let Some(size) = self.lead(stream)? else { return cut() };
            sizes.push(size);
        }
        let mut bytes = memory::filled(0, total as usize, "an array")?;
        let mut empty = &mut bytes[..];
        for (place, &size) in sizes.iter().enumerate() {
            let Some(packed) = stream.take(size)? else { return cut() };
            let here = if place as u64 == whole { last } else { block };
            let (target, rest) = empty.split_at_mut(here as usize);
            let unpacked =
                decompress_slice_iter_to_slice(target, std::iter::once(&packed[..]), true, false);
            if unpacked != Ok(target.len()) {
                return Ok(Err(format!(
                    "expected {here} bytes packed by ZLib in block {place}, found something else"
                )));
            }
            empty = rest;
        }
        Ok(Ok(bytes))
    }

    /// One of the numbers that lead an array.
    fn lead(&self, stream: &mut Stream) -> Result<Option<u64>> {
        Ok(stream.take(self.document.header_bytes as u64)?.map(|mut bytes| {
            if self.document.big_endian {
                bytes.reverse();
            }
            unsigned(&bytes)
        }))
    }
}

/// The bytes of an array, one after the other.
struct Stream<'a> {
    rest: &'a [u8],
    base64: bool,
    /// Decoded, but not yet taken.
    left: [u8; 3],
    left_count: usize,
}

impl Stream<'_> {
    /// The next bytes; none where there are not so many, or what should be base64 is not.
    fn take(&mut self, count: u64) -> Result<Option<Vec<u8>>> {
        let Some(count) = usize::try_from(count).ok().filter(|&count| count <= self.most()) else {
            return Ok(None);
        };
        if !self.base64 {
            let (taken, rest) = self.rest.split_at(count);
            self.rest = rest;
            return memory::copied(taken, "an array").map(Some);
        }
        let mut taken = memory::reserved(count, "an array")?;
        while taken.len() < count {
            if self.left_count == 0 && !self.decode() {
                return Ok(None);
            }
            let now = self.left_count.min(count - taken.len());
            taken.extend_from_slice(&self.left[..now]);
            self.left.copy_within(now.., 0);
            self.left_count -= now;
        }
        Ok(Some(taken))
    }

    /// Bytes that may still come.
    fn most(&self) -> usize {
        let encoded = if self.base64 { 3 } else { 4 };
        self.left_count + self.rest.len() / 4 * encoded + self.rest.len() % 4
    }

    /// Decodes the next four letters. Padding may stand where a piece ends, not only at the end of
    /// all: what leads an array can be encoded by itself.
    fn decode(&mut self) -> bool {
        let (mut word, mut letters, mut padding) = (0_u32, 0, 0);
        while letters < 4 {
            let Some((&letter, rest)) = self.rest.split_first() else { return false };
            self.rest = rest;
            let value = match letter {
                b'A'..=b'Z' => letter - b'A',
                b'a'..=b'z' => letter - b'a' + 26,
                b'0'..=b'9' => letter - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                b'=' if letters >= 2 => {
                    padding += 1;
                    0
                }
                _ if letter.is_ascii_whitespace() => continue,
                _ => return false,
            };
            if padding > 0 && letter != b'=' {
                return false;
            }
            word = word << 6 | u32::from(value);
            letters += 1;
        }
        let [_, bytes @ ..] = word.to_be_bytes();
        (self.left, self.left_count) = (bytes, 3 - padding);
        true
    }
}

/// Bytes of a number, the lowest first.
fn unsigned(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte))
}

/// The same with a sign.
fn signed(bytes: &[u8]) -> i64 {
    let unused = 64 - 8 * bytes.len() as u32;
    (unsigned(bytes) << unused) as i64 >> unused
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(text: &str, count: u64) -> Option<Vec<u8>> {
        let mut stream =
            Stream { rest: text.as_bytes(), base64: true, left: [0; 3], left_count: 0 };
        stream.take(count).unwrap()
    }

    #[test]
    fn base64_is_read_with_padding_within_and_blanks() {
        assert_eq!(decoded("Zm9vYmFy", 6).unwrap(), b"foobar");
        assert_eq!(decoded("Zm9v\n YmE=", 5).unwrap(), b"fooba");
        assert_eq!(decoded("Zg==b29iYXI=", 6).unwrap(), b"foobar");
        for wrong in ["Zm9vYmF", "Zm9v!mFy", "Z===", "Zg=v", ""] {
            assert_eq!(decoded(wrong, 6), None, "{wrong}");
        }
    }

    #[test]
    fn numbers_keep_their_sign() {
        assert_eq!(signed(&[0xfe]), -2);
        assert_eq!(signed(&(-70_000_i32).to_le_bytes()), -70_000);
        assert_eq!(signed(&i64::MIN.to_le_bytes()), i64::MIN);
        assert_eq!(unsigned(&[1, 2]), 513);
    }
}
