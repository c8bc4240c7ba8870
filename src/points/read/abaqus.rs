//! Meshes of Abaqus: `*NODE`, `*ELEMENT`, `*NSET` and `*ELSET` of a flat input file.

use std::collections::BTreeMap;

use super::cells::Kind;
use super::mesh::{MOST_SETS, Marks, Members, Mesh};
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
    ("C3D20", Kind::Hexahedron20),
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
    ("S6", Kind::Triangle6),
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

/// Beginnings of types without volume, whose elements are passed over.
const WITHOUT_VOLUME: &[&str] = &[
    "MASS", "ROTARYI", "SPRING", "DASHPOT", "CONN", "GAP", "ITS", "R2D2", "RB2D2", "RB3D2", "DCOUP",
];

/// Keywords that are read, with their parameters.
const READ: &[(&str, &[&str])] = &[
    ("NODE", &["NSET", "SYSTEM", "INPUT"]),
    ("ELEMENT", &["TYPE", "ELSET", "INPUT"]),
    ("NSET", &["NSET", "ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"]),
    ("ELSET", &["ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"]),
];

/// Letters from which on a shortened keyword is taken for one.
const SHORTENED: usize = 4;

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
    let mut reader = Reader::new(source);
    let mut lines =
        source.lines().filter(|(_, text)| !text.is_empty() && !text.starts_with(b"**")).peekable();
    while let Some((line, text)) = lines.next() {
        if !text.starts_with(b"*") {
            reader.data(line, text)?;
            continue;
        }
        reader.end_section(line, text)?;
        // A keyword goes on after a comma at the end of its line.
        let mut keyword = memory::copied(text, "a keyword")?;
        while keyword.ends_with(b",")
            && let Some((_, more)) = lines.next_if(|(_, text)| !text.starts_with(b"*"))
        {
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
    /// Sets that it holds, by their places; of nodes also sets of elements, whose nodes it holds.
    sets: Vec<usize>,
}

/// What a set is of, and its name: in capitals, unless it was in quotes.
type Key = (bool, Vec<u8>);

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
    known: BTreeMap<Key, usize>,
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
        let mut parts = fields(&text[1..]);
        let name = capitals(parts.next().unwrap_or(b""));
        if let Some((_, cure)) = REFUSED.iter().find(|(refused, _)| refused.as_bytes() == name) {
            let name = shown(text);
            return self.source.unsupported(line, format_args!("{name} is not read; {cure}"));
        }
        let known = READ.iter().find(|(known, _)| known.as_bytes() == name);
        let Some(&(keyword, allowed)) = known else {
            let full = READ.iter().map(|known| known.0).chain(REFUSED.iter().map(|it| it.0));
            let shortened =
                |full: &&str| name.len() >= SHORTENED && full.as_bytes().starts_with(&name);
            return match full.clone().find(shortened) {
                Some(full) => self.source.unsupported(
                    line,
                    format_args!("expected keywords in full, found {}: *{full}?", shown(text)),
                ),
                None => Ok(Section::Other),
            };
        };
        let mut parameters: BTreeMap<&str, &[u8]> = BTreeMap::new();
        for part in parts.filter(|part| !part.is_empty()) {
            let equals = part.iter().position(|&byte| byte == b'=');
            let (key, value) = part.split_at(equals.unwrap_or(part.len()));
            let given = capitals(key.trim_ascii());
            let Some(key) = allowed.iter().find(|known| known.as_bytes() == given) else {
                return self.source.unsupported(
                    line,
                    format_args!(
                        "expected parameters of *{keyword} among {}, found {}",
                        allowed.join(", "),
                        shown(part)
                    ),
                );
            };
            parameters.insert(key, value.get(1..).unwrap_or(&[]).trim_ascii());
        }
        for refused in ["INPUT", "INSTANCE"] {
            if parameters.contains_key(refused) {
                return self.source.unsupported(
                    line,
                    format_args!("{refused}= of *{keyword} is not read; write a flat input file"),
                );
            }
        }
        match keyword {
            "NODE" => {
                let system = parameters.get("SYSTEM");
                if system.is_some_and(|system| !system.eq_ignore_ascii_case(b"R")) {
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
                Ok(Section::Elements { kind, name: shown(given), set })
            }
            _ => {
                let of = if keyword == "NSET" { Members::Nodes } else { Members::Cells };
                let Some(given) = parameters.get(keyword) else {
                    return self
                        .source
                        .flaw(line, format_args!("expected {keyword}= of *{keyword}, found none"));
                };
                let place = self.set(line, given, of)?;
                if of == Members::Nodes
                    && let Some(elements) = parameters.get("ELSET")
                {
                    self.hold(line, place, elements, Members::Cells)?;
                }
                Ok(Section::Set { place, generated: parameters.contains_key("GENERATE") })
            }
        }
    }

    fn element_type(&self, line: usize, given: &[u8]) -> Result<Kind> {
        let given_in_capitals = capitals(given);
        let rest = |name: &str| given_in_capitals.strip_prefix(name.as_bytes());
        let fits = |name: &str| {
            rest(name).is_some_and(|rest| !rest.first().is_some_and(u8::is_ascii_digit))
        };
        if WITHOUT_VOLUME.iter().any(|name| rest(name).is_some()) {
            return Ok(Kind::Nothing);
        }
        match TYPES.iter().find(|(name, _)| fits(name)) {
            Some((_, kind)) => Ok(*kind),
            None => self.source.unsupported(
                line,
                format_args!(
                    "elements of type {} are not read; known are C3D4, 5, 6, 8, 10 and 20, S3, S4, S6, \
                     S8, S9, CPS and CPE 3, 4, 6 and 8, M3D3, 4, 6, 8 and 9",
                    shown(given)
                ),
            ),
        }
    }

    /// The place of a set, which is made if the file has not named it yet.
    fn set(&mut self, line: usize, name: &[u8], of: Members) -> Result<usize> {
        let key = key(name, of);
        if key.1.is_empty() {
            return self.source.flaw(line, "expected the name of a set, found none");
        }
        let next = self.sets.len();
        let name = String::from_utf8_lossy(without_quotes(name)).into_owned();
        let place = *self.known.entry(key).or_insert(next);
        if place == next {
            let set = Listed { name, of, ranges: Vec::new(), sets: Vec::new() };
            memory::push(&mut self.sets, set, "sets")?;
        }
        Ok(place)
    }

    /// Lets a set hold what another of this name holds, which the file has named before.
    fn hold(&mut self, line: usize, place: usize, name: &[u8], of: Members) -> Result<()> {
        match self.known.get(&key(name, of)) {
            Some(&other) => memory::push(&mut self.sets[place].sets, other, "sets"),
            None => self.source.flaw(
                line,
                format_args!(
                    "expected numbers or the name of a set before this line, found {}",
                    shown(name)
                ),
            ),
        }
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
                // Nodes that tell how a beam lies.
                if kind.dimension() < 2 {
                    return Ok(());
                }
                let name = match &self.section {
                    Section::Elements { name, .. } => name,
                    _ => "",
                };
                return self.source.flaw(
                    line,
                    format_args!(
                        "expected {} nodes of an element of type {}, found more: {}",
                        kind.nodes(),
                        name,
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
        if last < first || fields.next().is_some() {
            return self.source.flaw(
                line,
                format_args!(
                    "expected a first number, a last one not below it and a step, found {}",
                    shown(text)
                ),
            );
        }
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
            self.hold(line, place, field, self.sets[place].of)?;
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

    /// The sets become groups.
    fn finish(mut self) -> Result<Mesh> {
        let numbers = [self.mesh.cell_numbers(self.source)?, self.mesh.node_numbers(self.source)?];
        let mut seen = [
            Marks::new(self.mesh.cell_count())?,
            Marks::new(self.mesh.node_count())?,
            Marks::new(self.sets.len())?,
        ];
        for set in &mut self.sets {
            merge(&mut set.ranges);
        }
        let most = MOST_SETS * (self.mesh.cell_count() + self.mesh.node_count());
        let mut visited = 0;
        let mut open = Vec::new();
        for (place, set) in self.sets.iter().enumerate() {
            let group = self.mesh.add_group(&set.name, set.of)?;
            seen.iter_mut().for_each(Marks::clear);
            memory::push(&mut open, place, "sets")?;
            while let Some(place) = open.pop() {
                if !seen[2].mark(place) {
                    continue;
                }
                let held = &self.sets[place];
                let of_nodes = usize::from(held.of == Members::Nodes);
                for range in &held.ranges {
                    let found = numbers[of_nodes].within(range.first, range.last);
                    visited += found.len() + 1;
                    if visited > most {
                        return self.source.unsupported(
                            range.line as usize,
                            format_args!(
                                "its nodes and elements stand in more than {MOST_SETS} sets each, in \
                                 the mean"
                            ),
                        );
                    }
                    if found.is_empty() && range.from_list {
                        return self.source.flaw(
                            range.line as usize,
                            format_args!(
                                "expected {}s that the file has in set {}, found {}",
                                ["element", "node"][of_nodes],
                                shown(held.name.as_bytes()),
                                range.first
                            ),
                        );
                    }
                    for &(number, member) in found {
                        let member = member as usize;
                        if !(number - range.first).is_multiple_of(range.step)
                            || !seen[of_nodes].mark(member)
                        {
                            continue;
                        }
                        if held.of == set.of {
                            self.mesh.put_into(group, member)?;
                            continue;
                        }
                        // The nodes of an element, for a set of nodes.
                        for corner in 0..self.mesh.corner_count(member) {
                            let node = numbers[1].find(self.mesh.corner(member, corner));
                            if let Some(node) = node
                                && seen[1].mark(node as usize)
                            {
                                self.mesh.put_into(group, node as usize)?;
                            }
                        }
                    }
                }
                for &other in &held.sets {
                    memory::push(&mut open, other, "sets")?;
                }
            }
        }
        Ok(self.mesh)
    }
}

/// Sorts ranges, and makes one of those that touch.
fn merge(ranges: &mut Vec<Range>) {
    ranges.sort_unstable();
    ranges.dedup_by(|next, kept| {
        let touch = next.step == 1 && kept.step == 1 && next.first <= kept.last.saturating_add(1);
        // A number that must exist keeps the line on which it is said.
        let same = next.first == kept.first && next.last == kept.last && next.step == kept.step;
        let merged = same || (touch && !next.from_list && !kept.from_list);
        if merged {
            kept.last = kept.last.max(next.last);
            kept.from_list |= next.from_list;
        }
        merged
    });
}

/// What a set of this name is known by.
fn key(name: &[u8], of: Members) -> Key {
    let bare = without_quotes(name);
    let quoted = bare.len() < name.len();
    (of == Members::Nodes, if quoted { bare.to_owned() } else { capitals(bare) })
}

fn without_quotes(name: &[u8]) -> &[u8] {
    let inner = name.strip_prefix(b"\"").and_then(|name| name.strip_suffix(b"\""));
    inner.unwrap_or(name).trim_ascii()
}

fn capitals(text: &[u8]) -> Vec<u8> {
    text.to_ascii_uppercase()
}

/// What commas outside of quotes separate, but for an empty field at the end.
fn fields(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let line = line.strip_suffix(b",").unwrap_or(line);
    let mut quoted = false;
    let comma = move |byte: &u8| {
        quoted ^= *byte == b'"';
        *byte == b',' && !quoted
    };
    line.split(comma).map(<[u8]>::trim_ascii)
}
