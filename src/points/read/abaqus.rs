//! Meshes of Abaqus: `*NODE`, `*ELEMENT`, `*NSET` and `*ELSET` of a flat input file.

use std::collections::BTreeMap;

use super::cells::Kind;
use super::mesh::{Members, Mesh};
use super::source::{Source, integer, real, shown};
use crate::error::Result;
use crate::memory;

/// Element types by the beginning of their names, which letters may follow (C3D8R, S4R, C3D10M).
const TYPES: &[(&str, Kind)] = &[
    ("C3D4", Kind::Tetrahedron4),
    ("C3D5", Kind::Pyramid5),
    ("C3D6", Kind::Wedge6),
    ("C3D8", Kind::Hexahedron8),
    ("C3D10", Kind::Tetrahedron10),
    ("CPS3", Kind::Triangle3),
    ("CPE3", Kind::Triangle3),
    ("CPS4", Kind::Quadrilateral4),
    ("CPE4", Kind::Quadrilateral4),
    ("CPS6", Kind::Triangle6),
    ("CPE6", Kind::Triangle6),
    ("CPS8", Kind::Quadrilateral8),
    ("CPE8", Kind::Quadrilateral8),
    ("S3", Kind::Triangle3),
    ("S4", Kind::Quadrilateral4),
    ("S8", Kind::Quadrilateral8),
    ("STRI3", Kind::Triangle3),
    ("STRI65", Kind::Triangle6),
    ("S9", Kind::Quadrilateral9),
    ("M3D3", Kind::Triangle3),
    ("M3D4", Kind::Quadrilateral4),
    ("M3D6", Kind::Triangle6),
    ("M3D8", Kind::Quadrilateral8),
    ("M3D9", Kind::Quadrilateral9),
    ("R3D3", Kind::Triangle3),
    ("R3D4", Kind::Quadrilateral4),
    ("T2D2", Kind::Line(2)),
    ("T3D2", Kind::Line(2)),
    ("T2D3", Kind::Line(3)),
    ("T3D3", Kind::Line(3)),
    ("B21", Kind::Line(2)),
    ("B31", Kind::Line(2)),
    ("B22", Kind::Line(3)),
    ("B32", Kind::Line(3)),
];

/// Keywords that make or move nodes and elements: a mesh read without them would be another one.
const REFUSED: &[(&str, &str)] = &[
    ("INCLUDE", "put the included file's lines in its place"),
    ("INSTANCE", "write a flat input file, without parts and assemblies"),
    ("NGEN", "write out the nodes"),
    ("NFILL", "write out the nodes"),
    ("NCOPY", "write out the nodes"),
    ("NMAP", "write out the nodes"),
    ("ELGEN", "write out the elements"),
    ("ELCOPY", "write out the elements"),
    ("SYSTEM", "write the nodes in global coordinates"),
];

pub(super) fn read(source: &Source) -> Result<Mesh> {
    let mut reader = Reader { source, ..Reader::new(source) };
    let mut lines = source.lines().filter(|(_, text)| !text.is_empty() && !text.starts_with(b"**"));
    while let Some((line, text)) = lines.next() {
        if !text.starts_with(b"*") {
            reader.data(line, text)?;
            continue;
        }
        reader.end_section(line, text)?;
        // A keyword goes on after a comma at the end of its line.
        let mut keyword = memory::copied(text, "a keyword")?;
        while keyword.ends_with(b",") {
            let Some((_, more)) = lines.next() else { break };
            more.iter().try_for_each(|&byte| memory::push(&mut keyword, byte, "a keyword"))?;
        }
        reader.section = reader.keyword(line, &keyword)?;
    }
    reader.end_section(source.line_of(source.bytes.len()), b"the end of the file")?;
    reader.finish()
}

/// What the data lines below a keyword are.
enum Section {
    Other,
    Nodes { set: Option<usize> },
    Elements { kind: Kind, name: String, set: Option<usize> },
    Set { place: usize, generated: bool },
}

/// A set as the file has it.
struct Listed {
    name: String,
    of: Members,
    ranges: Vec<Range>,
}

/// Every `step`th number from `first` to `last`, named at a line; `from_list`: one that must exist.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Range {
    first: u64,
    last: u64,
    step: u64,
    line: u32,
    from_list: bool,
}

struct Reader<'a> {
    source: &'a Source,
    mesh: Mesh,
    section: Section,
    /// Nodes that the element begun last still lacks.
    missing: usize,
    sets: Vec<Listed>,
    /// Sets by what they are of and their names in capitals.
    known: BTreeMap<(bool, String), usize>,
}

impl<'a> Reader<'a> {
    fn new(source: &'a Source) -> Self {
        Self {
            source,
            mesh: Mesh::default(),
            section: Section::Other,
            missing: 0,
            sets: Vec::new(),
            known: BTreeMap::new(),
        }
    }

