//! Models in C, and the lists of formulations and keys for input decks and user interfaces.

use std::ffi::c_char;

use super::arguments::{output, text};
use super::guard::guard;
use super::handle::{self, Handle, Opaque};
use super::status::perion_status;
use super::texts::{entry, table_of_texts};
use crate::formulation::FORMULATIONS;
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
