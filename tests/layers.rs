//! The structure holds: imports run downwards, files are small and say what they are for, and each outside library stays
//! in its room.

use std::{
    fs,
    path::{Path, PathBuf},
};

/// Rows of `src/lib.rs`, bottom first. A module names only modules of lower rows.
const ROWS: [&[&str]; 14] = [
    &["space", "time", "units", "rng", "idm", "chart", "file", "foreign", "private", "toml_text"],
    &["data_folders"],
    &["map"],
    &["ego", "policy"],
    &["input", "traffic", "driver"],
    &["sim", "train"],
    &["hud"],
    &["scene", "record", "audio"],
    &["render", "study", "analysis"],
    &["panel", "doctor", "drive_loop"],
    &["live_drive"],
    &["desktop"],
    &["replay", "drive_window", "session"],
    &["bench"],
];

/// Libraries that only some rooms may name.
const ROOMS: [(&str, &[&str]); 15] = [
    ("wgpu", &["render", "desktop", "replay", "bench", "cli"]),
    ("winit", &["desktop", "drive_window", "session", "replay"]),
    ("egui", &["render", "panel", "desktop", "drive_window", "session", "replay", "chart"]),
    ("resvg", &["chart"]),
    ("skrifa", &["chart"]),
    ("gilrs", &["input"]),
    ("evdev", &["input"]),
    ("libloading", &["traffic", "input"]),
    ("rapier3d", &["ego"]),
    ("clap", &["cli"]),
    ("arrow_array", &["record"]),
    ("parquet", &["record"]),
    ("cpal", &["audio"]),
    ("fundsp", &["audio"]),
    ("hound", &["audio"]),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All Rust files below `folder`, in a fixed order.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    files
}

/// The top-level module that a file of `src/` belongs to.
fn module(file: &Path) -> String {
    let relative = file.strip_prefix(root().join("src")).unwrap();
    let first = relative.components().next().unwrap().as_os_str().to_string_lossy().into_owned();
    first.trim_end_matches(".rs").to_owned()
}

fn row(module: &str) -> Option<usize> {
    ROWS.iter().position(|row| row.contains(&module))
}

/// Code without comments and without test modules at the end of a file, which may look upwards for nothing either way.
fn code(text: &str) -> String {
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// Modules named after `crate::`, also inside braces of one `use`.
fn named_modules(code: &str) -> Vec<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        if !rest.starts_with('{') {
            found.push(word(rest));
            continue;
        }
        let mut depth = 0;
        let mut fresh = false;
        for (i, c) in rest.char_indices() {
            match c {
                '{' => {
                    depth += 1;
                    fresh = depth == 1;
                }
                '}' => depth -= 1,
                ',' => fresh = depth == 1,
                c if c.is_whitespace() => {}
                _ if fresh && depth == 1 => {
                    found.push(word(&rest[i..]));
                    fresh = false;
                }
                _ => {}
            }
            if depth == 0 {
                break;
            }
        }
    }
    found
}

#[test]
fn imports_run_downwards() {
    let mut faults = Vec::new();
    for file in sources(&root().join("src")) {
        let here = module(&file);
        let Some(own) = row(&here) else { continue };
        for named in named_modules(&code(&fs::read_to_string(&file).unwrap())) {
            if named != here && row(&named).is_some_and(|other| other >= own) {
                faults.push(format!("{} ({here}) names crate::{named}", file.display()));
            }
        }
    }
    assert!(faults.is_empty(), "imports that run upwards or sideways:\n{}", faults.join("\n"));
}

#[test]
fn the_check_of_imports_sees_every_form() {
    let text = "use crate::{map::Route, policy::{self, Advice}, sim};\nlet x = crate::render::gpu::Gpu;";
    assert_eq!(named_modules(text), ["map", "policy", "sim", "render"]);
}

#[test]
fn every_module_has_its_row() {
    for file in sources(&root().join("src")) {
        let name = module(&file);
        assert!(row(&name).is_some() || ["lib", "main", "cli"].contains(&name.as_str()), "{name} is in no row");
    }
}

#[test]
fn libraries_stay_in_their_rooms() {
    let mut faults = Vec::new();
    for file in sources(&root().join("src")) {
        let here = module(&file);
        let text = code(&fs::read_to_string(&file).unwrap());
        for (library, rooms) in ROOMS {
            let named = text.contains(&format!("{library}::")) || text.contains(&format!("use {library};"));
            if named && !rooms.contains(&here.as_str()) {
                faults.push(format!("{} names {library}", file.display()));
            }
        }
        if here == "traffic" && text.contains("libloading::") && !file.to_string_lossy().contains("sumo") {
            faults.push(format!("{} knows SUMO's library", file.display()));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn files_are_small_and_say_what_they_are_for() {
    let mut faults = Vec::new();
    for folder in ["src", "tests"] {
        for file in sources(&root().join(folder)) {
            let text = fs::read_to_string(&file).unwrap();
            if !text.starts_with("//!") {
                faults.push(format!("{} has no head", file.display()));
            }
            if text.lines().count() > 500 {
                faults.push(format!("{} has {} lines", file.display(), text.lines().count()));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn nothing_is_switched_off() {
    // Spelt in two parts, so that this file is none of its own finds.
    let marks = [concat!("#[ig", "nore"), concat!("todo", "!("), concat!("unimple", "mented!(")];
    for folder in ["src", "tests"] {
        for file in sources(&root().join(folder)) {
            let text = fs::read_to_string(&file).unwrap();
            for mark in marks {
                assert!(!text.contains(mark), "{} has {mark}", file.display());
            }
        }
    }
}
