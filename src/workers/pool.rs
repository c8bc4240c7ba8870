//! The threads of one simulation, and how a job that borrows from its caller runs on all of them.
//!
//! The caller works along as one of them, so that one thread needs no other. Nothing is allocated to
//! start a job. Threads wait for the next job, and the caller for the last thread, awake for a few microseconds and then asleep.

use std::any::Any;
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::thread::JoinHandle;

use crate::error::{Error, Result};
use crate::memory;

/// Numbers that a thread writes in one go where memory is filled.
const CHUNK: usize = 1 << 16;

/// Looks at the counters of jobs before a thread or a caller goes to sleep.
const LOOKS: u32 = 2000;

/// Looks of a caller at least, so that it comes to wait longer again where that helps.
const LEAST_LOOKS: u32 = 64;

pub(super) struct Pool {
    shared: Arc<Shared>,
    handles: Vec<JoinHandle<()>>,
    /// Looks of a caller before it sleeps.
    patience: AtomicU32,
    /// Held by the caller whose job the threads run.
    entry: Mutex<()>,
}

struct Shared {
    orders: Mutex<Orders>,
    /// Tells sleeping threads of a new job, or of the end.
    changed: Condvar,
    /// Tells the caller that all threads have done their part.
    finished: Condvar,
    /// Number of jobs so far: what waiting threads look at.
    jobs: AtomicU64,
    /// Number of jobs that all threads have done: what a waiting caller looks at.
    done: AtomicU64,
    /// Looks before sleeping; none when there are more threads than cores.
    looks: u32,
}

struct Orders {
    job: Option<Job>,
    /// Number of jobs so far.
    number: u64,
    /// Threads that have not yet done their part of the job.
    working: usize,
    panic: Option<Box<dyn Any + Send>>,
    ended: bool,
}

/// A job that every thread runs once; it shares its work out by itself.
#[derive(Clone, Copy)]
struct Job(*const (dyn Fn() + Sync));

// SAFETY: what it points to is `Sync`, and `Pool::run` keeps it alive until no thread uses it.
unsafe impl Send for Job {}

impl Pool {
    /// A pool in which `threads` threads work, the caller among them.
    pub(super) fn new(threads: usize) -> Result<Self> {
        let cores = std::thread::available_parallelism().map_or(1, Into::into);
        let orders = Orders { job: None, number: 0, working: 0, panic: None, ended: false };
        let shared = Arc::new(Shared {
            orders: Mutex::new(orders),
            changed: Condvar::new(),
            finished: Condvar::new(),
            jobs: AtomicU64::new(0),
            done: AtomicU64::new(0),
            looks: if 1 < threads && threads <= cores { LOOKS } else { 0 },
        });
        let handles = memory::reserved(threads - 1, "threads")?;
        let mut pool =
            Self { patience: AtomicU32::new(shared.looks), shared, handles, entry: Mutex::new(()) };
        for number in 1..threads {
            let shared = Arc::clone(&pool.shared);
            let thread = std::thread::Builder::new().name(format!("perion-worker-{number}"));
            let handle = thread.spawn(move || shared.serve()).map_err(|error| {
                Error::State(format!("thread {number} of {threads} could not be started: {error}"))
            })?;
            pool.handles.push(handle);
        }
        Ok(pool)
    }

    /// Number of threads that work, the caller among them.
    pub(super) fn threads(&self) -> usize {
        self.handles.len() + 1
    }

