//! Threads, and sweeps over points whose results do not depend on how many there are.
//!
//! Points are swept in fixed blocks of the inner order. A sweep writes only to what belongs to its
//! own points; sums add up within a block and then block by block, in order.

mod pool;

use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::error::{Result, argument};
use pool::Pool;

/// Points that are swept by one thread in one go, and summed as one.
pub(crate) const BLOCK: usize = 256;

/// Most threads that a host may ask for.
pub(crate) const MOST_THREADS: usize = 4096;

/// Parts that a sweep is cut into at most; threads take one after the other.
const MOST_PARTS: usize = 64;

/// Values that a thread copies in one go.
const COPIED: usize = 1 << 15;

/// Points and what a sweep writes of them, until a thread takes both.
type Part<O> = Mutex<Option<(Range<usize>, O)>>;

/// What a sweep does with a block of points and what it writes of them.
type Leaf<'a, O> = &'a (dyn Fn(Range<usize>, O) + Sync);

/// The threads of one simulation.
pub(crate) struct Workers {
    pool: Pool,
}

/// What the environment says. A wrong number for this library is an error, one for OpenMP is left to OpenMP.
fn threads_by(own: Option<String>, openmp: Option<String>) -> Result<usize> {
    let number = |text: &str| {
        let number = text.trim().parse::<usize>().ok()?;
        (1..=MOST_THREADS).contains(&number).then_some(number)
    };
    if let Some(text) = own.filter(|text| !text.trim().is_empty()) {
        return number(&text).map_or_else(
            || {
                argument(format!(
                    "the environment has PERION_NUM_THREADS={text}; it must be 1 to {MOST_THREADS}"
                ))
            },
            Ok,
        );
    }
    let outer = openmp.and_then(|levels| number(levels.split(',').next()?));
    let cores = || std::thread::available_parallelism().map_or(1, Into::into);
    Ok(outer.unwrap_or_else(cores))
}

impl Workers {
    /// Starts as many threads as are missing to `threads`, the caller's own counted.
    pub(crate) fn new(threads: usize) -> Result<Self> {
        Ok(Self { pool: Pool::new(threads.max(1))? })
    }

    /// The number of threads that a host gets unless it says otherwise: `PERION_NUM_THREADS`,
    /// `OMP_NUM_THREADS`, else all cores.
    pub(crate) fn default_threads() -> Result<usize> {
        let of =
            |name: &str| std::env::var_os(name).map(|text| text.to_string_lossy().into_owned());
        threads_by(of("PERION_NUM_THREADS"), of("OMP_NUM_THREADS"))
    }

    /// Calls `leaf` for each block of points with the part of `outputs` that belongs to it.
    pub(crate) fn sweep<O: Outputs>(
        &self,
        points: usize,
        outputs: O,
        leaf: impl Fn(Range<usize>, O) + Sync,
    ) {
        self.sweep_parts(points, outputs, &leaf);
    }

    /// Compiled once for each kind of outputs: there are ten times as many leaves.
    fn sweep_parts<O: Outputs>(&self, points: usize, outputs: O, leaf: Leaf<'_, O>) {
        let threads = self.pool.threads();
        let count = block_count(points).min(8 * threads).min(MOST_PARTS);
        if threads == 1 || count < 2 {
            return divide(0..points, outputs, leaf);
        }
        let mut parts: [Part<O>; MOST_PARTS] = [const { Mutex::new(None) }; MOST_PARTS];
        share_out(0..points, outputs, &mut parts[..count]);
        let next = AtomicUsize::new(0);
        self.pool.run(&|| {
            while let Some(part) = parts[..count].get(next.fetch_add(1, Ordering::Relaxed)) {
                let taken = part.lock().unwrap_or_else(|poison| poison.into_inner()).take();
                if let Some((range, outputs)) = taken {
                    divide(range, outputs, leaf);
                }
            }
        });
    }

    /// Calls `leaf` for each `size` values and the number of the first of them.
    pub(crate) fn share<T: Send>(
        &self,
        values: &mut [T],
        size: usize,
        leaf: impl Fn(usize, &mut [T]) + Sync,
    ) {
        let alone = self.pool.threads() == 1 || values.len() <= size;
        let parts = Mutex::new(values.chunks_mut(size).enumerate());
        let work = || {
            loop {
                let next = parts.lock().unwrap_or_else(|poison| poison.into_inner()).next();
                let Some((number, part)) = next else { return };
                leaf(number * size, part);
            }
        };
        if alone {
            work();
        } else {
            self.pool.run(&work);
        }
    }