    fn end_section(&self, line: usize, found: &[u8]) -> Result<()> {
        if self.missing == 0 {
            return Ok(());
        }
        self.source.flaw(
            line,
            format_args!(
                "expected {} more nodes of the element before, found {}",
                self.missing,
                shown(found)
            ),
        )
    }

    fn keyword(&mut self, line: usize, text: &[u8]) -> Result<Section> {
        let text = String::from_utf8_lossy(text);
        let mut parts = text[1..].split(',').map(str::trim);
        let name = parts.next().unwrap_or("").to_ascii_uppercase();
        let mut parameters = BTreeMap::new();
        for part in parts.filter(|part| !part.is_empty()) {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let value = value.trim().trim_matches('"').trim();
            parameters.insert(key.trim().to_ascii_uppercase(), value.to_owned());
        }
        if let Some((_, cure)) = REFUSED.iter().find(|(refused, _)| *refused == name) {
            return self.source.unsupported(line, format_args!("*{name} is not read; {cure}"));
        }
        if !matches!(&*name, "NODE" | "ELEMENT" | "NSET" | "ELSET") {
            return Ok(Section::Other);
        }
        for refused in ["INPUT", "INSTANCE"] {
            if parameters.contains_key(refused) {
                return self.source.unsupported(
                    line,
                    format_args!("{refused}= of *{name} is not read; write a flat input file"),
                );
            }
        }
        match &*name {
            "NODE" => {
                if parameters.get("SYSTEM").is_some_and(|system| !system.eq_ignore_ascii_case("R"))
                {
                    return self.source.unsupported(
                        line,
                        "nodes in another than the rectangular system are not read",
                    );
                }
                let set = parameters.get("NSET");
                let set = set.map(|name| self.set(line, name, Members::Nodes)).transpose()?;
                Ok(Section::Nodes { set })
            }
            "ELEMENT" => {
                let Some(given) = parameters.get("TYPE") else {
                    return self.source.flaw(line, "expected TYPE= of *ELEMENT, found none");
                };
                let kind = self.element_type(line, given)?;
                let set = parameters.get("ELSET");
                let set = set.map(|name| self.set(line, name, Members::Cells)).transpose()?;
                Ok(Section::Elements { kind, name: given.clone(), set })
            }
            _ => {
                let of = if name == "NSET" { Members::Nodes } else { Members::Cells };
                if of == Members::Nodes && parameters.contains_key("ELSET") {
                    return self
                        .source
                        .unsupported(line, "ELSET= of *NSET is not read; list nodes");
                }
                let Some(given) = parameters.get(&name) else {
                    return self
                        .source
                        .flaw(line, format_args!("expected {name}= of *{name}, found none"));
                };
                let place = self.set(line, given, of)?;
                Ok(Section::Set { place, generated: parameters.contains_key("GENERATE") })
            }
        }
    }

    fn element_type(&self, line: usize, given: &str) -> Result<Kind> {
        let capitals = given.to_ascii_uppercase();
        let fits = |name: &str| {
            let rest = capitals.strip_prefix(name);
            rest.is_some_and(|rest| !rest.starts_with(|letter: char| letter.is_ascii_digit()))
        };
        match TYPES.iter().find(|(name, _)| fits(name)) {
            Some((_, kind)) => Ok(*kind),
            None => self.source.unsupported(
                line,
                format_args!(
                    "elements of type {} are not read; known are C3D4, C3D5, C3D6, C3D8, C3D10, S3, \
                     S4, S8, S9, CPS and CPE 3, 4, 6 and 8, M3D3, 4, 6, 8 and 9",
                    shown(given.as_bytes())
                ),
            ),
        }
    }

    /// The place of a set, which is made if the file has not named it yet.
    fn set(&mut self, line: usize, name: &str, of: Members) -> Result<usize> {
        if name.is_empty() {
            return self.source.flaw(line, "expected the name of a set, found none");
        }
        let next = self.sets.len();
        let key = (of == Members::Nodes, name.to_ascii_uppercase());
        let place = *self.known.entry(key).or_insert(next);
        if place == next {
            let set = Listed { name: name.to_owned(), of, ranges: Vec::new() };
            memory::push(&mut self.sets, set, "sets")?;
        }
        Ok(place)
    }

    fn data(&mut self, line: usize, text: &[u8]) -> Result<()> {
        match self.section {
            Section::Other => Ok(()),
            Section::Nodes { set } => self.node(line, text, set),
            Section::Elements { kind, set, .. } => self.element(line, text, kind, set),
            Section::Set { place, generated: true } => self.generated(line, text, place),
            Section::Set { place, generated: false } => self.listed(line, text, place),
        }
    }

    fn node(&mut self, line: usize, text: &[u8], set: Option<usize>) -> Result<()> {
        let mut fields = fields(text);
        let number = self.number(line, fields.next().unwrap_or(b""), "the number of a node")?;
        let mut place = [0.0; 3];
        for (axis, field) in fields.by_ref().take(3).enumerate() {
            // An empty field is zero.
            if field.is_empty() {
                continue;
            }
            let Some(value) = real(field) else {
                return self.source.flaw(
                    line,
                    format_args!("expected a coordinate of node {number}, found {}", shown(field)),
                );
            };
            place[axis] = value;
        }
        self.mesh.add_node(self.source, number, line, place)?;
        self.put_into(set, number, line)
    }

