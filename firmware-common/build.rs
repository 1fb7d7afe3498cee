//! Gives the linker the boards' memory map. The rest of what it needs stands in `.cargo/config.toml`.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// The memory map both boards share, at the root of the repository.
const MEMORY_MAP: &str = "../memory.x";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed={MEMORY_MAP}");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let Some(out) = env::var_os("OUT_DIR").map(PathBuf::from) else {
        println!("cargo:error=OUT_DIR is not set: build with cargo");
        return;
    };
    if let Err(error) = fs::copy(Path::new(MEMORY_MAP), out.join("memory.x")) {
        println!("cargo:error=cannot copy {MEMORY_MAP} to {}: {error}", out.display());
    }
    println!("cargo:rustc-link-search={}", out.display());
}
