//! MSH 2.2: each element names its physical group, and stands once for each group that it is in.

use super::numbers::Reader;
use super::{Meshed, cell, kind, place};
use crate::error::Result;

pub(super) fn nodes(reader: &mut Reader, meshed: &mut Meshed) -> Result<()> {
    for _ in 0..count(reader, "the number of nodes", 4)? {
        let number = reader.tag("the number of a node")?;
        let line = reader.line();
        let place = place(reader)?;
        meshed.mesh.add_node(reader.source(), number, line, place)?;
    }
    Ok(())
}

pub(super) fn elements(reader: &mut Reader, meshed: &mut Meshed) -> Result<()> {
    let count = count(reader, "the number of elements", 2)?;
    if !reader.is_binary() {
        for _ in 0..count {
            let number = reader.tag("the number of an element")?;
            let (kind, tags) = (reader.int("the type of an element")?, tags(reader)?);
            element(reader, meshed, number, kind, tags)?;
        }
        return Ok(());
    }
    let mut found = 0;
    while found < count {
        let (kind, follow) =
            (reader.int("the type of elements")?, reader.tag("a number of elements")?);
        reader.refuse_more_than_fit(follow, "a number of elements", 2)?;
        let tags = tags(reader)?;
        if follow == 0 || follow > count - found {
            return reader.flaw(format_args!(
                "expected up to {} elements more, found {follow}",
                count - found
            ));
        }
        for _ in 0..follow {
            let number = reader.tag("the number of an element")?;
            element(reader, meshed, number, kind, tags)?;
        }
        found += follow;
    }
    Ok(())
}

/// A number of items on a line of its own, in binary files too.
fn count(reader: &mut Reader, what: &str, numbers: u64) -> Result<u64> {
    let line = reader.rest_of_line();
    let count = super::super::source::integer(line).and_then(|count| u64::try_from(count).ok());
    let Some(count) = count else {
        let found = super::shown(line);
        return reader.flaw(format_args!("expected {what} on a line, found {found}"));
    };
    reader.refuse_more_than_fit(count, what, numbers)?;
    Ok(count)
}

fn tags(reader: &mut Reader) -> Result<u64> {
    let tags = reader.tag("a number of tags")?;
    reader.refuse_more_than_fit(tags, "a number of tags", 1)?;
    Ok(tags)
}

/// An element from its tags on; the first is its physical group, 0 for none.
fn element(
    reader: &mut Reader,
    meshed: &mut Meshed,
    number: u64,
    of: i64,
    tags: u64,
) -> Result<()> {
    let kind = kind(reader, of)?;
    let mut physical = 0;
    for place in 0..tags {
        let tag = reader.int("a tag")?;
        if place == 0 {
            physical = tag;
        }
    }
    cell(reader, &mut meshed.mesh, number, kind, false)?;
    if physical != 0 {
        meshed.put_last_cell_into(kind.dimension(), physical)?;
    }
    Ok(())
}
