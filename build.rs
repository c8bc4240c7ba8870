//! Sets the SONAME of the shared library, for which cargo has no setting, and what the library tells
//! of its build.

/// Raised when a function or a struct of the C interface changes so that old binaries would break.
const ABI_VERSION: &str = "0";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-env=PERION_ABI_VERSION={ABI_VERSION}");
    for (name, source) in [("PERION_TARGET", "TARGET"), ("PERION_PROFILE", "PROFILE")] {
        println!("cargo:rustc-env={name}={}", std::env::var(source).unwrap_or_default());
    }
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux") {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libperion.so.{ABI_VERSION}");
    }
}
