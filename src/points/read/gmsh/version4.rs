//! MSH 4.1: nodes and elements come in blocks, each of an entity of the geometry, which knows its
//! physical groups.

use super::numbers::Reader;
use super::{Meshed, cell, kind, place};
use crate::error::Result;
use crate::memory;

/// Numbers that an entity has at least: its own, its box or place, and the count of its groups.
const LEAST_OF_ENTITY: u64 = 5;

/// Physical groups of an entity: each of its elements is put into all of them.
const MOST_GROUPS: u64 = 1000;

pub(super) fn entities(reader: &mut Reader, meshed: &mut Meshed) -> Result<()> {
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = reader.count("a number of entities", LEAST_OF_ENTITY)?;
    }
    for (dimension, &count) in counts.iter().enumerate() {
        for _ in 0..count {
            let number = reader.int("the number of an entity")?;
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                reader.real("a limit of an entity")?;
            }
            let groups = reader.count("a number of physical groups", 1)?;
            if groups > MOST_GROUPS {
                return reader.unsupported(format_args!(
                    "expected an entity in at most {MOST_GROUPS} physical groups, found {groups}"
                ));
            }
            let mut members = Vec::new();
            for _ in 0..groups {
                let group = reader.int("a physical group")?;
                memory::push(&mut members, group, "physical groups")?;
            }
            members.sort_unstable();
            members.dedup();
            if dimension > 0 {
                for _ in 0..reader.count("a number of bounding entities", 1)? {
                    reader.int("a bounding entity")?;
                }
            }
            if !members.is_empty() {
                meshed.entities.insert((dimension, number), members);
            }
        }
    }
    Ok(())
}

/// An entity's dimension and number, and one number more.
fn block(reader: &mut Reader, third: &str) -> Result<(usize, i64, i64)> {
    let dimension = reader.int("the dimension of an entity")?;
    let number = reader.int("the number of an entity")?;
    let third = reader.int(third)?;
    match usize::try_from(dimension) {
        Ok(dimension @ 0..=3) => Ok((dimension, number, third)),
        _ => reader.flaw(format_args!("expected a dimension of 0 to 3, found {dimension}")),
    }
}

/// Numbers of blocks and items; the least and greatest number are of no use.
fn totals(reader: &mut Reader, what: &str) -> Result<(u64, u64)> {
    let blocks = reader.count("a number of blocks", 4)?;
    let items = reader.count(what, 2)?;
    reader.size("the least number")?;
    reader.size("the greatest number")?;
    Ok((blocks, items))
}

fn expect_total(reader: &Reader, what: &str, expected: u64, found: u64) -> Result<()> {
    if expected == found {
        return Ok(());
    }
    reader.flaw(format_args!("expected {expected} {what}, found {found} in all blocks"))
}

pub(super) fn nodes(reader: &mut Reader, meshed: &mut Meshed) -> Result<()> {
    let (blocks, total) = totals(reader, "a number of nodes")?;
    let mut found = 0_u64;
    let mut numbers = Vec::new();
    for _ in 0..blocks {
        let (dimension, _, parametric) = block(reader, "whether nodes have parameters")?;
        let count = reader.count("a number of nodes", 4)?;
        numbers.clear();
        for _ in 0..count {
            let item = (reader.size("the number of a node")?, reader.line());
            memory::push(&mut numbers, item, "numbers of nodes")?;
        }
        for &(number, line) in &numbers {
            let place = place(reader)?;
            if parametric != 0 {
                for _ in 0..dimension {
                    reader.real("a parameter of a node")?;
                }
            }
            meshed.mesh.add_node(reader.source(), number, line, place)?;
        }
        found += count;
    }
    expect_total(reader, "nodes", total, found)
}

pub(super) fn elements(reader: &mut Reader, meshed: &mut Meshed) -> Result<()> {
    let (blocks, total) = totals(reader, "a number of elements")?;
    let mut found = 0_u64;
    for _ in 0..blocks {
        let (dimension, entity, number) = block(reader, "the type of elements")?;
        let kind = kind(reader, number)?;
        let count = reader.count("a number of elements", 1 + kind.nodes() as u64)?;
        let groups = meshed.entities.get(&(dimension, entity));
        let groups = groups.map_or(Ok(Vec::new()), |groups| memory::copied(groups, "groups"))?;
        for _ in 0..count {
            let number = reader.size("the number of an element")?;
            cell(reader, &mut meshed.mesh, number, kind, true)?;
            for &group in &groups {
                meshed.put_last_cell_into(dimension, group)?;
            }
        }
        found += count;
    }
    expect_total(reader, "elements", total, found)
}
