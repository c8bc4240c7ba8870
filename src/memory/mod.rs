//! Memory that grows with the input: every request may fail and says so, instead of aborting.
//!
//! Small allocations of fixed size (names, messages, one closure) are outside this promise.

use crate::error::{Error, Result};

/// An empty vector with room for `count` elements.
pub(crate) fn reserved<T>(count: usize, purpose: &'static str) -> Result<Vec<T>> {
    let mut buffer = Vec::new();
    grow(&mut buffer, count, purpose)?;
    Ok(buffer)
}

/// `count` copies of `value`.
#[allow(clippy::disallowed_methods)] // resizes within what was reserved
pub(crate) fn filled<T: Clone>(value: T, count: usize, purpose: &'static str) -> Result<Vec<T>> {
    let mut buffer = reserved(count, purpose)?;
    buffer.resize(count, value);
    Ok(buffer)
}

/// A copy of `values`.
pub(crate) fn copied<T: Copy>(values: &[T], purpose: &'static str) -> Result<Vec<T>> {
    let mut buffer = reserved(values.len(), purpose)?;
    buffer.extend_from_slice(values);
    Ok(buffer)
}

/// All that `values` yields; its exact length is reserved first.
pub(crate) fn collected<T>(
    values: impl ExactSizeIterator<Item = T>,
    purpose: &'static str,
) -> Result<Vec<T>> {
    let mut buffer = reserved(values.len(), purpose)?;
    buffer.extend(values);
    Ok(buffer)
}

/// Appends one element, growing by doubling.
pub(crate) fn push<T>(buffer: &mut Vec<T>, value: T, purpose: &'static str) -> Result<()> {
    if buffer.len() == buffer.capacity() {
        grow(buffer, buffer.len().max(4), purpose)?;
    }
    buffer.push(value);
    Ok(())
}

fn grow<T>(buffer: &mut Vec<T>, additional: usize, purpose: &'static str) -> Result<()> {
    buffer
        .try_reserve_exact(additional)
        .map_err(|_| Error::Memory { bytes: additional.saturating_mul(size_of::<T>()), purpose })
}

/// Bytes that a vector holds on the heap.
pub(crate) fn bytes<T>(buffer: &Vec<T>) -> usize {
    buffer.capacity() * size_of::<T>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_beyond_all_memory_is_an_error_that_says_how_much() {
        let error = filled(0.0_f64, isize::MAX as usize / 4, "a test").unwrap_err();
        assert!(matches!(error, Error::Memory { purpose: "a test", .. }), "{error}");
        assert!(error.to_string().contains("for a test"));
    }

    #[test]
    fn push_keeps_the_order() {
        let mut values = Vec::new();
        for k in 0..100 {
            push(&mut values, k, "a test").unwrap();
        }
        assert!(values.iter().copied().eq(0..100));
    }
}
