//! Facts of a build for `codrive --version --verbose`: commit, target, compiler. In: `CODRIVE_COMMIT`, else git. A source distribution has
//! neither, and then the commit is empty.

use std::{env, path::Path, process::Command};

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=CODRIVE_COMMIT");
    let named = env::var("CODRIVE_COMMIT").ok().filter(|commit| !commit.is_empty());
    println!("cargo:rustc-env=CODRIVE_COMMIT={}", named.or_else(commit).unwrap_or_default());
    println!("cargo:rustc-env=CODRIVE_TARGET={}", env::var("TARGET").unwrap_or_default());
    let compiler = env::var("RUSTC").ok().and_then(|compiler| first_line(Command::new(compiler).arg("--version")));
    println!("cargo:rustc-env=CODRIVE_COMPILER={}", compiler.unwrap_or_default());
}

/// Returns the commit of an optimised build in a checkout. A dev build has none, as each new commit would build the program and all tests again.
fn commit() -> Option<String> {
    let root = env::var("CARGO_MANIFEST_DIR").ok()?;
    // The profile wheel optimises this package for size.
    let is_optimised = matches!(env::var("OPT_LEVEL").as_deref(), Ok("3" | "s"));
    if !is_optimised || !Path::new(&root).join(".git").exists() {
        return None;
    }
    let git = |arguments: &[&str]| first_line(Command::new("git").args(["-C", &root]).args(arguments));
    // The log changes with each commit and each checkout.
    let log = git(&["rev-parse", "--path-format=absolute", "--git-path", "logs/HEAD"])?;
    if Path::new(&log).exists() {
        println!("cargo:rerun-if-changed={log}");
    }
    git(&["rev-parse", "HEAD"])
}

fn first_line(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).lines().next()?.to_owned())
}
