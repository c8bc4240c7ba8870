//! Threads, and sweeps over points whose results do not depend on how many there are.
//!
//! Points are swept in fixed blocks of the inner order. A sweep writes only to what belongs to its
//! own points; sums add up within a block and then block by block, in order.

use std::ops::Range;
use std::sync::Mutex;
use std::thread::JoinHandle;

use crate::error::{Error, Result};
use crate::memory;

/// Points that are swept by one thread in one go, and summed as one.
pub(crate) const BLOCK: usize = 256;

/// Most threads that a host may ask for.
pub(crate) const MOST_THREADS: usize = 4096;

/// The threads of one simulation. One thread needs none but the caller's.
pub(crate) struct Workers {
    pool: Option<rayon::ThreadPool>,
    handles: Vec<JoinHandle<()>>,
}

impl Workers {
    /// Starts `threads` workers, or none for one thread.
    pub(crate) fn new(threads: usize) -> Result<Self> {
        if threads <= 1 {
            return Ok(Self { pool: None, handles: Vec::new() });
        }
        let handles = Mutex::new(memory::reserved(threads, "threads")?);
        let built = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .spawn_handler(|worker| {
                let name = format!("perion-worker-{}", worker.index());
                let handle = std::thread::Builder::new().name(name).spawn(move || worker.run())?;
                lock(&handles).push(handle);
                Ok(())
            })
            .build();
        let handles = handles.into_inner().unwrap_or_else(|poison| poison.into_inner());
        match built {
            Ok(pool) => Ok(Self { pool: Some(pool), handles }),
            Err(error) => {
                join(handles);
                Err(Error::State(format!("{threads} threads could not be started: {error}")))
            }
        }
    }

    /// The number of threads that a host gets unless it says otherwise: `PERION_NUM_THREADS`,
    /// `OMP_NUM_THREADS`, else all cores.
    pub(crate) fn default_threads() -> usize {
        let from = |name: &str| {
            let text = std::env::var(name).ok()?;
            let first = text.split(',').next()?.trim().parse::<usize>().ok()?;
            (1..=MOST_THREADS).contains(&first).then_some(first)
        };
        from("PERION_NUM_THREADS")
            .or_else(|| from("OMP_NUM_THREADS"))
            .or_else(|| std::thread::available_parallelism().ok().map(Into::into))
            .unwrap_or(1)
    }

    #[cfg(test)]
    pub(crate) fn threads(&self) -> usize {
        self.handles.len().max(1)
    }

    /// Runs `work` on one of the workers, so that the sweeps in it start without a hand-over each.
    pub(crate) fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Calls `leaf` for each block of points with the part of `outputs` that belongs to it.
    pub(crate) fn sweep<O: Outputs>(
        &self,
        points: usize,
        outputs: O,
        leaf: impl Fn(Range<usize>, O) + Sync,
    ) {
        match &self.pool {
            Some(pool) => pool.install(|| divide::<O, true>(0..points, outputs, &leaf)),
            None => divide::<O, false>(0..points, outputs, &leaf),
        }
    }

    /// The sum of `term` over all points, the same bits for any number of threads.
    pub(crate) fn sum(
        &self,
        points: usize,
        partial: &mut [f64],
        term: impl Fn(usize) -> f64 + Sync,
    ) -> f64 {
        self.sweep(points, PerBlock(&mut *partial), |range, PerBlock(partial)| {
            partial[0] = range.map(&term).sum();
        });
        partial[..block_count(points)].iter().sum()
    }
}

/// Number of blocks that `points` points make.
pub(crate) fn block_count(points: usize) -> usize {
    points.div_ceil(BLOCK)
}

impl Drop for Workers {
    fn drop(&mut self) {
        // Ends the pool's threads, which then can be waited for: none outlives the simulation.
        self.pool = None;
        join(std::mem::take(&mut self.handles));
    }
}

fn join(handles: Vec<JoinHandle<()>>) {
    for handle in handles {
        // A worker that panicked has reported it through the sweep already.
        let _ = handle.join();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poison| poison.into_inner())
}

fn divide<O: Outputs, const PARALLEL: bool>(
    points: Range<usize>,
    outputs: O,
    leaf: &(impl Fn(Range<usize>, O) + Sync),
) {
    let blocks = block_count(points.len());
    if blocks <= 1 {
        if blocks == 1 {
            leaf(points, outputs);
        }
        return;
    }
    let middle = points.start + blocks / 2 * BLOCK;
    let (low, high) = outputs.split(points.start, middle);
    if PARALLEL {
        rayon::join(
            || divide::<O, PARALLEL>(points.start..middle, low, leaf),
            || divide::<O, PARALLEL>(middle..points.end, high, leaf),
        );
    } else {
        divide::<O, PARALLEL>(points.start..middle, low, leaf);
        divide::<O, PARALLEL>(middle..points.end, high, leaf);
    }
}

/// What a sweep writes: it can be cut between two points.
pub(crate) trait Outputs: Sized + Send {
    /// Cuts what belongs to the points from `first` on, in front of point `at`.
    fn split(self, first: usize, at: usize) -> (Self, Self);
}

/// `width` values a point.
pub(crate) struct PerPoint<'a, T>(pub(crate) &'a mut [T], pub(crate) usize);

impl<T: Send> Outputs for PerPoint<'_, T> {
    fn split(self, first: usize, at: usize) -> (Self, Self) {
        let (low, high) = self.0.split_at_mut((at - first) * self.1);
        (PerPoint(low, self.1), PerPoint(high, self.1))
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
            assert_eq!(workers.threads(), threads);
            let sum = workers.sum(points, &mut partial, term);
            assert_eq!(sum.to_bits(), expected.to_bits());
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
