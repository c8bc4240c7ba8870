//! Sets the SONAME of the shared library, for which cargo has no setting.

/// Raised when a function or a struct of the C interface changes so that old binaries would break.
const ABI_VERSION: &str = "0";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-env=PERION_ABI_VERSION={ABI_VERSION}");
    let target = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    if target == "linux" {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libperion.so.{ABI_VERSION}");
    }
}
