//! Models in C, and the lists of formulations and keys for input decks and user interfaces.

use std::ffi::{c_char, c_int, c_void};
use std::ops::ControlFlow;

use super::arguments::{output, text};
use super::guard::{Failure, User, call_host, guard};
use super::handle::{self, Handle, Opaque};
use super::status::perion_status;
use super::texts::{entry, table_of_texts};
use crate::error::argument;
use crate::formulation::FORMULATIONS;
use crate::material::MaterialBatch;
use crate::model::{KEYS, Kind, Model};

/// A formulation with its material and options.
#[allow(non_camel_case_types)]
pub struct perion_model(Handle<Model>);

impl Opaque for perion_model {
    type Value = Model;
    const NAME: &'static str = "model";
    const MAGIC: u64 = 0x7065_7269_6f6e_0002;
    fn wrap(handle: Handle<Model>) -> Self {
        Self(handle)
    }
    fn handle(&self) -> &Handle<Model> {
        &self.0
    }
}

/// Most numbers of state of a host's law.
const MOST_STATE: i64 = 100_000;

const fn choices(kind: &Kind) -> &'static str {
    match kind {
        Kind::Choice(words) => words,
        Kind::Number { .. } | Kind::NotNegative | Kind::Whole { .. } => "",
    }
}

table_of_texts!(FORMULATION_NAMES, FORMULATIONS.len(), k => FORMULATIONS[k].name);
table_of_texts!(FORMULATION_DESCRIPTIONS, FORMULATIONS.len(), k => FORMULATIONS[k].description);
table_of_texts!(KEY_NAMES, KEYS.len(), k => KEYS[k].name);
table_of_texts!(KEY_DESCRIPTIONS, KEYS.len(), k => KEYS[k].description);
table_of_texts!(KEY_DEFAULTS, KEYS.len(), k => KEYS[k].default);
table_of_texts!(KEY_CHOICES, KEYS.len(), k => choices(&KEYS[k].kind));

/// Makes a model of a formulation ("bond_based"), with nothing set.
///
/// ERROR_ARGUMENT: unknown formulation; perion_last_error() names a similar one. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_model_create(
    formulation: *const c_char,
    model: *mut *mut perion_model,
) -> perion_status {
    guard("perion_model_create", || {
        // SAFETY: the header's contract.
        unsafe {
            let formulation = text(formulation, "formulation")?;
            handle::create(model, || Ok(Model::new(formulation)?))
        }
    })
}

/// Sets a number; perion_key_name lists the keys. Values are checked one by one here, and together
/// when a simulation is made.
///
/// ERROR_ARGUMENT: unknown key (perion_last_error() names a similar one), a key that takes a choice,
/// a value out of its range. ERROR_UNSUPPORTED: a key the formulation does not take. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_model_set(
    model: *mut perion_model,
    key: *const c_char,
    value: f64,
) -> perion_status {
    guard("perion_model_set", || {
        // SAFETY: the header's contract.
        unsafe {
            let key = text(key, "key")?;
            handle::exclusive(model, |model| Ok(model.set(key, value)?))
        }
    })
}

/// The number last set for a key, or its default.
///
/// ERROR_ARGUMENT: unknown key, or one that takes a choice. ERROR_STATE: not set, and without a
/// default. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_model_get(
    model: *const perion_model,
    key: *const c_char,
    value: *mut f64,
) -> perion_status {
    guard("perion_model_get", || {
        // SAFETY: the header's contract.
        unsafe {
            let (key, value) = (text(key, "key")?, output(value, "value")?);
            handle::shared(model, |model| {
                value.write(model.get(key)?);
                Ok(())
            })
        }
    })
}

/// Makes a choice; perion_key_choices lists them.
///
/// ERROR_ARGUMENT: unknown key or choice, or a key that takes a number. ERROR_UNSUPPORTED: a key the
/// formulation does not take. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_model_choose(
    model: *mut perion_model,
    key: *const c_char,
    choice: *const c_char,
) -> perion_status {
    guard("perion_model_choose", || {
        // SAFETY: the header's contract.
        unsafe {
            let (key, choice) = (text(key, "key")?, text(choice, "choice")?);
            handle::exclusive(model, |model| Ok(model.choose(key, choice)?))
        }
    })
}

