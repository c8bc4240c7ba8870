//! The boundary: what every exported function starts with, and what a callback goes back through.
//!
//! Inside, the floating-point environment is the default one and a panic goes no further than the
//! guard; outside, the host finds everything as it left it, a status, and a text.

use std::any::Any;
use std::cell::Cell;
use std::ffi::c_void;
use std::fmt;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::Once;
use std::thread;

use super::float_environment::FloatEnvironment;
use super::last_error;
use super::status::{
    PERION_ERROR_NULL, PERION_ERROR_POISONED, PERION_OK, perion_status, status_of,
};
use crate::error::Error;

/// The threads of a pool carry this at the start of their name: their panics are silent, too.
pub(crate) const WORKER_NAME: &str = "perion-worker";

/// Why a call of the C interface fails.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The library refused.
    Library(Error),
    /// A pointer that must not be NULL is NULL.
    Null {
        /// Its name in the header.
        argument: &'static str,
    },
    /// A panic left the object behind the handle half-way through a change.
    Poisoned {
        /// The handle's type without its prefix.
        object: &'static str,
    },
}

impl Failure {
    fn status(&self) -> perion_status {
        match self {
            Self::Library(error) => status_of(error),
            Self::Null { .. } => PERION_ERROR_NULL,
            Self::Poisoned { .. } => PERION_ERROR_POISONED,
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Library(error)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Library(error) => error.fmt(formatter),
            Self::Null { argument } => write!(formatter, "argument '{argument}' is NULL"),
            Self::Poisoned { object } => write!(
                formatter,
                "'{object}' is poisoned: an internal error interrupted an earlier call that was \
                 changing it; read or save what you need, then destroy it"
            ),
        }
    }
}

thread_local! {
    /// The environment to restore at the innermost boundary; none while the host's code runs.
    static HOST: Cell<Option<FloatEnvironment>> = const { Cell::new(None) };
    /// Message and place of this thread's last silenced panic.
    static PANIC: Cell<Option<String>> = const { Cell::new(None) };
}

/// Runs an exported function's body; its failure or panic becomes a status and perion_last_error.
pub(crate) fn guard(
    function: &'static str,
    body: impl FnOnce() -> Result<(), Failure>,
) -> perion_status {
    let entered_with = FloatEnvironment::enter_default();
    let outer = HOST.replace(Some(entered_with));
    silence_panics();

    let status = match contain(body) {
        Ok(()) => PERION_OK,
        Err(failure) => {
            last_error::set(function, &failure);
            failure.status()
        }
    };

    // A callback may have changed the environment; none is left where one unwound.
    HOST.replace(outer).unwrap_or(entered_with).restore();
    status
}

/// The host's own pointer, handed back to its callbacks.
#[derive(Clone, Copy)]
pub(crate) struct User(pub(crate) *mut c_void);

// SAFETY: the library never looks behind it, and calls back on the thread that calls it only.
unsafe impl Send for User {}
// SAFETY: as above.
unsafe impl Sync for User {}

/// Runs a host's callback in the host's floating-point environment, and keeps what it makes of it.
pub(crate) fn call_host<R>(callback: impl FnOnce() -> R) -> R {
    let Some(host) = HOST.take() else { return callback() };
    host.restore();
    let result = callback();
    HOST.set(Some(FloatEnvironment::enter_default()));
    result
}

/// Not inlined, so that no arithmetic of the body moves to where the host's environment is set.
#[inline(never)]
fn contain(body: impl FnOnce() -> Result<(), Failure>) -> Result<(), Failure> {
    // What a panic leaves half-done lies behind a handle, and the handle is poisoned.
    panic::catch_unwind(AssertUnwindSafe(body)).unwrap_or_else(|payload| {
        let text = format!("internal error: {}; please report it", describe(payload.as_ref()));
        Err(Error::Internal(text).into())
    })
}

/// The message, with its place unless the panic was another thread's.
fn describe(payload: &(dyn Any + Send)) -> String {
    let message = message(payload);
    // A panic that was caught further inside may have left its text.
    PANIC.take().filter(|text| text.starts_with(message)).unwrap_or_else(|| message.to_owned())
}

fn message(payload: &(dyn Any + Send)) -> &str {
    let owned = payload.downcast_ref::<String>().map(String::as_str);
    owned.or(payload.downcast_ref::<&str>().copied()).unwrap_or("panic without a message")
}

/// Keeps the panics of this library off the host's terminal.
///
/// The hook is the one thing of Perion's that belongs to the process and not to a handle: Rust
/// prints a panic before anyone can catch it, and has no other way to stop that. In the shared
/// library it is the hook of the library's own copy of `std`. A Rust host shares it, so panics
/// that are not ours go to the hook that was there before.
fn silence_panics() {
    static HOOK: Once = Once::new();
    // A thread that is unwinding already may not change the hook.
    if HOOK.is_completed() || thread::panicking() {
        return;
    }
    HOOK.call_once(|| {
        let previous = panic::take_hook();
        let hook = move |info: &PanicHookInfo<'_>| match panics_here_are_ours() {
            true => keep(info),
            false => previous(info),
        };
        panic::set_hook(Box::new(hook));
    });
}

fn panics_here_are_ours() -> bool {
    let inside = HOST.get().is_some();
    inside || thread::current().name().is_some_and(|name| name.starts_with(WORKER_NAME))
}

