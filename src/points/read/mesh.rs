//! Meshes: nodes, cells and groups as a file has them, and the points that they become.

use super::cells::{Kind, MOST_NODES};
use super::source::Source;
use super::{Cloud, is_coordinate};
use crate::error::Result;
use crate::memory;
use crate::points::Points;
use crate::points::sets::SetNames;

/// Nodes of plane cells may stray from their plane by this share of the mesh's extent.
const FLAT: f64 = 1e-9;

/// Sets that a point may be in, in the mean: what a file says in a line must not fill the memory.
pub(super) const MOST_SETS: usize = 1000;

/// What a file says, with its own numbers of nodes and cells.
#[derive(Default)]
pub(super) struct Mesh {
    nodes: Vec<Node>,
    cells: Vec<Cell>,
    /// Numbers of the cells' nodes, cell after cell.
    corners: Vec<u64>,
    groups: Vec<Group>,
    /// Whether cells with the same nodes are one and the same.
    merges_twins: bool,
    /// The first cell with the same nodes as each cell; empty where none stands twice.
    twins: Vec<u32>,
}

struct Node {
    number: u64,
    line: u32,
    place: [f64; 3],
}

struct Cell {
    number: u64,
    /// Where its nodes begin in `corners`.
    first: usize,
    line: u32,
    kind: Kind,
}

/// A set in the making.
struct Group {
    name: String,
    of: Members,
    /// Places of nodes or cells in the file's order.
    members: Vec<u32>,
}

/// What a group is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Members {
    Nodes,
    Cells,
}

/// A group of a mesh, by its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct GroupPlace(usize);

impl Mesh {
    /// Adds a node. `number`: what cells call it.
    pub(super) fn add_node(
        &mut self,
        source: &Source,
        number: u64,
        line: usize,
        place: [f64; 3],
    ) -> Result<()> {
        if let Some(value) = place.iter().find(|&&value| !is_coordinate(value)) {
            return source.flaw(
                line,
                format_args!("expected a finite coordinate of node {number}, found {value}"),
            );
        }
        memory::push(&mut self.nodes, Node { number, line: line as u32, place }, "nodes")
    }

    /// Begins a cell, whose nodes follow by [`Mesh::add_corner`].
    pub(super) fn begin_cell(&mut self, number: u64, line: usize, kind: Kind) -> Result<()> {
        let cell = Cell { number, first: self.corners.len(), line: line as u32, kind };
        memory::push(&mut self.cells, cell, "cells")
    }

    /// Adds a node to the cell begun last, by its number.
    pub(super) fn add_corner(&mut self, node: u64) -> Result<()> {
        memory::push(&mut self.corners, node, "the nodes of cells")
    }

    /// The nodes of the cell begun last.
    pub(super) fn last_corners(&mut self) -> &mut [u64] {
        let first = self.cells.last().map_or(0, |cell| cell.first);
        &mut self.corners[first..]
    }

    /// Number of cells so far.
    pub(super) fn cell_count(&self) -> usize {
        self.cells.len()
    }

    /// Number of nodes so far.
    pub(super) fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Number of nodes of a cell, by its place.
    pub(super) fn corner_count(&self, cell: usize) -> usize {
        self.cells[cell].kind.nodes()
    }

    /// Number of a node of a cell, by its place.
    pub(super) fn corner(&self, cell: usize, corner: usize) -> u64 {
        self.corners[self.cells[cell].first + corner]
    }

    /// Adds an empty group.
    pub(super) fn add_group(&mut self, name: &str, of: Members) -> Result<GroupPlace> {
        let group = Group { name: name.to_owned(), of, members: Vec::new() };
        memory::push(&mut self.groups, group, "groups")?;
        Ok(GroupPlace(self.groups.len() - 1))
    }

    pub(super) fn name_group(&mut self, group: GroupPlace, name: String) {
        self.groups[group.0].name = name;
    }

    /// Puts a node or cell into a group, by its place in the file's order.
    pub(super) fn put_into(&mut self, group: GroupPlace, member: usize) -> Result<()> {
        memory::push(&mut self.groups[group.0].members, member as u32, "a group")
    }

    /// Makes cells with the same nodes one: the file has a cell once for each group that it is in.
    pub(super) fn merge_twins(&mut self) {
        self.merges_twins = true;
    }