    /// Copies as many values as there are, all threads together.
    pub(crate) fn copy<T: Copy + Send + Sync>(&self, from: &[T], to: &mut [T]) {
        self.share(to, COPIED, |first, to| to.copy_from_slice(&from[first..first + to.len()]));
    }

    /// `count` copies of `value`, each page of which belongs to the thread that wrote it.
    pub(crate) fn filled<T: Copy + Send + Sync>(
        &self,
        value: T,
        count: usize,
        purpose: &'static str,
    ) -> Result<Vec<T>> {
        self.pool.filled(value, count, purpose)
    }

    /// The sum of `term` over all points, the same bits for any number of threads.
    pub(crate) fn sum(
        &self,
        points: usize,
        partial: &mut [f64],
        term: impl Fn(usize) -> f64 + Sync,
    ) -> f64 {
        self.sweep(points, PerBlock(&mut *partial), |range, PerBlock(partial)| {
            // Side by side, so that one does not wait for the other.
            let mut sums = [0.0; 4];
            let last = range.end - range.len() % sums.len();
            for first in (range.start..last).step_by(sums.len()) {
                for (place, sum) in sums.iter_mut().enumerate() {
                    *sum += term(first + place);
                }
            }
            let rest: f64 = (last..range.end).map(&term).sum();
            partial[0] = (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest;
        });
        partial[..block_count(points)].iter().sum()
    }
}

/// Number of blocks that `points` points make.
pub(crate) fn block_count(points: usize) -> usize {
    points.div_ceil(BLOCK)
}

/// Most parts that a sweep is cut into.
pub(crate) fn most_parts(points: usize) -> usize {
    block_count(points).clamp(1, MOST_PARTS)
}

/// Cuts a range of points between blocks, into as many parts as there is room for.
fn share_out<O: Outputs>(points: Range<usize>, outputs: O, parts: &mut [Part<O>]) {
    let [part] = parts else {
        let (fewer, more) = parts.split_at_mut(parts.len() / 2);
        let share = block_count(points.len()) * fewer.len() / (fewer.len() + more.len());
        let middle = points.start + share * BLOCK;
        let (low, high) = outputs.split(points.start, middle);
        share_out(points.start..middle, low, fewer);
        share_out(middle..points.end, high, more);
        return;
    };
    *part = Mutex::new(Some((points, outputs)));
}

/// Calls `leaf` block by block.
fn divide<O: Outputs>(points: Range<usize>, mut outputs: O, leaf: Leaf<'_, O>) {
    let mut start = points.start;
    while points.end - start > BLOCK {
        let (block, rest) = outputs.split(start, start + BLOCK);
        leaf(start..start + BLOCK, block);
        outputs = rest;
        start += BLOCK;
    }
    if start < points.end {
        leaf(start..points.end, outputs);
    }
}

/// What a sweep writes: it can be cut between two points.
pub(crate) trait Outputs: Sized + Send {
    /// Cuts what belongs to the points from `first` on, in front of point `at`.
    fn split(self, first: usize, at: usize) -> (Self, Self);
}

/// `width` values a point.
pub(crate) struct PerPoint<'a, T>(pub(crate) &'a mut [T], pub(crate) usize);

impl<T> PerPoint<'_, T> {
    /// The same values once more.
    pub(crate) fn again(&mut self) -> PerPoint<'_, T> {
        PerPoint(&mut *self.0, self.1)
    }
}

impl<T: Send> Outputs for PerPoint<'_, T> {
    fn split(self, first: usize, at: usize) -> (Self, Self) {
        let (low, high) = self.0.split_at_mut((at - first) * self.1);
        (PerPoint(low, self.1), PerPoint(high, self.1))
    }
}

/// Outputs of points that come one after the other; some may be left out.
pub(crate) struct PointByPoint<O> {
    rest: Option<O>,
    next: usize,
}

impl<O: Outputs> PointByPoint<O> {
    pub(crate) fn new(outputs: O, first: usize) -> Self {
        Self { rest: Some(outputs), next: first }
    }

    /// Hands over what belongs to a point.
    #[inline(always)]
    pub(crate) fn give(&mut self, point: usize, take: impl FnOnce(O)) {
        if let Some(rest) = self.rest.take() {
            let (own, rest) = rest.split(self.next, point).1.split(point, point + 1);
            (self.rest, self.next) = (Some(rest), point + 1);
            take(own);
        }
    }
}

/// One value a block of points.
pub(crate) struct PerBlock<'a, T>(pub(crate) &'a mut [T]);

