//! `codrive --version --verbose`: the facts that a report of a fault needs. In: the build and the machine. Out: text.

use crate::{data_folders, native_code, traffic::sumo};
use std::{env::consts, ffi::OsString, fs, path::Path};

/// Features of this build that a program may lack.
const FEATURES: [(&str, bool); 3] =
    [("desktop", cfg!(feature = "desktop")), ("onnx", cfg!(feature = "onnx")), ("tune", cfg!(feature = "tune"))];

/// Returns the version and the features of this build; `scripts/drive` reads the features to keep them.
pub(super) fn long() -> String {
    format!("{}\nfeatures: {}", env!("CARGO_PKG_VERSION"), features())
}

fn features() -> String {
    let built: Vec<&str> = FEATURES.iter().filter(|(_, is_built)| *is_built).map(|(name, _)| *name).collect();
    if built.is_empty() { "none".into() } else { built.join(", ") }
}

/// Returns true if the arguments, after the program's name, are `--version` and `--verbose` alone.
pub(super) fn is_verbose(arguments: &[OsString]) -> bool {
    let words: Vec<_> = arguments.iter().skip(1).map(|word| word.to_string_lossy()).collect();
    let has = |names: [&str; 2]| words.iter().any(|word| names.contains(&word.as_ref()));
    words.len() == 2 && has(["-V", "--version"]) && has(["-v", "--verbose"])
}

/// Returns the report of build, data, SUMO, graphics and system. Nothing in it is a fault: what is missing has its reason.
pub(super) fn report() -> String {
    let known = |text: &'static str| if text.is_empty() { "unknown" } else { text };
    let profile = if cfg!(debug_assertions) { "debug" } else { "release" };
    let shown = |path: Option<&Path>| path.map_or("none".into(), |path| path.display().to_string());
    let sumo = sumo::version()
        .map_or_else(|why| format!("none: {why}"), |(home, version)| format!("{version} in {}", home.display()));
    let lines = [
        ("commit", known(env!("CODRIVE_COMMIT")).into()),
        ("features", features()),
        ("build", format!("{}, {profile}, {}", known(env!("CODRIVE_TARGET")), known(env!("CODRIVE_COMPILER")))),
        ("program", shown(native_code::program().as_deref())),
        (
            "data",
            data_folders::require().map_or_else(|why| format!("none: {why}"), |()| shown(Some(data_folders::root()))),
        ),
        ("own data", shown(data_folders::user().as_deref())),
        ("SUMO", sumo),
        ("graphics", super::desktop::graphics()),
        ("system", system()),
    ];
    let text: String =
        lines.iter().map(|(name, found)| format!("{name:<10} {}\n", found.replace('\n', "\n           "))).collect();
    format!("codrive {}\n{text}", env!("CARGO_PKG_VERSION"))
}

/// Returns the operating system and its kernel.
fn system() -> String {
    let release = fs::read_to_string("/etc/os-release").unwrap_or_default();
    let name = release.lines().find_map(|line| line.strip_prefix("PRETTY_NAME=")).map(|name| name.trim_matches('"'));
    let kernel = fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
    format!("{}, {} {} {}", name.unwrap_or("unnamed"), consts::OS, kernel.trim(), consts::ARCH)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_version_and_verbose_together_ask_for_the_report() {
        let asks = |line: &str| is_verbose(&line.split(' ').map(Into::into).collect::<Vec<_>>());
        assert!(asks("codrive --version --verbose") && asks("codrive -v -V") && asks("codrive -V --verbose"));
        for line in ["codrive --version", "codrive --verbose", "codrive -V -V", "codrive run -V -v"] {
            assert!(!asks(line), "{line}");
        }
    }
}