    fn element(&mut self, line: usize, text: &[u8], kind: Kind, set: Option<usize>) -> Result<()> {
        let mut fields = fields(text);
        if self.missing == 0 {
            let field = fields.next().unwrap_or(b"");
            let number = self.number(line, field, "the number of an element")?;
            self.mesh.begin_cell(number, line, kind)?;
            self.missing = kind.nodes();
            self.put_into(set, number, line)?;
        }
        for field in fields {
            if self.missing == 0 {
                let name = match &self.section {
                    Section::Elements { name, .. } => name,
                    _ => "",
                };
                return self.source.flaw(
                    line,
                    format_args!(
                        "expected {} nodes of an element of type {}, found more: {}",
                        kind.nodes(),
                        shown(name.as_bytes()),
                        shown(field)
                    ),
                );
            }
            let node = self.number(line, field, "the number of a node")?;
            self.mesh.add_corner(node)?;
            self.missing -= 1;
        }
        Ok(())
    }

    fn put_into(&mut self, set: Option<usize>, number: u64, line: usize) -> Result<()> {
        let Some(set) = set else { return Ok(()) };
        let range =
            Range { first: number, last: number, step: 1, line: line as u32, from_list: true };
        memory::push(&mut self.sets[set].ranges, range, "sets")
    }

    fn generated(&mut self, line: usize, text: &[u8], place: usize) -> Result<()> {
        let mut fields = fields(text);
        let mut next = |what| self.number(line, fields.next().unwrap_or(b""), what);
        let (first, last) = (next("the first number")?, next("the last number")?);
        let step = match fields.next() {
            Some(field) if !field.is_empty() => self.number(line, field, "a step")?,
            _ => 1,
        };
        let range = Range { first, last, step, line: line as u32, from_list: false };
        memory::push(&mut self.sets[place].ranges, range, "sets")
    }

    fn listed(&mut self, line: usize, text: &[u8], place: usize) -> Result<()> {
        for field in fields(text).filter(|field| !field.is_empty()) {
            if integer(field).is_some() {
                let number = self.number(line, field, "a number or the name of a set")?;
                self.put_into(Some(place), number, line)?;
                continue;
            }
            let name = String::from_utf8_lossy(field);
            let name = name.trim_matches('"').trim().to_ascii_uppercase();
            let of_nodes = self.sets[place].of == Members::Nodes;
            let Some(&other) = self.known.get(&(of_nodes, name)) else {
                return self.source.flaw(
                    line,
                    format_args!(
                        "expected numbers or the name of a set before this line, found {}",
                        shown(field)
                    ),
                );
            };
            if other != place {
                let ranges = memory::copied(&self.sets[other].ranges, "sets")?;
                for range in ranges {
                    memory::push(&mut self.sets[place].ranges, range, "sets")?;
                }
                // However often sets name sets, none grows beyond what the file lists.
                self.sets[place].ranges.sort_unstable();
                self.sets[place].ranges.dedup();
            }
        }
        Ok(())
    }

    /// A number of a node or element: whole and positive.
    fn number(&self, line: usize, field: &[u8], what: &str) -> Result<u64> {
        match integer(field).and_then(|number| u64::try_from(number).ok()) {
            Some(number) if number > 0 => Ok(number),
            _ => self.source.flaw(
                line,
                format_args!("expected {what}, whole and positive, found {}", shown(field)),
            ),
        }
    }

    /// The sets of elements, then those of nodes, become groups.
    fn finish(mut self) -> Result<Mesh> {
        for of in [Members::Cells, Members::Nodes] {
            let (numbers, what) = match of {
                Members::Nodes => (self.mesh.node_numbers(self.source)?, "node"),
                Members::Cells => (self.mesh.cell_numbers(self.source)?, "element"),
            };
            for set in self.sets.iter().filter(|set| set.of == of) {
                let group = self.mesh.add_group(&set.name, of)?;
                for range in &set.ranges {
                    let found = numbers.within(range.first, range.last);
                    if found.is_empty() && range.from_list {
                        return self.source.flaw(
                            range.line as usize,
                            format_args!(
                                "expected {what}s that the file has in set {}, found {}",
                                shown(set.name.as_bytes()),
                                range.first
                            ),
                        );
                    }
                    for (number, place) in found {
                        if (number - range.first).is_multiple_of(range.step) {
                            self.mesh.put_into(group, *place as usize)?;
                        }
                    }
                }
            }
        }
        Ok(self.mesh)
    }
}

/// What commas separate, but for an empty field at the end.
fn fields(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let line = line.strip_suffix(b",").unwrap_or(line);
    line.split(|&byte| byte == b',').map(<[u8]>::trim_ascii)
}