impl<T: Send> Outputs for PerBlock<'_, T> {
    fn split(self, first: usize, at: usize) -> (Self, Self) {
        let (low, high) = self.0.split_at_mut((at - first) / BLOCK);
        (PerBlock(low), PerBlock(high))
    }
}

/// A varying number of values a point: those of point `i` are `offsets[i]..offsets[i + 1]`, times
/// `width`.
pub(crate) struct Ragged<'a, T> {
    pub(crate) values: &'a mut [T],
    pub(crate) offsets: &'a [u64],
    pub(crate) width: usize,
}

impl<T: Send> Outputs for Ragged<'_, T> {
    fn split(self, first: usize, at: usize) -> (Self, Self) {
        let middle = (self.offsets[at] - self.offsets[first]) as usize * self.width;
        let (low, high) = self.values.split_at_mut(middle);
        let Self { offsets, width, .. } = self;
        (Ragged { values: low, offsets, width }, Ragged { values: high, offsets, width })
    }
}

/// Nothing.
impl Outputs for () {
    fn split(self, _: usize, _: usize) -> (Self, Self) {
        ((), ())
    }
}

impl<A: Outputs> Outputs for Option<A> {
    fn split(self, first: usize, at: usize) -> (Self, Self) {
        match self {
            Some(outputs) => {
                let (low, high) = outputs.split(first, at);
                (Some(low), Some(high))
            }
            None => (None, None),
        }
    }
}

macro_rules! outputs_of_several {
    ($($name:ident),+) => {
        impl<$($name: Outputs),+> Outputs for ($($name,)+) {
            #[allow(non_snake_case)]
            fn split(self, first: usize, at: usize) -> (Self, Self) {
                let ($($name,)+) = self;
                $(let $name = $name.split(first, at);)+
                (($($name.0,)+), ($($name.1,)+))
            }
        }
    };
}
outputs_of_several!(A, B);
outputs_of_several!(A, B, C);
outputs_of_several!(A, B, C, E);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_have_the_same_bits_for_any_number_of_threads() {
        let points = 10 * BLOCK + 17;
        let mut partial = vec![0.0; block_count(points)];
        let term = |point: usize| (point as f64 * 0.1).sin() / 3.0;
        let expected = Workers::new(1).unwrap().sum(points, &mut partial, term);
        for threads in 2..5 {
            let workers = Workers::new(threads).unwrap();
            let sum = workers.sum(points, &mut partial, term);
            assert_eq!(sum.to_bits(), expected.to_bits());
        }
    }

    #[test]
    fn the_environment_says_how_many_threads_there_are() {
        let of = |own: &str, openmp: &str| {
            let given = |text: &str| (!text.is_empty()).then(|| text.to_owned());
            threads_by(given(own), given(openmp))
        };
        let cores = of("", "").unwrap();
        assert!(cores >= 1);
        for (own, openmp, expected) in
            [("3", "2", 3), (" 3 ", "", 3), ("", "4,2", 4), (" ", "2", 2), ("", "many", cores)]
        {
            assert_eq!(of(own, openmp).unwrap(), expected, "'{own}', '{openmp}'");
        }
        for wrong in ["many", "0", "-1", "4,2", "1.5", "5000"] {
            let error = of(wrong, "2").unwrap_err().to_string();
            assert!(error.contains(&format!("PERION_NUM_THREADS={wrong};")), "{error}");
        }
    }

    #[test]
    fn each_point_is_swept_once_with_its_own_outputs() {
        let offsets: Vec<u64> = (0..=1000).map(|point| point * (point + 1) / 2).collect();
        let mut ragged = vec![0_usize; 2 * offsets[1000] as usize];
        let mut pairs = vec![0_usize; 2000];
        let outputs =
            (PerPoint(&mut pairs, 2), Ragged { values: &mut ragged, offsets: &offsets, width: 2 });
        Workers::new(3).unwrap().sweep(1000, outputs, |range, (pairs, ragged)| {
            for (place, point) in range.clone().enumerate() {
                pairs.0[2 * place] += point;
                let start = 2 * (offsets[point] - offsets[range.start]) as usize;
                let end = 2 * (offsets[point + 1] - offsets[range.start]) as usize;
                ragged.values[start..end].iter_mut().for_each(|value| *value += point);
            }
        });
        assert!(pairs.chunks(2).enumerate().all(|(point, pair)| pair == [point, 0]));
        for point in 0..1000 {
            let own = &ragged[2 * offsets[point] as usize..2 * offsets[point + 1] as usize];
            assert!(own.iter().all(|&value| value == point));
        }
    }
}