    /// Finds cells with the same nodes, and refuses them unless they are one or of no dimension that counts.
    fn find_twins(&mut self, source: &Source, dimension: usize) -> Result<()> {
        // The same for any order of the nodes, in which twins may differ.
        let mix = |number: u64| (number ^ (number >> 29)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let keyed = self.cells.iter().enumerate().map(|(place, cell)| {
            let nodes = self.corners_of(cell).iter();
            (nodes.fold(0_u64, |sum, &node| sum.wrapping_add(mix(mix(node)))), place as u32)
        });
        let mut keyed = memory::collected(keyed, "cells")?;
        keyed.sort_unstable();
        let sorted_corners = |place: u32| {
            let cell = &self.cells[place as usize];
            let mut nodes = [0; MOST_NODES];
            nodes[..cell.kind.nodes()].copy_from_slice(self.corners_of(cell));
            nodes.sort_unstable();
            (cell.kind.nodes(), nodes)
        };
        let mut twins = memory::collected(0..self.cells.len() as u32, "cells")?;
        let mut any = false;
        for pair in keyed.windows(2) {
            let ((key, first), (next_key, second)) = (pair[0], pair[1]);
            if key == next_key && sorted_corners(first) == sorted_corners(second) {
                let [cell, twin] = [second, first].map(|place| &self.cells[place as usize]);
                if !self.merges_twins && cell.kind.dimension() == dimension {
                    let text = format!(
                        "expected nodes of its own for element {}, found those of element {}",
                        cell.number, twin.number
                    );
                    return source.flaw(cell.line as usize, text);
                }
                twins[second as usize] = twins[first as usize];
                any = true;
            }
        }
        if any {
            self.twins = twins;
        }
        Ok(())
    }

    /// Places of nodes by their numbers.
    pub(super) fn node_numbers(&self, source: &Source) -> Result<Numbers> {
        Numbers::new(source, "node", self.nodes.iter().map(|node| (node.number, node.line)))
    }

    /// Places of cells by their numbers.
    pub(super) fn cell_numbers(&self, source: &Source) -> Result<Numbers> {
        Numbers::new(source, "element", self.cells.iter().map(|cell| (cell.number, cell.line)))
    }

    /// Points in the centroids of the cells of the highest dimension, and the groups as sets.
    pub(super) fn into_points(mut self, source: &Source) -> Result<Points> {
        let dimension = self.cells.iter().map(|cell| cell.kind.dimension()).max().unwrap_or(0);
        if dimension < 2 {
            return source.flaw_of_all("expected solid or plane elements, found none");
        }
        if self.nodes.len().max(self.cells.len()) >= u32::MAX as usize {
            return source.flaw_of_all("its nodes or elements are more than fit");
        }
        self.find_corners(source)?;
        self.find_twins(source, dimension)?;
        if dimension == 2 {
            self.refuse_warped(source)?;
        }
        let mut cloud = Cloud::default();
        // The point of each cell, or MAX where there is none.
        let mut point_of = memory::filled(u32::MAX, self.cells.len(), "points of cells")?;
        for (place, cell) in self.cells.iter().enumerate() {
            if cell.kind.dimension() < dimension {
                continue;
            }
            if let Some(&twin) = self.twins.get(place)
                && twin as usize != place
            {
                // Lower than this place, so that its point is known.
                point_of[place] = point_of[twin as usize];
                continue;
            }
            let mut nodes = [[0.0; 3]; MOST_NODES];
            for (node, &corner) in nodes.iter_mut().zip(self.corners_of(cell)) {
                *node = self.nodes[corner as usize].place;
            }
            let Some(measure) = cell.kind.measure(&nodes[..cell.kind.nodes()]) else {
                return source.flaw(
                    cell.line as usize,
                    format_args!(
                        "expected an element with a volume, found element {} flat, folded or partly \
                         inside out: are its nodes in order?",
                        cell.number
                    ),
                );
            };
            point_of[place] = cloud.volumes.len() as u32;
            memory::push(&mut cloud.volumes, measure.volume, "volumes")?;
            memory::push(&mut cloud.lines, cell.line, "lines")?;
            for value in measure.centroid {
                memory::push(&mut cloud.coordinates, value, "coordinates")?;
            }
        }
        let mut points = cloud.into_points(source, dimension)?;
        self.add_sets(source, dimension, &point_of, &mut points)?;
        Ok(points)
    }

    /// Turns the numbers of the cells' nodes into places.
    fn find_corners(&mut self, source: &Source) -> Result<()> {
        let numbers = self.node_numbers(source)?;
        for cell in &self.cells {
            for corner in &mut self.corners[cell.first..cell.first + cell.kind.nodes()] {
                let Some(place) = numbers.find(*corner) else {
                    return source.flaw(
                        cell.line as usize,
                        format_args!(
                            "expected a node that the file has, found node {corner} in element {}",
                            cell.number
                        ),
                    );
                };
                *corner = u64::from(place);
            }
        }
        Ok(())
    }

    fn corners_of(&self, cell: &Cell) -> &[u64] {
        &self.corners[cell.first..cell.first + cell.kind.nodes()]
    }

    /// Plane cells must lie in one plane of constant z.
    fn refuse_warped(&self, source: &Source) -> Result<()> {
        let (mut lower, mut upper) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let plane = || self.cells.iter().filter(|cell| cell.kind.dimension() == 2);
        let places = |cell| self.corners_of(cell).iter().map(|&it| &self.nodes[it as usize].place);
        for place in plane().flat_map(places) {
            for axis in 0..3 {
                lower[axis] = lower[axis].min(place[axis]);
                upper[axis] = upper[axis].max(place[axis]);
            }
        }
        let extent = (0..3).fold(0.0, |extent: f64, axis| extent.max(upper[axis] - lower[axis]));
        let Some(first) = plane().next() else { return Ok(()) };
        let height = places(first).next().map_or(0.0, |place| place[2]);
        for cell in plane() {
            if let Some(place) = places(cell).find(|it| (it[2] - height).abs() > FLAT * extent) {
                return source.unsupported(
                    cell.line as usize,
                    format_args!(
                        "expected plane elements at z = {height}, found element {} at z = {}; shells \
                         that are not in one plane of constant z are not offered",
                        cell.number, place[2]
                    ),
                );
            }
        }
        Ok(())
    }

    /// Groups of the body's cells first: where names are taken, theirs stay.
    fn add_sets(
        &self,
        source: &Source,
        dimension: usize,
        point_of: &[u32],
        points: &mut Points,
    ) -> Result<()> {
        let point_of = |cell: u32| point_of[cell as usize];
        let is_body = |cell: u32| point_of(cell) != u32::MAX;
        let bodily = |group: &Group| {
            group.of == Members::Cells && group.members.iter().any(|&cell| is_body(cell))
        };
        let mut chosen = Chosen::new(points.count())?;
        let mut names = SetNames::default();
        for group in self.groups.iter().filter(|group| bodily(group)) {
            let body = group.members.iter().filter(|&&cell| is_body(cell));
            body.for_each(|&cell| chosen.add(point_of(cell)));
            chosen.make_set(source, &group.name, &mut names, points)?;
        }
        if self.groups.iter().all(bodily) {
            return Ok(());
        }
        let touching = self.touching(dimension)?;
        let mut seen = Marks::new(self.nodes.len())?;
        for group in self.groups.iter().filter(|group| !bodily(group)) {
            seen.clear();
            for &member in &group.members {
                let own = [u64::from(member)];
                let nodes = match group.of {
                    Members::Nodes => &own[..],
                    Members::Cells => self.corners_of(&self.cells[member as usize]),
                };
                for &node in nodes.iter().filter(|&&node| seen.mark(node as usize)) {
                    touching.cells(node as usize).iter().for_each(|&it| chosen.add(point_of(it)));
                }
            }
            chosen.make_set(source, &group.name, &mut names, points)?;
        }
        Ok(())
    }

    /// The cells of the body at each node.
    fn touching(&self, dimension: usize) -> Result<Touching> {
        let mut starts = memory::filled(0_usize, self.nodes.len() + 1, "cells at nodes")?;
        let body = || {
            let cells = self.cells.iter().enumerate();
            cells.filter(|(_, cell)| cell.kind.dimension() == dimension)
        };
        for (_, cell) in body() {
            for &node in self.corners_of(cell) {
                starts[node as usize + 1] += 1;
            }
        }
        for node in 0..self.nodes.len() {
            starts[node + 1] += starts[node];
        }
        let mut cells = memory::filled(0, starts[self.nodes.len()], "cells at nodes")?;
        let mut next = memory::copied(&starts, "cells at nodes")?;
        for (place, cell) in body() {
            for &node in self.corners_of(cell) {
                cells[next[node as usize]] = place as u32;
                next[node as usize] += 1;
            }
        }
        Ok(Touching { starts, cells })
    }
}

/// What has been met since it was cleared last.
pub(super) struct Marks {
    turn: u32,
    turns: Vec<u32>,
}

impl Marks {
    pub(super) fn new(count: usize) -> Result<Self> {
        Ok(Self { turn: 1, turns: memory::filled(0, count, "a set")? })
    }

