//! Named sets of points.

use std::collections::BTreeMap;

use crate::error::{Result, argument};
use crate::memory;
use crate::suggest;

/// The set that always exists: every point.
pub(crate) const ALL: &str = "all";

const LONGEST_NAME: usize = 255;

/// Sets by name; each keeps the order in which its points were given.
#[derive(Debug, Default)]
pub(crate) struct Sets {
    named: BTreeMap<String, Vec<u32>>,
}

impl Sets {
    pub(super) fn add(&mut self, name: &str, indices: &[usize], point_count: usize) -> Result<()> {
        self.check_name(name)?;
        if indices.is_empty() {
            return argument(format!("'count' is 0: set '{name}' would have no point"));
        }
        if indices.len() > point_count {
            return too_many(indices.len(), point_count);
        }
        let mut seen = memory::filled(false, point_count, "a set")?;
        let mut members = memory::reserved(indices.len(), "a set")?;
        for (place, &point) in indices.iter().enumerate() {
            if point >= point_count {
                return argument(format!(
                    "'indices'[{place}] is {point}; it must be below the number of points, \
                     {point_count}"
                ));
            }
            if std::mem::replace(&mut seen[point], true) {
                return argument(format!("'indices'[{place}]: point {point} is given twice"));
            }
            members.push(point as u32);
        }
        self.named.insert(name.to_owned(), members);
        Ok(())
    }

    /// Adds a set from a file, its members ascending. A name that other points have already gets `_2`, and
    /// letters that a name cannot have become `_`; no set is added twice, and none without points.
    pub(super) fn add_new(
        &mut self,
        name: &str,
        members: Vec<u32>,
        point_count: usize,
        names: &mut SetNames,
    ) {
        if members.is_empty() {
            return;
        }
        let letters = name.trim().chars().take(LONGEST_NAME);
        let mut clean = String::new();
        clean.extend(letters.map(|letter| if letter.is_control() { '_' } else { letter }));
        let clean = if clean.is_empty() { "unnamed" } else { &clean };
        let first = with_suffix(clean, "");
        let taken_by_the_same = match self.named.get(&first) {
            Some(known) => *known == members,
            None => first == ALL && members.len() == point_count,
        };
        if taken_by_the_same {
            return;
        }
        // Where many sets share a name, the turns taken already are not tried again.
        let turn = names.next.entry(first).or_insert(1);
        loop {
            let suffix = if *turn == 1 { String::new() } else { format!("_{turn}") };
            let name = with_suffix(clean, &suffix);
            *turn += 1;
            if name != ALL && !self.named.contains_key(&name) {
                self.named.insert(name, members);
                return;
            }
        }
    }

    /// Names of the sets but `all`, in alphabetical order.
    pub(super) fn names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.named.keys().map(String::as_str)
    }

    fn check_name(&self, name: &str) -> Result<()> {
        if name.is_empty() {
            return argument("'name' is empty; a set needs a name");
        }
        if name.len() > LONGEST_NAME {
            return argument(format!(
                "'name' has {} bytes; at most {LONGEST_NAME} are allowed",
                name.len()
            ));
        }
        if name.trim() != name || name.chars().any(char::is_control) {
            return argument(format!(
                "'name' {name:?} begins or ends with a blank or has a control character"
            ));
        }
        if name == ALL || self.named.contains_key(name) {
            return argument(format!("'name': a set '{name}' exists already"));
        }
        Ok(())
    }

    pub(super) fn find(&self, name: &str) -> Result<&[u32]> {
        match self.named.get(name) {
            Some(members) => Ok(members),
            None => {
                let known = self.named.keys().map(String::as_str).chain([ALL]);
                argument(format!("unknown set '{name}'{}", suggest::similar(name, known)))
            }
        }
    }

    pub(super) fn try_clone(&self) -> Result<Self> {
        let mut named = BTreeMap::new();
        for (name, members) in &self.named {
            named.insert(name.clone(), memory::copied(members, "a set")?);
        }
        Ok(Self { named })
    }

    pub(super) fn bytes(&self) -> usize {
        self.named.values().map(memory::bytes).sum()
    }
}

/// Names that sets of a file have taken.
#[derive(Default)]
pub(super) struct SetNames {
    /// Number of the next set of a name.
    next: BTreeMap<String, usize>,
}

/// A name cut so that it and its suffix are not too long.
fn with_suffix(name: &str, suffix: &str) -> String {
    let mut room = name.len().min(LONGEST_NAME - suffix.len());
    while !name.is_char_boundary(room) {
        room -= 1;
    }
    format!("{}{suffix}", name[..room].trim_end())
}

/// Refuses a set of more points than there are.
pub(super) fn too_many<T>(given: usize, point_count: usize) -> Result<T> {
    argument(format!("'count' is {given}, but there are only {point_count} points"))
}
