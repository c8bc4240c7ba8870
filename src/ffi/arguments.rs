//! Arguments from C: raw pointers, counts and text become references, or errors that name them.

use std::ffi::c_char;
use std::mem::MaybeUninit;
use std::slice;

use super::guard::Failure;
use crate::error::{Error, argument};

/// Longest text that a call takes, in bytes: the longest path of the systems in use.
const LONGEST_TEXT: usize = 4096;

/// The text that `pointer` leads to.
///
/// # Safety
/// `pointer` is NULL or leads to text that ends in NUL and stays unchanged for `'a`.
pub(crate) unsafe fn text<'a>(
    pointer: *const c_char,
    name: &'static str,
) -> Result<&'a str, Failure> {
    let pointer = not_null(pointer, name)?.cast::<u8>();
    // SAFETY: no byte beyond the first NUL is read.
    let Some(length) = (0..=LONGEST_TEXT).find(|&k| unsafe { *pointer.add(k) } == 0) else {
        return Ok(argument(format!("'{name}' is longer than {LONGEST_TEXT} bytes"))?);
    };
    // SAFETY: the bytes before the NUL have just been read.
    let bytes = unsafe { slice::from_raw_parts(pointer, length) };
    str::from_utf8(bytes).map_err(|error| {
        let place = error.valid_up_to();
        Error::Argument(format!("'{name}' is not UTF-8: byte {place} is {:#04x}", bytes[place]))
            .into()
    })
}

/// The `count` values that `pointer` leads to; it may be NULL when there are none.
///
/// # Safety
/// `pointer` is NULL or leads to at least `count` values, each a valid `T`, unchanged for `'a`.
pub(crate) unsafe fn slice<'a, T: Copy>(
    pointer: *const T,
    count: i64,
    name: &'static str,
) -> Result<&'a [T], Failure> {
    match extent(pointer, count, name)? {
        0 => Ok(&[]),
        // SAFETY: the pointer is aligned and not NULL, the size is within isize; the rest is the
        // caller's promise.
        count => Ok(unsafe { slice::from_raw_parts(pointer, count) }),
    }
}

/// The `count` values that `pointer` leads to, to be overwritten.
///
/// # Safety
/// As for [`slice`], and nothing else reads or writes them for `'a`.
pub(crate) unsafe fn slice_mut<'a, T: Copy>(
    pointer: *mut T,
    count: i64,
    name: &'static str,
) -> Result<&'a mut [T], Failure> {
    match extent(pointer, count, name)? {
        0 => Ok(&mut []),
        // SAFETY: as in `slice`.
        count => Ok(unsafe { slice::from_raw_parts_mut(pointer, count) }),
    }
}

/// The place for one result, which need not hold a value yet.
///
/// # Safety
/// `pointer` is NULL or leads to room for a `T` that nothing else reads or writes for `'a`.
pub(crate) unsafe fn output<'a, T>(
    pointer: *mut T,
    name: &'static str,
) -> Result<&'a mut MaybeUninit<T>, Failure> {
    let pointer = aligned(not_null(pointer, name)?, name)?;
    // SAFETY: aligned and not NULL; the rest is the caller's promise.
    Ok(unsafe { &mut *pointer.cast_mut().cast() })
}

/// A pointer that leads somewhere, aligned.
pub(crate) fn present<T>(pointer: *mut T, name: &'static str) -> Result<*mut T, Failure> {
    Ok(aligned(not_null(pointer.cast_const(), name)?, name)?.cast_mut())
}

/// A count, stride or index of C as one of Rust.
pub(crate) fn convert(value: i64, name: &'static str) -> Result<usize, Failure> {
    let refused = || Error::Argument(format!("'{name}' is {value}; it must not be negative"));
    Ok(usize::try_from(value).map_err(|_| refused())?)
}

/// An index at a place of an array of indices.
pub(crate) fn index(value: i64, name: &'static str, place: usize) -> Result<usize, Failure> {
    let refused = || Error::Argument(format!("'{name}'[{place}] is {value}; indices start at 0"));
    Ok(usize::try_from(value).map_err(|_| refused())?)
}

/// Numbers from the first of the first point to the last of the last one.
pub(crate) fn length(
    count: usize,
    stride: usize,
    components: usize,
    name: &'static str,
) -> Result<i64, Failure> {
    if count == 0 {
        return Ok(0);
    }
    let total = (count - 1).checked_mul(stride).and_then(|n| n.checked_add(components));
    let refused = || {
        Error::Argument(format!(
            "'{name}': {count} points with stride {stride} are more than memory can hold"
        ))
    };
    let most = isize::MAX as usize / size_of::<f64>();
    let total = total.filter(|&total| total <= most).and_then(|total| i64::try_from(total).ok());
    Ok(total.ok_or_else(refused)?)
}

/// Refuses a count that is not what it must be.
pub(crate) fn expect_count(given: i64, expected: usize, name: &'static str) -> Result<(), Failure> {
    if usize::try_from(given) == Ok(expected) {
        return Ok(());
    }
    Ok(argument(format!("'{name}' is {given}; it must be {expected}"))?)
}

