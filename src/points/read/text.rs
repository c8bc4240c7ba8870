//! Points as text, one a line: x y z [block] volume, or x y area; or columns that a first line names.

use super::source::{Source, integer, real, shown, words};
use super::{Cloud, is_coordinate, is_volume};
use crate::error::Result;
use crate::memory;
use crate::points::Points;

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Axis(usize),
    Volume,
    Block,
    /// Of a name that says nothing here.
    Other,
}

/// Names of columns, in small letters, without units.
const NAMES: &[(&str, Column)] = &[
    ("x", Column::Axis(0)),
    ("y", Column::Axis(1)),
    ("z", Column::Axis(2)),
    ("points:0", Column::Axis(0)),
    ("points:1", Column::Axis(1)),
    ("points:2", Column::Axis(2)),
    ("volume", Column::Volume),
    ("area", Column::Volume),
    ("block", Column::Block),
];

impl Column {
    fn name(self) -> &'static str {
        NAMES.iter().find(|(_, column)| *column == self).map_or("", |(name, _)| name)
    }
}

/// Columns of a file that does not name them, by their number.
fn unnamed(count: usize) -> Option<&'static [Column]> {
    use Column::{Axis, Block, Volume};
    match count {
        3 => Some(&[Axis(0), Axis(1), Volume]),
        4 => Some(&[Axis(0), Axis(1), Axis(2), Volume]),
        5 => Some(&[Axis(0), Axis(1), Axis(2), Block, Volume]),
        _ => None,
    }
}

pub(super) fn read(source: &Source) -> Result<Points> {
    let mut cloud = Cloud::default();
    let mut columns: Vec<Column> = Vec::new();
    for (line, text) in source.lines() {
        let end = text.iter().position(|byte| matches!(byte, b'#' | b'!' | b'%'));
        let text = text[..end.unwrap_or(text.len())].trim_ascii();
        if text.is_empty() {
            continue;
        }
        refuse_gaps(source, line, text)?;
        let count = words(text).count();
        if columns.is_empty() {
            if words(text).all(is_name) {
                columns = named(source, line, text)?;
                continue;
            }
            let Some(known) = unnamed(count) else {
                return source.flaw(
                    line,
                    format_args!(
                        "expected x y z volume, x y z block volume, or x y area, found {count} \
                         columns: {}",
                        shown(text)
                    ),
                );
            };
            columns = memory::copied(known, "columns")?;
        }
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
        point(source, line, text, &columns, &mut cloud)?;
    }
    let solid = columns.is_empty() || columns.contains(&Column::Axis(2));
    cloud.into_points(source, if solid { 3 } else { 2 })
}

/// Reads a point from a line with as many words as there are columns.
fn point(
    source: &Source,
    line: usize,
    text: &[u8],
    columns: &[Column],
    cloud: &mut Cloud,
) -> Result<()> {
    let mut place = [0.0; 3];
    for (word, &column) in words(text).zip(columns) {
        let expected = |what: &str| {
            let plane = column == Column::Volume && !columns.contains(&Column::Axis(2));
            let (name, found) = (if plane { "area" } else { column.name() }, shown(word));
            source.flaw(line, format_args!("expected {what} as {name}, found {found}"))
        };
        match column {
            Column::Axis(axis) => match real(word).filter(|&value| is_coordinate(value)) {
                Some(value) => place[axis] = value,
                None => return expected("a number"),
            },
            Column::Volume => match real(word).filter(|&value| is_volume(value)) {
                Some(volume) => memory::push(&mut cloud.volumes, volume, "volumes")?,
                None => return expected("a positive number"),
            },
            // The volume of this line may be counted already.
            Column::Block => match integer(word) {
                Some(block) => cloud.put_into_block(block, cloud.lines.len())?,
                None => return expected("a whole number"),
            },
            Column::Other => {}
        }
    }
    for value in place {
        memory::push(&mut cloud.coordinates, value, "coordinates")?;
    }
    memory::push(&mut cloud.lines, line as u32, "lines")
}

/// The columns that a line names, in any order.
fn named(source: &Source, line: usize, text: &[u8]) -> Result<Vec<Column>> {
    let mut columns = memory::reserved(words(text).count(), "columns")?;
    for word in words(text) {
        // Without quotes, and without a unit: x[mm].
        let end = word.iter().position(|byte| matches!(byte, b'[' | b'('));
        let bare = word[..end.unwrap_or(word.len())].to_ascii_lowercase();
        let bare = bare.trim_ascii();
        let known = NAMES.iter().find(|(name, _)| {
            bare == name.as_bytes()
                || bare.strip_prefix(b"\"").and_then(|it| it.strip_suffix(b"\""))
                    == Some(name.as_bytes())
        });
        columns.push(known.map_or(Column::Other, |(_, column)| *column));
    }
    let times = |column: Column| columns.iter().filter(|&&known| known == column).count();
    let needed = [Column::Axis(0), Column::Axis(1), Column::Volume];
    let optional = [Column::Axis(2), Column::Block];
    if needed.iter().all(|&column| times(column) == 1)
        && optional.iter().all(|&column| times(column) <= 1)
    {
        return Ok(columns);
    }
    source.flaw(
        line,
        format_args!(
            "expected columns named x, y, z and volume, or x, y and area, and perhaps block, each once, \
             found {}",
            shown(text)
        ),
    )
}

/// Nothing between two commas would shift what follows.
fn refuse_gaps(source: &Source, line: usize, text: &[u8]) -> Result<()> {
    let mut fields = text.strip_suffix(b",").unwrap_or(text).split(|&byte| byte == b',');
    if text.contains(&b',') && fields.any(|field| field.trim_ascii().is_empty()) {
        return source.flaw(
            line,
            format_args!("expected something between two commas, found {}", shown(text)),
        );
    }
    Ok(())
}

/// Neither a number nor what computers write where a number fails them.
fn is_name(word: &[u8]) -> bool {
    let number = str::from_utf8(word).is_ok_and(|text| text.parse::<f64>().is_ok());
    (word[0].is_ascii_alphabetic() || word[0] == b'"') && !number
}
