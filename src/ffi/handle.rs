//! Handles: objects of the library behind opaque pointers, with the checks that C cannot make.
//!
//! A magic word tells a handle of the right type from anything else, an access word lets either
//! any number of readers or one writer in and refuses the others at once, and a flag remembers
//! that a panic left the object half-way through a change.

use std::cell::UnsafeCell;
use std::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64};

use super::guard::Failure;
use crate::error::{Error, argument};

/// An opaque type of the C interface: `pub struct perion_points(Handle<Points>);`.
pub(crate) trait Opaque: Sized {
    /// What is behind the pointer: any thread may hold, share and destroy it.
    type Value: Send + Sync;
    /// The name of the C type without its prefix, and so that of the argument.
    const NAME: &'static str;
    /// Distinct for each type.
    const MAGIC: u64;
    /// Wraps a new handle.
    fn wrap(handle: Handle<Self::Value>) -> Self;
    /// The handle within.
    fn handle(&self) -> &Handle<Self::Value>;
}

/// The object and its guards. The magic word is first, where that of any other handle is, too.
#[repr(C)]
pub(crate) struct Handle<T> {
    magic: AtomicU64,
    /// `IDLE`, the number of readers, with `WAITING` where a writer waits for them, or `EXCLUSIVE`.
    access: AtomicU32,
    poisoned: AtomicBool,
    value: UnsafeCell<T>,
}

const IDLE: u32 = 0;
const EXCLUSIVE: u32 = u32::MAX;
/// A writer waits: no new reader is let in.
const WAITING: u32 = 1 << 31;

// SAFETY: `value` is reached through `access` alone, which is a lock for readers and writers.
unsafe impl<T: Send + Sync> Sync for Handle<T> {}

/// Makes an object and writes its handle to `out`, on success only.
///
/// # Safety
/// `out` is NULL or leads to room for a pointer that nothing else uses meanwhile.
pub(crate) unsafe fn create<X: Opaque>(
    out: *mut *mut X,
    make: impl FnOnce() -> Result<X::Value, Failure>,
) -> Result<(), Failure> {
    // An X has no room for anything before its handle, so it starts with the magic word.
    const { assert!(size_of::<X>() == size_of::<Handle<X::Value>>()) };
    // SAFETY: the caller's promise.
    let out = unsafe { super::arguments::output(out, X::NAME) }?;
    let object = X::wrap(Handle {
        magic: AtomicU64::new(X::MAGIC),
        access: AtomicU32::new(IDLE),
        poisoned: AtomicBool::new(false),
        value: UnsafeCell::new(make()?),
    });
    out.write(Box::into_raw(Box::new(object)));
    Ok(())
}

/// Reads the object; any number of readers may overlap.
///
/// # Safety
/// `pointer` is NULL, or came from a `create` of any type and is not destroyed meanwhile.
pub(crate) unsafe fn shared<X: Opaque, R>(
    pointer: *const X,
    body: impl FnOnce(&X::Value) -> Result<R, Failure>,
) -> Result<R, Failure> {
    // SAFETY: the caller's promise.
    unsafe { Session::read(pointer) }?.unless_poisoned()?.with(body)
}

/// As [`shared`], and for a poisoned object as well: it shows its last completed step.
///
/// # Safety
/// As for [`shared`].
pub(crate) unsafe fn shared_even_poisoned<X: Opaque, R>(
    pointer: *const X,
    body: impl FnOnce(&X::Value) -> Result<R, Failure>,
) -> Result<R, Failure> {
    // SAFETY: the caller's promise.
    unsafe { Session::read(pointer) }?.with(body)
}

/// Changes the object, alone; a panic in `body` poisons it.
///
/// # Safety
/// As for [`shared`].
pub(crate) unsafe fn exclusive<X: Opaque, R>(
    pointer: *mut X,
    body: impl FnOnce(&mut X::Value) -> Result<R, Failure>,
) -> Result<R, Failure> {
    // SAFETY: the caller's promise.
    unsafe { Session::begin(pointer) }?.with_mut(body)
}

/// Frees the object and sets the host's pointer to NULL. NULL, or the address of NULL, is fine, and
/// so is a poisoned object; one that is in use stays as it is.
///
/// # Safety
/// `slot` is NULL or leads to a pointer that is NULL or came from a `create` of any type.
pub(crate) unsafe fn destroy<X: Opaque>(slot: *mut *mut X) -> Result<(), Failure> {
    // SAFETY: the caller's promise; NULL is no slot.
    let Some(slot) = (unsafe { slot.as_mut() }).filter(|slot| !slot.is_null()) else {
        return Ok(());
    };
    // SAFETY: the caller's promise.
    let session = unsafe { Session::<X>::alone(*slot) }?;
    session.handle.magic.store(!X::MAGIC, Release);
    // The access word stays exclusive: what it would be released in is about to go.
    std::mem::forget(session);
    // Before the drop, so that a panic in it leaves no pointer to what is gone.
    let object = std::mem::replace(slot, std::ptr::null_mut());
    // SAFETY: `create` made it from a box, and no other call is in it.
    drop(unsafe { Box::from_raw(object) });
    Ok(())
}

