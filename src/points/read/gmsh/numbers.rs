//! The numbers of a MSH file, one after the other, be they text or binary.

use std::fmt::Display;

use crate::error::Result;
use crate::points::read::source::{Source, integer, real, shown};

/// A place in the file.
pub(super) struct Reader<'a> {
    source: &'a Source,
    rest: &'a [u8],
    /// Line of what was read last, from 1; 0 in a binary file.
    line: usize,
    /// Line where the rest begins.
    next_line: usize,
    binary: bool,
}

impl<'a> Reader<'a> {
    pub(super) fn new(source: &'a Source) -> Self {
        Self { source, rest: &source.bytes, line: 1, next_line: 1, binary: false }
    }

    /// What follows is binary where the format allows it.
    pub(super) fn read_binary(&mut self) {
        (self.binary, self.next_line, self.line) = (true, 0, 0);
    }

    pub(super) fn source(&self) -> &'a Source {
        self.source
    }

    /// Line of what was read last, from 1; 0 in a binary file.
    pub(super) fn line(&self) -> usize {
        self.line
    }

    pub(super) fn is_binary(&self) -> bool {
        self.binary
    }

    pub(super) fn flaw<T>(&self, text: impl Display) -> Result<T> {
        self.source.flaw(self.line, text)
    }

    pub(super) fn unsupported<T>(&self, text: impl Display) -> Result<T> {
        self.source.unsupported(self.line, text)
    }

    /// The name of the section that begins next; `None` at the end of the file.
    pub(super) fn section(&mut self) -> Result<Option<&'a [u8]>> {
        self.skip_blanks();
        if self.rest.is_empty() {
            return Ok(None);
        }
        let line = self.rest_of_line();
        match line.strip_prefix(b"$") {
            Some(name) => Ok(Some(name)),
            None => self.flaw(format_args!("expected $ and a section, found {}", shown(line))),
        }
    }

    /// Expects the end of a section.
    pub(super) fn end_section(&mut self, name: &[u8]) -> Result<()> {
        self.skip_blanks();
        let line = self.rest_of_line();
        if line.strip_prefix(b"$End") == Some(name) {
            return Ok(());
        }
        let name = shown(name);
        self.flaw(format_args!("expected the end of section {name}, found {}", shown(line)))
    }

    /// Passes over a section.
    pub(super) fn skip_section(&mut self, name: &[u8]) -> Result<()> {
        let from = self.rest;
        while let Some(place) = self.rest.iter().position(|&byte| byte == b'$') {
            self.rest = &self.rest[place + 1..];
            if let Some(rest) = self.rest.strip_prefix(b"End").and_then(|it| it.strip_prefix(name))
            {
                let passed = &from[..from.len() - rest.len()];
                if self.next_line > 0 {
                    self.next_line += passed.iter().filter(|&&byte| byte == b'\n').count();
                }
                self.rest = rest;
                self.rest_of_line();
                return Ok(());
            }
        }
        let name = shown(name);
        self.flaw(format_args!("expected the end of section {name} that begins here, found none"))
    }

    /// What is left of the line, without blanks around it.
    pub(super) fn rest_of_line(&mut self) -> &'a [u8] {
        self.line = self.next_line;
        let end = self.rest.iter().position(|&byte| byte == b'\n');
        let (line, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest.get(1..).unwrap_or(&[]);
        if self.next_line > 0 && end.is_some() {
            self.next_line += 1;
        }
        line.trim_ascii()
    }

    /// A number of things of which each takes at least so many numbers; refused when the file is too
    /// short for them.
    pub(super) fn count(&mut self, what: &str, numbers: u64) -> Result<u64> {
        let count = self.size(what)?;
        self.refuse_more_than_fit(count, what, numbers)?;
        Ok(count)
    }

    /// Refuses a count of things for which the file is too short.
    pub(super) fn refuse_more_than_fit(&self, count: u64, what: &str, numbers: u64) -> Result<()> {
        // As text, a digit and a blank; in binary files no number has less than four bytes.
        let bytes = if self.binary { 4 } else { 2 };
        let needed = count.checked_mul(numbers).and_then(|total| total.checked_mul(bytes));
        // The last digit needs no blank behind it.
        if needed.is_some_and(|needed| needed <= self.rest.len() as u64 + 1) {
            return Ok(());
        }
        self.flaw(format_args!("expected {what} that the file has room for, found {count}"))
    }

    /// A number that is never negative, of eight bytes in binary files.
    pub(super) fn size(&mut self, what: &str) -> Result<u64> {
        if self.binary {
            return Ok(u64::from_le_bytes(self.bytes(what)?));
        }
        self.unsigned(what)
    }

    /// A number of a node or element of version 2, of four bytes in binary files.
    pub(super) fn tag(&mut self, what: &str) -> Result<u64> {
        if self.binary {
            return Ok(u32::from_le_bytes(self.bytes(what)?).into());
        }
        self.unsigned(what)
    }

    /// A whole number, of four bytes in binary files.
    pub(super) fn int(&mut self, what: &str) -> Result<i64> {
        if self.binary {
            return Ok(i32::from_le_bytes(self.bytes(what)?).into());
        }
        let word = self.word();
        match integer(word) {
            Some(number) => Ok(number),
            None => self.flaw(format_args!("expected {what}, found {}", found(word))),
        }
    }

    /// A finite number.
    pub(super) fn real(&mut self, what: &str) -> Result<f64> {
        if self.binary {
            return Ok(f64::from_le_bytes(self.bytes(what)?));
        }
        let word = self.word();
        match real(word) {
            Some(number) => Ok(number),
            None => self.flaw(format_args!("expected {what}, found {}", found(word))),
        }
    }

    fn unsigned(&mut self, what: &str) -> Result<u64> {
        let word = self.word();
        match integer(word).and_then(|number| u64::try_from(number).ok()) {
            Some(number) => Ok(number),
            None => self.flaw(format_args!(
                "expected {what}, whole and not negative, found {}",
                found(word)
            )),
        }
    }

    /// What stands up to the next blank.
    fn word(&mut self) -> &'a [u8] {
        self.skip_blanks();
        self.line = self.next_line;
        let end = self.rest.iter().position(u8::is_ascii_whitespace);
        let (word, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest;
        word
    }

    fn bytes<const N: usize>(&mut self, what: &str) -> Result<[u8; N]> {
        match self.rest.split_first_chunk() {
            Some((bytes, rest)) => {
                self.rest = rest;
                Ok(*bytes)
            }
            None => self.flaw(format_args!("expected {what}, found the end of the file")),
        }
    }

    fn skip_blanks(&mut self) {
        while let Some((byte, rest)) = self.rest.split_first() {
            if !byte.is_ascii_whitespace() {
                break;
            }
            if *byte == b'\n' && self.next_line > 0 {
                self.next_line += 1;
            }
            self.rest = rest;
        }
    }
}

/// A word for a message; none is left at the end of the file.
fn found(word: &[u8]) -> String {
    if word.is_empty() { "the end of the file".into() } else { shown(word) }
}
