//! Handles under contention, panics and wrong pointers.

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
fn a_session_waits_for_readers_that_came_in_during_a_callback() {
    let plate = Host::new(0);
    let mut session = plate.session();
    let (entered, wait) = channel();
    let read = move || {
        let Host(pointer) = { plate };
        let slow = |count: &Count| {
            entered.send(()).unwrap();
            thread::sleep(std::time::Duration::from_millis(50));
            Ok(count.0)
        };
        // SAFETY: live.
        unsafe { shared::<Plate, _>(pointer, slow) }.unwrap()
    };
    let mut reader = None;
    let callback = || {
        reader = Some(thread::spawn(read));
        wait.recv().unwrap();
    };
    session.while_shared(callback).unwrap();
    assert_eq!(refusal(plate.get()), BUSY, "no reader is in, and none is let in");
    session.with_mut(|count| Ok(std::mem::replace(&mut count.0, 7))).unwrap();
    drop(session);
    assert_eq!(reader.unwrap().join().unwrap(), 0);
    assert_eq!(plate.get().unwrap(), 7);
    plate.destroy().unwrap();
}