/// A hold on the object for the length of a call that runs the host's callbacks in between.
pub(crate) struct Session<'a, X: Opaque> {
    handle: &'a Handle<X::Value>,
    /// This session's share of the access word.
    held: u32,
}

impl<'a, X: Opaque + 'a> Session<'a, X> {
    /// Keeps every other call on the object out until the session is dropped.
    ///
    /// # Safety
    /// As for [`shared`], for as long as the session lives.
    pub(crate) unsafe fn begin(pointer: *mut X) -> Result<Self, Failure> {
        // SAFETY: the caller's promise.
        unsafe { Self::alone(pointer) }?.unless_poisoned()
    }

    /// Changes the object; a panic in `body` poisons it.
    pub(crate) fn with_mut<R>(
        &mut self,
        body: impl FnOnce(&mut X::Value) -> Result<R, Failure>,
    ) -> Result<R, Failure> {
        self.exclude_others()?;
        self.handle.poisoned.store(true, Relaxed);
        // SAFETY: the access word keeps every other call out, and `&mut self` this session's own.
        let result = body(unsafe { &mut *self.handle.value.get() });
        self.handle.poisoned.store(false, Relaxed);
        result
    }

    /// Runs `callback` while other calls may read the object, but not change it. Waits for those that
    /// still read when it returns.
    pub(crate) fn while_shared<R>(&mut self, callback: impl FnOnce() -> R) -> Result<R, Failure> {
        self.exclude_others()?;
        self.held = 1;
        self.handle.access.store(self.held, Release);
        let result = callback();
        self.handle.access.fetch_or(WAITING, Relaxed);
        while self
            .handle
            .access
            .compare_exchange_weak(WAITING | self.held, EXCLUSIVE, Acquire, Relaxed)
            .is_err()
        {
            std::thread::yield_now();
        }
        self.held = EXCLUSIVE;
        Ok(result)
    }

    /// # Safety
    /// As for [`shared`], for as long as the session lives.
    unsafe fn read(pointer: *const X) -> Result<Self, Failure> {
        // SAFETY: the caller's promise.
        let handle = unsafe { live::<X>(pointer) }?;
        let one_more = |word| (word < WAITING - 1).then(|| word + 1);
        let entered = handle.access.fetch_update(Acquire, Relaxed, one_more);
        entered.map(|_| Self { handle, held: 1 }).map_err(|_| in_use(X::NAME))
    }

    /// # Safety
    /// As for [`shared`], for as long as the session lives.
    unsafe fn alone(pointer: *const X) -> Result<Self, Failure> {
        // SAFETY: the caller's promise.
        let mut session = Self { handle: unsafe { live::<X>(pointer) }?, held: IDLE };
        session.exclude_others()?;
        Ok(session)
    }

    fn exclude_others(&mut self) -> Result<(), Failure> {
        if self.held != EXCLUSIVE {
            let entered =
                self.handle.access.compare_exchange(self.held, EXCLUSIVE, Acquire, Relaxed);
            entered.map_err(|_| in_use(X::NAME))?;
            self.held = EXCLUSIVE;
        }
        Ok(())
    }

    fn unless_poisoned(self) -> Result<Self, Failure> {
        let poisoned = self.handle.poisoned.load(Relaxed);
        if poisoned { Err(Failure::Poisoned { object: X::NAME }) } else { Ok(self) }
    }

    fn with<R>(&self, body: impl FnOnce(&X::Value) -> Result<R, Failure>) -> Result<R, Failure> {
        // SAFETY: the session is one of the readers, and no writer is let in while one is.
        body(unsafe { &*self.handle.value.get() })
    }
}

impl<X: Opaque> Drop for Session<'_, X> {
    fn drop(&mut self) {
        self.handle.access.fetch_sub(self.held, Release);
    }
}

/// The handle behind a pointer, once it is seen to be one of this type.
///
/// # Safety
/// As for [`shared`].
unsafe fn live<'a, X: Opaque + 'a>(pointer: *const X) -> Result<&'a Handle<X::Value>, Failure> {
    if pointer.is_null() {
        return Err(Failure::Null { argument: X::NAME });
    }
    // SAFETY: a handle of any type starts with its magic word, and an object of another type may
    // be smaller than an X: only the word is looked at.
    let magic = || unsafe { &*pointer.cast::<AtomicU64>() }.load(Acquire);
    if !pointer.is_aligned() || magic() != X::MAGIC {
        return Ok(argument(format!("'{0}' is not a live perion_{0} handle", X::NAME))?);
    }
    // SAFETY: the magic word says that it is an X, and the caller that it is not destroyed.
    Ok(unsafe { &*pointer }.handle())
}

fn in_use(name: &str) -> Failure {
    let rule = "one handle, one thread at a time";
    Error::State(format!("'{name}' is in use by another call; {rule}")).into()
}

#[cfg(test)]
mod tests;