/// A law of the host's own: fills P (first Piola-Kirchhoff stress) and W (stored energy per reference volume) for `count`
/// deformation gradients F1, and state1, which is the material's only when a step is completed or committed. F0 and
/// state0 are those of the last committed state: F0 = I and state0 = 0 at first. Tensors are [count][D][D], row after row,
/// with F_ij = dx_i/dX_j and D the dimension of the points; states [count][state_size]; state1 comes as state0. Must
/// give the same for the same. Runs on the calling thread, one at a time, with the host's floating-point environment;
/// must not throw or jump out, and may not call anything on the simulation. A result other than 0 stops the call
/// (ERROR_INTERRUPTED).
#[allow(non_camel_case_types, non_snake_case)]
pub type perion_material_function = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        count: i64,
        F0: *const f64,
        F1: *const f64,
        state0: *const f64,
        state1: *mut f64,
        P: *mut f64,
        W: *mut f64,
    ) -> c_int,
>;

/// Takes a law of the host's own in place of `material`, with state_size numbers of state at each place where the
/// formulation asks its law: points, or bonds from both ends. Elastic constants are still needed. Simulations keep
/// function and user as long as they live. In 2D the function answers for what lies across, and stress_33 and
/// von_mises_stress are ERROR_UNSUPPORTED. Where a family does not span the body F has what is missing turned along,
/// without stretch, and P counts in the directions spanned.
///
/// ERROR_ARGUMENT: state_size below 0 or above 100000. ERROR_NULL: no function. ERROR_UNSUPPORTED: a formulation that
/// asks no law. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_model_set_material_function(
    model: *mut perion_model,
    state_size: i64,
    function: perion_material_function,
    user: *mut c_void,
) -> perion_status {
    guard("perion_model_set_material_function", || {
        if !(0..=MOST_STATE).contains(&state_size) {
            return Ok(argument(format!(
                "'state_size' is {state_size}; it must be from 0 to {MOST_STATE}"
            ))?);
        }
        let function = function.ok_or(Failure::Null { argument: "function" })?;
        let user = User(user);
        let ask = move |batch: &mut MaterialBatch<'_>| {
            let User(user) = { user };
            let MaterialBatch { count, before, now, state_before, state, stress, energy } = batch;
            let count = *count as i64;
            let (before, now, old) = (before.as_ptr(), now.as_ptr(), state_before.as_ptr());
            let (new, stress) = (state.as_mut_ptr(), stress.as_mut_ptr());
            let energy = energy.as_mut_ptr();
            // SAFETY: the host's promise for its function; all arrays have what `count` says.
            let said = call_host(|| unsafe {
                function(user, count, before, now, old, new, stress, energy)
            });
            if said == 0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        // SAFETY: the header's contract.
        unsafe {
            handle::exclusive(model, |model| {
                Ok(model.set_material_function(state_size as usize, ask)?)
            })
        }
    })
}

/// Frees a model and sets the pointer to NULL; NULL, or the address of NULL, is fine. Simulations made
/// of it keep their own copy. ERROR_STATE: another call is using it. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_model_destroy(model: *mut *mut perion_model) -> perion_status {
    // SAFETY: the header's contract.
    guard("perion_model_destroy", || unsafe { handle::destroy(model) })
}

/// Number of formulations. Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn perion_formulation_count() -> i64 {
    FORMULATIONS.len() as i64
}

/// Name of a formulation, index from 0; NULL when there is none. It lives as long as the library.
/// Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn perion_formulation_name(index: i64) -> *const c_char {
    entry(&FORMULATION_NAMES, index)
}

/// What a formulation is, in a line; NULL when there is none. Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn perion_formulation_description(index: i64) -> *const c_char {
    entry(&FORMULATION_DESCRIPTIONS, index)
}

/// Number of keys that models know. Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn perion_key_count() -> i64 {
    KEYS.len() as i64
}

/// Name of a key, index from 0; NULL when there is none. It lives as long as the library. Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn perion_key_name(index: i64) -> *const c_char {
    entry(&KEY_NAMES, index)
}

/// Meaning of a key, its unit kind and the reason for its default; NULL when there is none. Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn perion_key_description(index: i64) -> *const c_char {
    entry(&KEY_DESCRIPTIONS, index)
}

/// Default of a key as text, "" where it has none; NULL when there is no such key. Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn perion_key_default(index: i64) -> *const c_char {
    entry(&KEY_DEFAULTS, index)
}

/// Choices of a key with a bar between them ("strain|stress"), "" for a key that takes a number; NULL
/// when there is no such key. Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn perion_key_choices(index: i64) -> *const c_char {
    entry(&KEY_CHOICES, index)
}