    /// Runs `job` once on each thread, and returns when all are done. While another caller has the
    /// threads, it runs on the caller's alone.
    pub(super) fn run(&self, job: &(dyn Fn() + Sync)) {
        let Ok(_entry) = self.entry.try_lock() else { return job() };
        let pointer: *const (dyn Fn() + Sync + '_) = job;
        // SAFETY: only the lifetime changes; the pointer is not used after this function, which does not
        // end before all threads are done with it.
        let pointer: *const (dyn Fn() + Sync + 'static) = unsafe { std::mem::transmute(pointer) };
        let number = {
            let mut orders = self.shared.lock();
            orders.job = Some(Job(pointer));
            orders.working = self.handles.len();
            orders.number += 1;
            self.shared.jobs.store(orders.number, Ordering::Release);
            orders.number
        };
        self.shared.changed.notify_all();
        let own = catch_unwind(AssertUnwindSafe(job));
        self.wait_awake(number);
        let mut orders = self.shared.lock();
        while orders.working > 0 {
            orders = wait(&self.shared.finished, orders);
        }
        orders.job = None;
        let panic = own.err().or(orders.panic.take());
        drop(orders);
        drop(_entry);
        if let Some(payload) = panic {
            resume_unwind(payload);
        }
    }

    /// Waits awake until a job is done, or for a while: shorter after it was in vain, as where others keep the cores busy and a
    /// thread that waits takes the time of one that works.
    fn wait_awake(&self, job: u64) {
        let looks = self.patience.load(Ordering::Relaxed);
        let is_done = Shared::look(looks, || self.shared.done.load(Ordering::Acquire) >= job);
        let next = if is_done { 2 * looks } else { (looks / 4).max(LEAST_LOOKS) };
        self.patience.store(next.min(self.shared.looks), Ordering::Relaxed);
    }

    /// `count` copies of `value`, written by all threads: the system gives a page to the thread that touches it first, and
    /// clears it then.
    pub(super) fn filled<T: Copy + Send + Sync>(
        &self,
        value: T,
        count: usize,
        purpose: &'static str,
    ) -> Result<Vec<T>> {
        let mut buffer: Vec<T> = memory::reserved(count, purpose)?;
        let chunks = Mutex::new(buffer.spare_capacity_mut()[..count].chunks_mut(CHUNK));
        let next = || chunks.lock().unwrap_or_else(|poison| poison.into_inner()).next();
        self.run(&|| {
            while let Some(chunk) = next() {
                chunk.fill(MaybeUninit::new(value));
            }
        });
        // SAFETY: there is room for `count`, and all chunks of it have been written.
        unsafe { buffer.set_len(count) };
        Ok(buffer)
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        self.shared.lock().ended = true;
        // Whoever looks at the counter instead of sleeping takes the lock then, and sees the end.
        self.shared.jobs.fetch_add(1, Ordering::Release);
        self.shared.changed.notify_all();
        for handle in self.handles.drain(..) {
            // A thread contains the panics of its jobs.
            let _ = handle.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Orders> {
        self.orders.lock().unwrap_or_else(|poison| poison.into_inner())
    }

    /// What each thread does: one job after the other, until the end.
    fn serve(&self) {
        let mut done = 0;
        while let Some((Job(job), number)) = self.next(done) {
            // SAFETY: `Pool::run` waits until this thread has counted itself off below.
            let result = catch_unwind(AssertUnwindSafe(|| unsafe { (*job)() }));
            done = number;
            let mut orders = self.lock();
            if let Err(payload) = result {
                orders.panic.get_or_insert(payload);
            }
            orders.working -= 1;
            if orders.working == 0 {
                self.done.store(number, Ordering::Release);
                self.finished.notify_one();
            }
        }
    }

    /// Looks until what is wanted has come, but only so many times; whether it has.
    fn look(looks: u32, has_come: impl Fn() -> bool) -> bool {
        for _ in 0..looks {
            if has_come() {
                return true;
            }
            std::hint::spin_loop();
        }
        has_come()
    }

    /// The first job after number `done`, or `None` at the end.
    fn next(&self, done: u64) -> Option<(Job, u64)> {
        Self::look(self.looks, || self.jobs.load(Ordering::Acquire) != done);
        let mut orders = self.lock();
        loop {
            if orders.ended {
                return None;
            }
            match orders.job {
                Some(job) if orders.number != done => return Some((job, orders.number)),
                _ => orders = wait(&self.changed, orders),
            }
        }
    }
}

fn wait<'a>(condition: &Condvar, orders: MutexGuard<'a, Orders>) -> MutexGuard<'a, Orders> {
    condition.wait(orders).unwrap_or_else(|poison| poison.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    #[test]
    fn memory_is_filled_to_its_end_and_no_farther() {
        for count in [0, 1, CHUNK, 3 * CHUNK + 5] {
            let filled = Pool::new(3).unwrap().filled(7_u32, count, "a test").unwrap();
            assert_eq!(filled.len(), count);
            assert!(filled.iter().all(|&value| value == 7));
        }
        assert!(Pool::new(2).unwrap().filled(0.0_f64, usize::MAX / 32, "a test").is_err());
    }

    #[test]
    fn every_thread_runs_each_job_once() {
        for threads in 1..6 {
            let pool = Pool::new(threads).unwrap();
            for _ in 0..500 {
                let runs = AtomicUsize::new(0);
                pool.run(&|| {
                    runs.fetch_add(1, Ordering::Relaxed);
                });
                assert_eq!(runs.into_inner(), threads);
            }
        }
    }

    #[test]
    fn a_panic_on_any_thread_reaches_the_caller_and_the_pool_goes_on() {
        let pool = Pool::new(3).unwrap();
        for victim in 0..3 {
            let order = AtomicUsize::new(0);
            let job = || {
                if order.fetch_add(1, Ordering::Relaxed) == victim {
                    resume_unwind(Box::new("broken"));
                }
            };
            let payload = catch_unwind(AssertUnwindSafe(|| pool.run(&job))).unwrap_err();
            assert_eq!(payload.downcast_ref::<&str>(), Some(&"broken"));
        }
        pool.run(&|| ());
    }

    #[test]
    fn callers_at_once_do_not_wait_for_each_other() {
        let pool = Pool::new(2).unwrap();
        let total = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..200 {
                        let runs = AtomicUsize::new(0);
                        pool.run(&|| {
                            runs.fetch_add(1, Ordering::Relaxed);
                        });
                        assert!((1..=2).contains(&runs.into_inner()));
                        total.fetch_add(1, Ordering::Relaxed);
                    }
                });
            }
        });
        assert_eq!(total.into_inner(), 800);
    }
}
