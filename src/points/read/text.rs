//! Points as text, one a line: x y z [block] volume, or x y area.

use super::source::{Source, integer, real, shown, words};
use super::{Cloud, is_coordinate, is_volume};
use crate::error::Result;
use crate::memory;
use crate::points::Points;

/// Columns of a file, by their number.
fn columns(count: usize) -> Option<&'static [&'static str]> {
    match count {
        3 => Some(&["x", "y", "area"]),
        4 => Some(&["x", "y", "z", "volume"]),
        5 => Some(&["x", "y", "z", "block", "volume"]),
        _ => None,
    }
}

pub(super) fn read(source: &Source) -> Result<Points> {
    let mut cloud = Cloud::default();
    let mut known: Option<&[&str]> = None;
    let mut named = false;
    for (line, text) in source.lines() {
        let end = text.iter().position(|byte| matches!(byte, b'#' | b'!' | b'%'));
        let text = &text[..end.unwrap_or(text.len())];
        let count = words(text).count();
        if count == 0 {
            continue;
        }
        // The names of the columns may stand above them.
        if known.is_none() && !named && words(text).all(is_name) {
            named = true;
            continue;
        }
        let Some(columns) = known.or_else(|| columns(count)) else {
            return source.flaw(
                line,
                format_args!(
                    "expected x y z volume, x y z block volume, or x y area, found {count} \
                     columns: {}",
                    shown(text)
                ),
            );
        };
        known = Some(columns);
        if count != columns.len() {
            return source.flaw(
                line,
                format_args!(
                    "expected {} columns as in the lines before, found {count}: {}",
                    columns.len(),
                    shown(text)
                ),
            );
        }
        let mut place = [0.0; 3];
        for ((word, &column), axis) in words(text).zip(columns).zip(0..) {
            let expected = |what: &str| {
                source
                    .flaw(line, format_args!("expected {what} as {column}, found {}", shown(word)))
            };
            match column {
                "block" => match integer(word) {
                    Some(block) => cloud.put_into_block(block, cloud.volumes.len())?,
                    None => return expected("a whole number"),
                },
                "volume" | "area" => match real(word).filter(|&value| is_volume(value)) {
                    Some(volume) => memory::push(&mut cloud.volumes, volume, "volumes")?,
                    None => return expected("a positive number"),
                },
                _ => match real(word).filter(|&value| is_coordinate(value)) {
                    Some(value) => place[axis] = value,
                    None => return expected("a number"),
                },
            }
        }
        for value in place {
            memory::push(&mut cloud.coordinates, value, "coordinates")?;
        }
        memory::push(&mut cloud.lines, line as u32, "lines")?;
    }
    cloud.into_points(source, if known.is_some_and(|columns| columns.len() == 3) { 2 } else { 3 })
}

/// Neither a number nor what computers write where a number fails them.
fn is_name(word: &[u8]) -> bool {
    let number = str::from_utf8(word).is_ok_and(|text| text.parse::<f64>().is_ok());
    word[0].is_ascii_alphabetic() && !number
}
