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
    /// `IDLE`, the number of readers, or `EXCLUSIVE`.
    access: AtomicU32,
    poisoned: AtomicBool,
    value: UnsafeCell<T>,
}

const IDLE: u32 = 0;
const EXCLUSIVE: u32 = u32::MAX;

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

    /// Runs `callback` while other calls may read the object, but not change it.
    ///
    /// Fails if one of them, on another thread, is still reading when the callback returns.
    pub(crate) fn while_shared<R>(&mut self, callback: impl FnOnce() -> R) -> Result<R, Failure> {
        self.exclude_others()?;
        self.held = 1;
        self.handle.access.store(self.held, Release);
        let result = callback();
        self.exclude_others()?;
        Ok(result)
    }

    /// # Safety
    /// As for [`shared`], for as long as the session lives.
    unsafe fn read(pointer: *const X) -> Result<Self, Failure> {
        // SAFETY: the caller's promise.
        let handle = unsafe { live::<X>(pointer) }?;
        let one_more = |word| (word < EXCLUSIVE - 1).then(|| word + 1);
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
mod tests {
    use super::super::guard::guard;
    use super::super::status::{PERION_ERROR_INTERNAL, PERION_ERROR_POISONED};
    use super::*;
    use std::ptr::{null_mut, without_provenance_mut};
    use std::sync::mpsc::channel;
    use std::thread;

    const BUSY: &str = "'plate' is in use by another call; one handle, one thread at a time";

    /// The object of the tests; a negative one fails in its drop.
    struct Count(i64);

    impl Drop for Count {
        fn drop(&mut self) {
            assert!(self.0 >= 0, "a defect in a drop");
        }
    }

    struct Object<const MAGIC: u64>(Handle<Count>);
    type Plate = Object<1>;
    type Rod = Object<2>;

    impl<const MAGIC: u64> Opaque for Object<MAGIC> {
        type Value = Count;
        const NAME: &'static str = if MAGIC == 1 { "plate" } else { "rod" };
        const MAGIC: u64 = MAGIC;
        fn wrap(handle: Handle<Count>) -> Self {
            Self(handle)
        }
        fn handle(&self) -> &Handle<Count> {
            &self.0
        }
    }

    /// A host's copy of the pointer, on any thread; the tests destroy last.
    #[derive(Clone, Copy)]
    struct Host(*mut Plate);

    // SAFETY: a handle may be used from any thread.
    unsafe impl Send for Host {}

    impl Host {
        fn new(count: i64) -> Self {
            let mut plate = null_mut();
            // SAFETY: room for one pointer.
            unsafe { create::<Plate>(&raw mut plate, || Ok(Count(count))) }.unwrap();
            Self(plate)
        }
        fn get(self) -> Result<i64, Failure> {
            // SAFETY: live.
            unsafe { shared(self.0, |count| Ok(count.0)) }
        }
        fn change(self, body: impl FnOnce(&mut Count)) -> Result<(), Failure> {
            let body = |count: &mut Count| {
                body(count);
                Ok(())
            };
            // SAFETY: live.
            unsafe { exclusive(self.0, body) }
        }
        fn session(self) -> Session<'static, Plate> {
            // SAFETY: live.
            unsafe { Session::begin(self.0) }.unwrap()
        }
        fn destroy(mut self) -> Result<*mut Plate, Failure> {
            // SAFETY: live.
            unsafe { destroy(&raw mut self.0) }.map(|()| self.0)
        }
    }

    fn refusal<T>(result: Result<T, Failure>) -> String {
        result.err().unwrap().to_string()
    }

    #[test]
    fn an_object_is_made_read_changed_and_destroyed_and_null_is_no_object_to_destroy() {
        let plate = Host::new(3);
        plate.change(|count| count.0 += 1).unwrap();
        assert_eq!(plate.get().unwrap(), 4);
        assert!(plate.destroy().unwrap().is_null());
        assert!(Host(null_mut()).destroy().unwrap().is_null());
        // SAFETY: NULL.
        unsafe { destroy::<Plate>(null_mut()) }.unwrap();
    }

    #[test]
    fn an_output_is_checked_first_and_written_on_success_only() {
        // SAFETY: NULL.
        let refused = unsafe { create::<Plate>(null_mut(), || unreachable!()) };
        assert_eq!(refusal(refused), "argument 'plate' is NULL");

        let mut plate = without_provenance_mut::<Plate>(8);
        // SAFETY: room for one pointer.
        let refused = unsafe { create(&raw mut plate, || Ok(argument("no points")?)) };
        assert_eq!((refusal(refused).as_str(), plate.addr()), ("no points", 8));
    }

    #[test]
    fn a_pointer_that_is_no_live_handle_of_the_type_is_refused() {
        let mut rod = null_mut();
        // SAFETY: room for one pointer.
        unsafe { create::<Rod>(&raw mut rod, || Ok(Count(0))) }.unwrap();
        let other = "'plate' is not a live perion_plate handle";
        let wrong = Host(rod.cast());
        assert_eq!(refusal(wrong.get()), other);
        assert_eq!(refusal(wrong.change(|_| {})), other);
        assert_eq!(refusal(wrong.destroy()), other);
        assert_eq!(refusal(Host(without_provenance_mut(3)).get()), other);
        assert_eq!(refusal(Host(null_mut()).get()), "argument 'plate' is NULL");
        // SAFETY: live.
        unsafe { destroy(&raw mut rod) }.unwrap();
    }

    #[test]
    fn a_second_thread_on_one_handle_is_told_so_and_does_not_wait() {
        let plate = Host::new(0);
        let (inside, entered) = channel();
        let (leave, left) = channel::<()>();
        let writer = thread::spawn(move || {
            let plate = plate;
            plate.change(|_| {
                inside.send(()).unwrap();
                left.recv().unwrap();
            })
        });
        entered.recv().unwrap();
        assert_eq!(refusal(plate.get()), BUSY);
        assert_eq!(refusal(plate.change(|_| {})), BUSY);
        assert_eq!(refusal(plate.destroy()), BUSY);
        leave.send(()).unwrap();
        writer.join().unwrap().unwrap();
        plate.destroy().unwrap();
    }

    #[test]
    fn readers_overlap_and_keep_writers_out() {
        let plate = Host::new(7);
        // SAFETY: live.
        let reader = unsafe { Session::read(plate.0) }.unwrap();
        assert_eq!(plate.get().unwrap(), 7);
        assert_eq!(refusal(plate.change(|_| {})), BUSY);
        assert_eq!(refusal(plate.destroy()), BUSY);
        drop(reader);
        plate.destroy().unwrap();
    }

    #[test]
    fn a_panic_poisons_and_what_is_there_can_still_be_read_and_destroyed() {
        let plate = Host::new(1);
        let body = |count: &mut Count| {
            count.0 = 2;
            panic!("half-way");
        };
        assert_eq!(guard("perion_test", || plate.change(body)), PERION_ERROR_INTERNAL);
        assert!(refusal(plate.get()).starts_with("'plate' is poisoned"));
        assert_eq!(guard("perion_test", || plate.change(|_| {})), PERION_ERROR_POISONED);
        // SAFETY: live.
        assert_eq!(unsafe { shared_even_poisoned(plate.0, |count| Ok(count.0)) }.unwrap(), 2);
        assert!(plate.destroy().unwrap().is_null());
    }

    #[test]
    fn a_refused_change_and_a_panic_of_a_reader_poison_nothing() {
        let plate = Host::new(1);
        // SAFETY: live.
        let refused = unsafe { exclusive(plate.0, |_| Ok(argument::<()>("no")?)) };
        assert_eq!(refusal(refused), "no");
        // SAFETY: live.
        guard("perion_test", || unsafe { shared(plate.0, |_| panic!("a defect")) });
        plate.change(|_| {}).unwrap();
        plate.destroy().unwrap();
    }

    #[test]
    fn a_panic_while_the_object_is_dropped_leaves_no_pointer_to_it() {
        let mut plate = Host::new(-1);
        // SAFETY: live.
        let status = guard("perion_test", || unsafe { destroy(&raw mut plate.0) });
        assert_eq!((status, plate.0), (PERION_ERROR_INTERNAL, null_mut()));
    }

    #[test]
    fn a_callback_of_a_session_can_read_and_cannot_write() {
        let plate = Host::new(0);
        let mut session = plate.session();
        let callback = || {
            assert_eq!(plate.get().unwrap(), 5);
            assert_eq!(refusal(plate.change(|_| {})), BUSY);
            assert_eq!(refusal(plate.destroy()), BUSY);
        };
        session.with_mut(|count| Ok(std::mem::replace(&mut count.0, 5))).unwrap();
        session.while_shared(callback).unwrap();
        assert_eq!(refusal(plate.get()), BUSY);
        drop(session);
        plate.change(|_| {}).unwrap();
        plate.destroy().unwrap();
    }

    #[test]
    fn a_session_refuses_to_go_on_while_a_reader_from_a_callback_is_still_in() {
        let plate = Host::new(0);
        let mut session = plate.session();
        let mut reader = None;
        // SAFETY: live.
        let enter = || reader = Some(unsafe { Session::read(plate.0) }.unwrap());
        assert_eq!(refusal(session.while_shared(enter)), BUSY);
        assert_eq!(refusal(session.with_mut(|_| Ok(()))), BUSY);
        drop(reader);
        session.with_mut(|_| Ok(())).unwrap();
        drop(session);
        plate.destroy().unwrap();
    }
}