fn keep(info: &PanicHookInfo<'_>) {
    let place = info.location().map_or(String::new(), |place| format!(" ({place})"));
    let text = format!("{}{place}", message(info.payload()));
    // Fails only while the thread is ending, when there is nobody left to tell.
    let _ = PANIC.try_with(|panic| panic.set(Some(text)));
}

#[cfg(test)]
mod tests {
    use super::super::status::{PERION_ERROR_ARGUMENT, PERION_ERROR_INTERNAL};
    use super::*;
    use crate::error::argument;
    use std::process::Command;

    fn last_error() -> String {
        last_error::tests::text()
    }

    #[test]
    fn a_failure_becomes_a_status_and_a_text_that_a_success_leaves() {
        let status = guard("perion_test", || Ok(argument("count is -1")?));
        assert_eq!(status, PERION_ERROR_ARGUMENT);
        assert_eq!(guard("perion_other", || Ok(())), PERION_OK);
        assert_eq!(last_error(), "perion_test: count is -1");

        let status = guard("perion_test", || Err(Failure::Null { argument: "points" }));
        assert_eq!(status, PERION_ERROR_NULL);
        assert_eq!(last_error(), "perion_test: argument 'points' is NULL");
    }

    #[test]
    fn a_panic_becomes_an_internal_error_with_its_message_and_place() {
        assert_eq!(guard("perion_test", || panic!("{} bonds", -1)), PERION_ERROR_INTERNAL);
        assert!(
            last_error().starts_with("perion_test: internal error: -1 bonds ("),
            "{}",
            last_error()
        );
        assert!(last_error().contains("guard.rs:"), "{}", last_error());

        assert_eq!(guard("perion_test", || panic!("plain")), PERION_ERROR_INTERNAL);
        assert!(
            last_error().starts_with("perion_test: internal error: plain ("),
            "{}",
            last_error()
        );
    }

    #[test]
    fn a_panic_of_a_worker_keeps_its_message() {
        let status = guard("perion_test", || {
            let _ = panic::catch_unwind(|| panic!("caught further inside"));
            panic_on_a_worker("lost a bond")
        });
        assert_eq!(status, PERION_ERROR_INTERNAL);
        assert_eq!(last_error(), "perion_test: internal error: lost a bond; please report it");
    }

    #[test]
    fn every_exit_gives_the_host_its_floating_point_environment_back() {
        let hostile = FloatEnvironment::hostile();
        let bodies: [fn() -> Result<(), Failure>; 3] =
            [|| Ok(()), || Ok(argument("refused")?), || panic!("a defect")];
        for body in bodies {
            hostile.restore();
            guard("perion_test", || {
                std::hint::black_box(std::hint::black_box(1.0) / std::hint::black_box(0.0));
                body()
            });
            let after = FloatEnvironment::enter_default();
            assert_eq!(after.words(), hostile.words());
        }
    }

    #[test]
    fn callbacks_run_in_the_hosts_environment_however_deep_and_their_changes_stay() {
        let hostile = FloatEnvironment::hostile();
        let default = FloatEnvironment::enter_default();
        let observe = || {
            let seen = FloatEnvironment::enter_default();
            seen.restore();
            seen.words()
        };
        let (mut within, mut seen) = ([[0; 3]; 3], [0; 3]);
        let mut inner = || {
            within = [observe(), call_host(observe), observe()];
            Ok(())
        };
        guard("perion_outer", || {
            call_host(|| {
                hostile.restore();
                guard("perion_inner", &mut inner);
            });
            seen = observe();
            Ok(())
        });
        let after = FloatEnvironment::enter_default();

        let [default, hostile] = [default.words(), hostile.words()];
        assert_eq!((within, seen), ([default, hostile, default], default));
        assert_eq!(after.words(), hostile);
    }

    #[test]
    fn a_caught_panic_prints_nothing_and_a_panic_of_the_host_is_printed() {
        const SIDE: &str = "PERION_TEST_PANIC_SIDE";
        match std::env::var(SIDE).as_deref() {
            Ok("inside") => {
                guard("perion_test", || panic!("inside"));
                guard("perion_test", || panic_on_a_worker("inside"));
            }
            Ok(_) => {
                guard("perion_test", || {
                    call_host(|| panic::catch_unwind(|| panic!("in a callback")).unwrap_err());
                    Ok(())
                });
                panic::catch_unwind(|| panic!("outside")).unwrap_err();
            }
            Err(_) => {
                let (_, module) = module_path!().split_once("::").unwrap();
                let name = "a_caught_panic_prints_nothing_and_a_panic_of_the_host_is_printed";
                let printed = |side| {
                    let output = Command::new(std::env::current_exe().unwrap())
                        .args([&format!("{module}::{name}"), "--exact", "--nocapture"])
                        .env(SIDE, side)
                        .output()
                        .unwrap();
                    assert!(String::from_utf8(output.stdout).unwrap().contains("1 passed"));
                    String::from_utf8(output.stderr).unwrap()
                };
                assert_eq!(printed("inside"), "");
                let printed = printed("outside");
                assert!(printed.contains("in a callback") && printed.contains("outside"));
            }
        }
    }

    fn panic_on_a_worker(text: &'static str) -> Result<(), Failure> {
        let worker = thread::Builder::new().name(format!("{WORKER_NAME}-0"));
        let worker = worker.spawn(move || panic!("{text}")).unwrap();
        panic::resume_unwind(worker.join().unwrap_err())
    }
}