/// The text that `pointer` leads to, `None` for NULL.
///
/// # Safety
/// As for [`text`].
pub(crate) unsafe fn text_or_null<'a>(
    pointer: *const c_char,
    name: &'static str,
) -> Result<Option<&'a str>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise.
    unsafe { text(pointer, name) }.map(Some)
}

/// The count as a length, once the pointer and the size in bytes will do for a slice.
fn extent<T>(pointer: *const T, count: i64, name: &'static str) -> Result<usize, Failure> {
    if count == 0 {
        return Ok(0);
    }
    if count < 0 {
        return Ok(argument(format!("the count of '{name}' is {count}; it must not be negative"))?);
    }
    aligned(not_null(pointer, name)?, name)?;
    let length = usize::try_from(count).ok().filter(|length| {
        length.checked_mul(size_of::<T>()).is_some_and(|bytes| isize::try_from(bytes).is_ok())
    });
    let most = isize::MAX as usize / size_of::<T>().max(1);
    let too_many = || {
        let text = format!("the count of '{name}' is {count}; memory holds at most {most}");
        Failure::Library(Error::Argument(text))
    };
    length.ok_or_else(too_many)
}

fn not_null<T>(pointer: *const T, name: &'static str) -> Result<*const T, Failure> {
    if pointer.is_null() { Err(Failure::Null { argument: name }) } else { Ok(pointer) }
}

fn aligned<T>(pointer: *const T, name: &'static str) -> Result<*const T, Failure> {
    if pointer.is_aligned() {
        return Ok(pointer);
    }
    let alignment = align_of::<T>();
    Ok(argument(format!("'{name}' is {pointer:p}; it must be a multiple of {alignment} bytes"))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ptr::{null, null_mut, without_provenance};

    fn refusal<T>(result: Result<T, Failure>) -> String {
        result.err().unwrap().to_string()
    }

    #[test]
    fn text_is_read_up_to_its_nul() {
        // SAFETY: C strings.
        let read = |bytes: &'static std::ffi::CStr| unsafe { text(bytes.as_ptr(), "key") }.unwrap();
        assert_eq!(read(c"d\u{e9}lta"), "d\u{e9}lta");
        assert_eq!(read(c""), "");
    }

    #[test]
    fn text_that_is_missing_or_too_long_or_not_utf8_is_refused() {
        // SAFETY: NULL.
        assert_eq!(refusal(unsafe { text(null(), "key") }), "argument 'key' is NULL");
        let latin1 = c"d\xE9lta".as_ptr();
        // SAFETY: a C string.
        let refused = refusal(unsafe { text(latin1, "key") });
        assert_eq!(refused, "'key' is not UTF-8: byte 1 is 0xe9");

        let mut long = "x".repeat(LONGEST_TEXT) + "\0";
        // SAFETY: ends in NUL.
        assert_eq!(unsafe { text(long.as_ptr().cast(), "key") }.unwrap().len(), LONGEST_TEXT);
        long.insert(0, 'x');
        // SAFETY: ends in NUL.
        let refused = refusal(unsafe { text(long.as_ptr().cast(), "key") });
        assert_eq!(refused, "'key' is longer than 4096 bytes");
    }

    #[test]
    fn a_slice_is_the_hosts_memory_itself() {
        let mut values = [1.0, 2.0, 3.0];
        // SAFETY: three values.
        unsafe { slice_mut(values.as_mut_ptr(), 3, "values") }.unwrap()[1] = 5.0;
        // SAFETY: three values.
        assert_eq!(unsafe { slice(values.as_ptr(), 3, "values") }.unwrap(), [1.0, 5.0, 3.0]);
    }

    #[test]
    fn no_values_need_no_pointer() {
        // SAFETY: no value is read.
        assert!(unsafe { slice::<f64>(null(), 0, "values") }.unwrap().is_empty());
        // SAFETY: no value is read.
        assert!(unsafe { slice_mut::<f64>(null_mut(), 0, "values") }.unwrap().is_empty());
    }

    #[test]
    fn a_slice_that_cannot_be_is_refused_with_its_name_and_value() {
        // SAFETY: every one of these is refused before anything is read.
        let refused =
            |pointer: *const f64, count| unsafe { refusal(slice::<f64>(pointer, count, "values")) };
        let some = without_provenance(64);
        let odd = without_provenance(0x41);
        assert_eq!(refused(null(), 3), "argument 'values' is NULL");
        assert_eq!(refused(some, -3), "the count of 'values' is -3; it must not be negative");
        assert!(refused(some, i64::MAX).contains("is 9223372036854775807; memory holds at most"));
        assert!(refused(some, 1 << 60).contains("'values' is 1152921504606846976"));
        assert_eq!(refused(odd, 3), "'values' is 0x41; it must be a multiple of 8 bytes");
    }

    #[test]
    fn an_output_is_written_in_place() {
        let mut count = 0_i64;
        // SAFETY: room for one value.
        unsafe { output(&raw mut count, "count") }.unwrap().write(7);
        assert_eq!(count, 7);
        // SAFETY: refused before anything is read.
        let refused = refusal(unsafe { output::<i64>(null_mut(), "count") });
        assert_eq!(refused, "argument 'count' is NULL");
    }
}
