//! Counting sort: what is sorted by place is sorted by whole numbers.

use crate::error::Result;
use crate::memory;

/// Indices ordered by their keys, those with the same key ascending.
pub(crate) struct ByKey {
    pub(crate) indices: Vec<u32>,
    /// For each key the place of its first index among them, and the end.
    pub(crate) first: Vec<u32>,
}

impl ByKey {
    /// Orders the indices of `keys`, all of which are below `count`.
    pub(crate) fn new(keys: &[u32], count: usize, purpose: &'static str) -> Result<Self> {
        let mut first = memory::filled(0_u32, count + 1, purpose)?;
        let mut indices = memory::filled(0_u32, keys.len(), purpose)?;
        for &key in keys {
            first[key as usize + 1] += 1;
        }
        for key in 0..count {
            first[key + 1] += first[key];
        }
        for (index, &key) in keys.iter().enumerate() {
            let place = &mut first[key as usize];
            indices[*place as usize] = index as u32;
            *place += 1;
        }
        // Each has moved on to where the next one begins.
        first.rotate_right(1);
        first[0] = 0;
        Ok(Self { indices, first })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_are_ordered_by_key_and_among_equals_ascending() {
        let sorted = ByKey::new(&[3, 1, 0, 3, 1, 1], 5, "a test").unwrap();
        assert_eq!(sorted.indices, [2, 1, 4, 5, 0, 3]);
        assert_eq!(sorted.first, [0, 1, 4, 4, 6, 6]);
        let nothing = ByKey::new(&[], 0, "a test").unwrap();
        assert!(nothing.indices.is_empty() && nothing.first == [0]);
    }
}
