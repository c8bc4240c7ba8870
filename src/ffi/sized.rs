//! Structs that the library fills for the host, each beginning with its size: a host that was built
//! against an older header gets as much as it knows of.

use std::ffi::c_void;

use super::arguments::output;
use super::guard::Failure;
use crate::error::argument;

/// A `repr(C)` struct of plain numbers and pointers that begins with `int64_t struct_size`.
///
/// # Safety
/// That is what the type must be.
pub(crate) unsafe trait Sized64: Copy {}

const SIZE_BYTES: usize = size_of::<i64>();

/// No struct of the interface will ever be larger.
const MOST_BYTES: i64 = 1 << 16;

/// Clears a struct of the host, as many bytes as it says that it has, and sets its size.
///
/// # Safety
/// `pointer` is NULL or leads to room for `size` bytes.
pub(crate) unsafe fn init<T: Sized64>(pointer: *mut T, size: i64) {
    if pointer.is_null()
        || !pointer.is_aligned()
        || !(SIZE_BYTES as i64..=MOST_BYTES).contains(&size)
    {
        return;
    }
    // SAFETY: the caller's promise; the struct may be all zeros and begins with its size.
    unsafe {
        pointer.cast::<u8>().write_bytes(0, size as usize);
        pointer.cast::<i64>().write(size);
    }
}

/// The size that the host has set, checked.
///
/// # Safety
/// `pointer` is NULL or leads to a struct whose first member says how many bytes it has.
pub(crate) unsafe fn size_of_host<T: Sized64>(
    pointer: *const T,
    name: &'static str,
) -> Result<usize, Failure> {
    // SAFETY: the caller's promise; the first member is there whatever the size.
    let size = unsafe { output(pointer.cast_mut().cast::<i64>(), name)?.assume_init_read() };
    match usize::try_from(size) {
        Ok(bytes) if bytes >= SIZE_BYTES && size <= MOST_BYTES => Ok(bytes.min(size_of::<T>())),
        _ => Ok(argument(format!(
            "the struct_size of '{name}' is {size}; let perion_{name}_init set it"
        ))?),
    }
}

/// Writes `value` to the host's struct, as far as that reaches, but for the size.
///
/// # Safety
/// As for [`size_of_host`], and nothing else reads or writes the struct meanwhile.
pub(crate) unsafe fn write<T: Sized64>(
    pointer: *mut T,
    value: &T,
    name: &'static str,
) -> Result<(), Failure> {
    // SAFETY: the caller's promise.
    let bytes = unsafe { size_of_host(pointer, name) }?;
    let from = std::ptr::from_ref(value).cast::<c_void>();
    // SAFETY: both structs have at least `bytes` bytes, of plain data.
    unsafe {
        std::ptr::copy_nonoverlapping(
            from.byte_add(SIZE_BYTES),
            pointer.cast::<c_void>().byte_add(SIZE_BYTES),
            bytes - SIZE_BYTES,
        );
    }
    Ok(())
}

/// Reads the host's struct into a copy of `value`, as far as the host's reaches.
///
/// # Safety
/// As for [`size_of_host`].
pub(crate) unsafe fn read<T: Sized64>(
    pointer: *const T,
    mut value: T,
    name: &'static str,
) -> Result<T, Failure> {
    // SAFETY: the caller's promise.
    let bytes = unsafe { size_of_host(pointer, name) }?;
    let to = std::ptr::from_mut(&mut value).cast::<u8>();
    // SAFETY: both structs have at least `bytes` bytes, of plain data.
    unsafe { std::ptr::copy_nonoverlapping(pointer.cast::<u8>(), to, bytes) };
    Ok(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Pair {
        struct_size: i64,
        first: f64,
        second: f64,
    }
    // SAFETY: it is such a struct.
    unsafe impl Sized64 for Pair {}

    #[test]
    fn an_older_host_gets_what_it_knows_of_and_no_more() {
        let value = Pair { struct_size: 24, first: 1.0, second: 2.0 };
        for (size, first, second) in [(24, 1.0, 2.0), (16, 1.0, 9.0), (8, 9.0, 9.0), (99, 1.0, 2.0)]
        {
            let mut host = Pair { struct_size: size, first: 9.0, second: 9.0 };
            // SAFETY: a valid struct; sizes beyond it are cut.
            unsafe { write(&raw mut host, &value, "pair") }.unwrap();
            assert_eq!(host, Pair { struct_size: size, first, second });
        }
    }

    #[test]
    fn an_older_host_keeps_what_stands_behind_its_struct() {
        let mut host = [Pair { struct_size: 1, first: 2.0, second: 3.0 }; 2];
        // SAFETY: a valid struct.
        unsafe { init(&raw mut host[0], 16) };
        assert_eq!(host[0], Pair { struct_size: 16, first: 0.0, second: 3.0 });
        assert_eq!(host[1].struct_size, 1);
    }

    #[test]
    fn a_size_that_was_not_set_is_refused() {
        for size in [0, -8, 7, i64::MAX] {
            let host = Pair { struct_size: size, first: 0.0, second: 0.0 };
            // SAFETY: a valid struct.
            assert!(unsafe { size_of_host(&raw const host, "pair") }.is_err(), "{size}");
        }
    }
}