    pub(super) fn clear(&mut self) {
        self.turn += 1;
    }

    /// True the first time.
    pub(super) fn mark(&mut self, place: usize) -> bool {
        std::mem::replace(&mut self.turns[place], self.turn) != self.turn
    }

    fn is_marked(&self, place: usize) -> bool {
        self.turns[place] == self.turn
    }
}

/// The points of a set in the making.
struct Chosen {
    marks: Marks,
    count: usize,
    /// Members of all sets so far.
    total: usize,
}

impl Chosen {
    fn new(points: usize) -> Result<Self> {
        Ok(Self { marks: Marks::new(points)?, count: 0, total: 0 })
    }

    fn add(&mut self, point: u32) {
        self.count += usize::from(self.marks.mark(point as usize));
    }

    /// Makes a set of the points chosen, and begins the next.
    fn make_set(
        &mut self,
        source: &Source,
        name: &str,
        names: &mut SetNames,
        points: &mut Points,
    ) -> Result<()> {
        self.total += self.count;
        if self.total > MOST_SETS * points.count() {
            return source.unsupported(
                0,
                format_args!("its points stand in more than {MOST_SETS} sets each, in the mean"),
            );
        }
        let mut members = memory::reserved(self.count, "a set")?;
        let all = 0..points.count();
        members.extend(all.filter(|&it| self.marks.is_marked(it)).map(|it| it as u32));
        points.add_new_set(name, members, names);
        self.marks.clear();
        self.count = 0;
        Ok(())
    }
}

/// Cells at nodes: those of a node from its start to the next one's.
struct Touching {
    starts: Vec<usize>,
    cells: Vec<u32>,
}

impl Touching {
    fn cells(&self, node: usize) -> &[u32] {
        &self.cells[self.starts[node]..self.starts[node + 1]]
    }
}

/// Places of nodes or cells by the numbers that the file gives them.
pub(super) struct Numbers {
    /// Numbers and places, in the order of the numbers.
    sorted: Vec<(u64, u32)>,
}

impl Numbers {
    fn new(
        source: &Source,
        what: &str,
        items: impl ExactSizeIterator<Item = (u64, u32)> + Clone,
    ) -> Result<Self> {
        let numbered = items.clone().zip(0..).map(|((number, _), place)| (number, place));
        let mut sorted = memory::reserved(items.len(), "numbers")?;
        sorted.extend(numbered);
        sorted.sort_unstable();
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            let line = |place: u32| items.clone().nth(place as usize).map_or(0, |item| item.1);
            let first = match line(pair[0].1) {
                0 => String::new(),
                line => format!(" after line {line}"),
            };
            let text = format!("expected {what} {} once, found it again{first}", pair[0].0);
            return source.flaw(line(pair[1].1) as usize, text);
        }
        Ok(Self { sorted })
    }

    /// The place of a number.
    pub(super) fn find(&self, number: u64) -> Option<u32> {
        // Most files number from 1 without gaps.
        let guess = number.wrapping_sub(self.sorted.first()?.0) as usize;
        if let Some(&(found, place)) = self.sorted.get(guess)
            && found == number
        {
            return Some(place);
        }
        let found = self.sorted.binary_search_by_key(&number, |item| item.0).ok()?;
        Some(self.sorted[found].1)
    }

    /// Places of the numbers from `first` to `last`.
    pub(super) fn within(&self, first: u64, last: u64) -> &[(u64, u32)] {
        let start = self.sorted.partition_point(|item| item.0 < first);
        let end = self.sorted.partition_point(|item| item.0 <= last);
        self.sorted.get(start..end).unwrap_or(&[])
    }
}
