//! Which library this is.

use std::ffi::c_char;

use super::arguments::text;

/// Major number of this header's version.
pub const PERION_VERSION_MAJOR: i32 = 0;
/// Minor number of this header's version.
pub const PERION_VERSION_MINOR: i32 = 1;
/// Patch number of this header's version.
pub const PERION_VERSION_PATCH: i32 = 0;
/// Version of this header's binary interface; a library with another one cannot be used with it.
pub const PERION_ABI_VERSION: i32 = 0;

/// Version of the library in use: 10000 major + 100 minor + patch.
#[unsafe(no_mangle)]
pub extern "C" fn perion_version() -> i32 {
    10_000 * PERION_VERSION_MAJOR + 100 * PERION_VERSION_MINOR + PERION_VERSION_PATCH
}

/// Version of the binary interface of the library in use.
#[unsafe(no_mangle)]
pub extern "C" fn perion_abi_version() -> i32 {
    PERION_ABI_VERSION
}

/// Version of the library in use as text, "0.1.0". The text lives as long as the library.
#[unsafe(no_mangle)]
pub extern "C" fn perion_version_string() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// How the library was built, in a line. The text lives as long as the library.
#[unsafe(no_mangle)]
pub extern "C" fn perion_build_info() -> *const c_char {
    concat!(
        "perion ",
        env!("CARGO_PKG_VERSION"),
        ", interface ",
        env!("PERION_ABI_VERSION"),
        ", ",
        env!("PERION_TARGET"),
        ", ",
        env!("PERION_PROFILE"),
        "\0"
    )
    .as_ptr()
    .cast()
}

/// Whether the library has an optional feature. Known are "threads" (it has) and "ranks" (not yet);
/// false for NULL and anything else.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_has_feature(name: *const c_char) -> bool {
    // SAFETY: the header's contract.
    matches!(unsafe { text(name, "name") }, Ok("threads"))
}
