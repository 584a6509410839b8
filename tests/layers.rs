//! Checks of the structure: imports run downwards and in small circles only, files are small and state their purpose, each outside library
//! stays in its modules, and comments cite only works and entries of `docs/`.

#[path = "layers/circles.rs"]
mod circles;
#[path = "layers/english.rs"]
mod english;
#[cfg(feature = "command")]
#[path = "layers/help.rs"]
mod help;
#[path = "layers/pages.rs"]
mod pages;
#[path = "layers/tables.rs"]
mod tables;

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

/// Rows of `src/lib.rs`, bottom first. A module names only modules of lower rows.
const ROWS: [&[&str]; 20] = [
    &[
        "space",
        "time",
        "units",
        "rng",
        "idm",
        "anticipation",
        "optimal_velocity",
        "controls",
        "plot",
        "file",
        "foreign",
        "private",
        "toml_text",
        "native_code",
        "latin_letters",
    ],
    &["temporary", "lsl"],
    &["data_folders", "settings", "triggers", "sumo_xml"],
    &["map"],
    &["roadside"],
    &["ego", "policy"],
    &["traffic", "metrics"],
    &["snapshot"],
    &["driver"],
    &["scenario"],
    &["sim", "train"],
    &["hud"],
    &["scene", "record", "audio", "input", "signing"],
    &["render", "analysis"],
    &["study"],
    &["panel", "doctor", "drive_loop"],
    &["live_drive", "sweep"],
    &["desktop"],
    &["replay", "drive_window", "session"],
    &["bench"],
];

/// Rows within modules that are divided into rooms, bottom first, as in the `mod.rs` of each. A room names only rooms of lower rows.
const ROWS_WITHIN: [(&str, &[&[&str]]); 1] = [(
    "analysis",
    &[
        &["error", "text", "statistics", "columns"],
        &["data"],
        &["responses", "network"],
        &["measures"],
        &["drives"],
        &["drivers", "models"],
        &["tables"],
        &["report"],
    ],
)];

/// Libraries that only some modules may name.
const ROOMS: [(&str, &[&str]); 17] = [
    ("wgpu", &["render", "desktop", "replay", "bench", "cli"]),
    ("winit", &["desktop", "drive_window", "session", "replay"]),
    ("egui", &["render", "panel", "desktop", "drive_window", "session", "replay", "plot"]),
    ("resvg", &["plot"]),
    ("skrifa", &["plot"]),
    ("gilrs", &["input"]),
    ("evdev", &["input"]),
    ("libloading", &["native_code", "traffic", "input", "lsl"]),
    ("rapier3d", &["ego"]),
    ("nalgebra", &["analysis"]),
    ("clap", &["cli"]),
    ("ssh_key", &["signing"]),
    ("arrow_array", &["record"]),
    ("parquet", &["record"]),
    ("cpal", &["audio"]),
    ("fundsp", &["audio"]),
    ("hound", &["audio"]),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns all Rust files below `folder`, in a fixed order.
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

/// Returns the top-level module of a file of `src/`.
fn module(file: &Path) -> String {
    let relative = file.strip_prefix(root().join("src")).unwrap();
    let first = relative.components().next().unwrap().as_os_str().to_string_lossy().into_owned();
    first.trim_end_matches(".rs").to_owned()
}

fn row(module: &str) -> Option<usize> {
    ROWS.iter().position(|row| row.contains(&module))
}

/// Returns the code without lines that are comments.
fn code(text: &str) -> String {
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// Adds the paths of a tree of imports to `found`, each after `before`; returns the text behind the tree.
fn add_paths<'a>(tree: &'a str, before: &str, found: &mut Vec<String>) -> &'a str {
    let end = tree.find(|c: char| !(c.is_alphanumeric() || "_:*".contains(c))).unwrap_or(tree.len());
    let path = format!("{before}{}", &tree[..end]);
    let Some(mut rest) = tree[end..].strip_prefix('{') else {
        found.push(path);
        return &tree[end..];
    };
    while !rest.is_empty() {
        rest = rest.trim_start();
        if let Some(behind) = rest.strip_prefix('}') {
            return behind;
        }
        rest = add_paths(rest, &path, found);
        // A name may be followed by `as` and another name.
        rest = &rest[rest.find([',', '}']).unwrap_or(rest.len())..];
        rest = rest.strip_prefix(',').unwrap_or(rest);
    }
    rest
}

/// Returns the paths named after `crate::`, also inside the braces of one `use`.
fn named_paths(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, mark) in code.match_indices("crate::") {
        add_paths(&code[at + mark.len()..], "", &mut found);
    }
    found
}

/// Returns the modules named after `crate::`.
fn named_modules(code: &str) -> Vec<String> {
    let mut names: Vec<String> = named_paths(code).iter().map(|path| first_name(path).to_owned()).collect();
    names.dedup();
    names
}

fn first_name(path: &str) -> &str {
    path.split("::").next().unwrap_or_default()
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
fn imports_between_rooms_of_a_module_run_downwards() {
    let mut faults = Vec::new();
    for (module, rows) in ROWS_WITHIN {
        let row = |room: &str| rows.iter().position(|row| row.contains(&room));
        let folder = root().join("src").join(module);
        for file in sources(&folder).into_iter().filter(|file| *file != folder.join("mod.rs")) {
            let first = file.strip_prefix(&folder).unwrap().iter().next().unwrap().to_string_lossy();
            let here = first.trim_end_matches(".rs");
            let text = code(&fs::read_to_string(&file).unwrap());
            let paths = named_paths(&text);
            let within = paths.iter().filter_map(|path| path.strip_prefix(module)?.strip_prefix("::"));
            for named in within.map(first_name).filter(|named| *named != here) {
                if row(named).is_none_or(|other| row(here).is_none_or(|own| other >= own)) {
                    faults.push(format!("{} ({here}) names crate::{module}::{named}", file.display()));
                }
            }
            if text.contains("super::super::") {
                faults.push(format!("{} names a room without crate::{module}", file.display()));
            }
        }
    }
    assert!(faults.is_empty(), "imports that run upwards or sideways:\n{}", faults.join("\n"));
}

#[test]
fn the_check_of_imports_sees_every_form() {
    let text = "use crate::{map::Route, policy::{self, Advice}, sim};\nlet x = crate::render::gpu::Gpu;";
    let paths = ["map::Route", "policy::self", "policy::Advice", "sim", "render::gpu::Gpu"];
    assert_eq!(named_paths(text), paths);
    assert_eq!(named_modules(text), ["map", "policy", "sim", "render"]);
}

#[test]
fn every_module_has_its_row() {
    for file in sources(&root().join("src")) {
        let name = module(&file);
        assert!(
            row(&name).is_some() || ["lib", "core", "build", "main", "cli"].contains(&name.as_str()),
            "{name} is in no row"
        );
    }
}

#[test]
fn the_package_core_is_the_rows_up_to_hud() {
    let text = fs::read_to_string(root().join("src/core.rs")).unwrap();
    let modules: BTreeSet<&str> =
        text.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    let rows = &ROWS[..=row("hud").unwrap()];
    assert_eq!(modules, rows.iter().flat_map(|row| row.iter().copied()).collect());
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
    for folder in ["src", "tests", "python/src"] {
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
fn no_test_is_ignored_and_no_code_is_a_placeholder() {
    // Spelt in two parts, so that the check does not find this file.
    let marks = [concat!("#[ig", "nore"), concat!("todo", "!("), concat!("unimple", "mented!(")];
    for folder in ["src", "tests", "python/src"] {
        for file in sources(&root().join(folder)) {
            let text = fs::read_to_string(&file).unwrap();
            for mark in marks {
                assert!(!text.contains(mark), "{} has {mark}", file.display());
            }
        }
    }
}

/// Returns the comments of a Rust file or a shader as one line, doc comments included.
fn comments(text: &str) -> String {
    let marked = text.lines().filter_map(|line| line.find("//").map(|at| &line[at..]));
    marked.map(|line| line.trim_start_matches(['/', '!'])).collect::<String>()
}

/// Returns the entries of the list of works, each on one line.
fn works(references: &str) -> Vec<String> {
    let list = references.split_once("\n## Works").expect("a part of works").1;
    list.split("\n* ").map(|entry| entry.replace('\n', " ")).filter(|entry| entry.starts_with("**[")).collect()
}

/// Returns the citations in `text` that the repository does not have.
fn dead_citations(text: &str, references: &str, decisions: &str) -> Vec<String> {
    let works = works(references);
    let mut dead = Vec::new();
    for gone in ["DESIGN", "FACTS"] {
        for (at, _) in text.match_indices(gone) {
            if text[at + gone.len()..].starts_with([' ', ':', ')', '.']) {
                dead.push(gone.to_owned());
            }
        }
    }
    for (document, name) in [(references, "docs/references.md: "), (decisions, "docs/decisions.md: ")] {
        for (at, _) in text.match_indices(name) {
            let rest = &text[at + name.len()..];
            let key: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '-').collect();
            let (topic, number) = (format!("\n### `{key}`: "), format!("\n## {key}. "));
            if !document.contains(&topic) && !document.contains(&number) {
                dead.push(format!("{name}{key}"));
            }
        }
    }
    let words: Vec<&str> = text.split_whitespace().collect();
    let bare = |word: &str| word.trim_matches(|c: char| !c.is_alphanumeric()).to_owned();
    for (i, word) in words.iter().enumerate() {
        let this = bare(word);
        // A key of a paper and its study: two capitals and a year.
        let key = this.len() == 4 && this[..2].chars().all(|c| c.is_ascii_uppercase());
        if key && this[2..].chars().all(|c| c.is_ascii_digit()) && !references.contains(&format!("**[{this}]**")) {
            dead.push(this.clone());
        }
        let Some(before) = i.checked_sub(1).map(|at| words[at]) else { continue };
        let standard = ["SAE", "ISO", "IEC", "ITU-R", "Regulation", "FMVSS"].contains(&bare(before).as_str());
        if standard
            && this.starts_with(|c: char| c.is_ascii_digit() || c.is_ascii_uppercase())
            && !references.contains(&this)
        {
            dead.push(format!("{before} {this}"));
        }
        // A name and a year: "Stern et al. 2018", "Kingma and Ba (2015)".
        let year = this.len() == 4 && this.parse::<u32>().is_ok_and(|year| (1800..2100).contains(&year));
        let of = if before == "al." && i >= 3 { words[i - 3] } else { before };
        let author = bare(of);
        let named = of.starts_with(|c: char| c.is_uppercase()) && author.chars().skip(1).any(char::is_lowercase);
        if year && named && !works.iter().any(|entry| entry.contains(&author) && entry.contains(&this)) {
            dead.push(format!("{author} {this}"));
        }
    }
    dead
}

#[test]
fn comments_cite_only_what_the_repository_has() {
    let read = |name: &str| fs::read_to_string(root().join(name)).unwrap();
    let (references, decisions) = (read("docs/references.md"), read("docs/decisions.md"));
    let mut files: Vec<PathBuf> = ["src", "tests"].iter().flat_map(|folder| sources(&root().join(folder))).collect();
    files.extend(fs::read_dir(root().join("shaders")).unwrap().map(|entry| entry.unwrap().path()));
    let mut texts: Vec<(PathBuf, String)> = Vec::new();
    for file in files {
        let text = comments(&fs::read_to_string(&file).unwrap());
        texts.push((file, text));
    }
    for name in ["README.md", "assets/policies/README.md", "docs/decisions.md"] {
        texts.push((name.into(), read(name)));
    }
    for entry in fs::read_dir(root().join("assets/questionnaires")).unwrap() {
        let file = entry.unwrap().path();
        let text = fs::read_to_string(&file).unwrap();
        texts.push((file, text));
    }
    let dead: Vec<String> = texts
        .iter()
        .flat_map(|(file, text)| dead_citations(text, &references, &decisions).into_iter().map(move |key| (file, key)))
        .map(|(file, key)| format!("{} cites {key}", file.display()))
        .collect();
    assert!(dead.is_empty(), "add these to docs/references.md or docs/decisions.md:\n{}", dead.join("\n"));
}

#[test]
fn the_check_of_citations_sees_every_form() {
    let (references, decisions) = (
        "\n### `ring`: roads\n\n## Works\n\n* **[HC22]** X.\n* **[Stern 2018]** R. Stern,\n  D. Work. 2018.\n* **[J2944]** SAE J2944.",
        "\n## 4. A\n",
    );
    let dead = |text: &str| dead_citations(text, references, decisions);
    let alive = "HC22's ring (docs/references.md: ring; Stern et al. 2018, eq. 1), SAE J2944, docs/decisions.md: 4, Work (2018)";
    assert_eq!(dead(alive), Vec::<String>::new());
    // Spelt in two parts, so that the check does not find this file.
    assert_eq!(dead(concat!("as FA", "CTS 3 has it (DE", "SIGN 4)")), ["DESIGN", "FACTS"]);
    assert_eq!(
        dead("docs/references.md: circle, docs/decisions.md: 5"),
        [concat!("docs/", "references.md: circle"), concat!("docs/", "decisions.md: 5")]
    );
    assert_eq!(
        dead("WX21, SAE J1; Stern et al. 2019; Borg and Quill (2018)"),
        ["WX21", "SAE J1", "Stern 2019", "Quill 2018"]
    );
}

/// Returns names and versions of packages from lines in which `name` and `version` follow each other, as in `Cargo.lock`.
fn locked_packages(lock: &str) -> BTreeSet<(String, String)> {
    let quoted = |line: &str, key: &str| Some(line.strip_prefix(key)?.trim_matches('"').to_owned());
    let lines: Vec<&str> = lock.lines().collect();
    let pairs = lines.windows(2);
    pairs.filter_map(|two| Some((quoted(two[0], "name = ")?, quoted(two[1], "version = ")?))).collect()
}

#[test]
fn third_party_notices_match_the_lock_file() {
    let read = |name: &str| fs::read_to_string(root().join(name)).unwrap();
    let mut locked = locked_packages(&read("Cargo.lock"));
    for own in ["codrive", "codrive-core", "codrive-python"] {
        assert!(locked.remove(&(own.into(), env!("CARGO_PKG_VERSION").into())), "{own}");
    }
    let rows = read("THIRD-PARTY.md");
    let cells = rows.lines().map(|row| row.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>());
    let packages = cells.filter(|cells| cells.len() >= 5 && cells[1] != "library" && cells[1] != "---");
    let listed: BTreeSet<(String, String)> = packages.map(|cells| (cells[1].clone(), cells[2].clone())).collect();
    let differing: Vec<_> = locked.symmetric_difference(&listed).collect();
    assert!(differing.is_empty(), "THIRD-PARTY.md is not Cargo.lock's: run scripts/third-party\n{differing:?}");
    assert!(locked.len() > 100);
}

/// Returns the files that `text` links to in Markdown, without web addresses and anchors within a page.
fn links(text: &str) -> Vec<&str> {
    let targets = text.match_indices("](").filter_map(|(at, mark)| text[at + mark.len()..].split(')').next());
    targets.filter(|target| !target.contains("://")).filter_map(|target| target.split('#').next()).collect()
}

#[test]
fn papers_of_the_project_link_to_files_that_exist() {
    let folders = ["docs", "docs/explanation", "docs/how-to", "docs/reference", "docs/sheets", "docs/tutorials"]
        .map(|folder| fs::read_dir(root().join(folder)).unwrap());
    let mut pages: Vec<PathBuf> = folders.into_iter().flatten().map(|entry| entry.unwrap().path()).collect();
    pages.extend(["README.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(|name| root().join(name)));
    for page in pages.iter().filter(|page| page.extension().is_some_and(|e| e == "md")) {
        for target in links(&fs::read_to_string(page).unwrap()) {
            let file = page.parent().unwrap().join(target);
            assert!(target.is_empty() || file.exists(), "{} links to {target}, which is not there", page.display());
        }
    }
}

#[test]
fn the_version_to_cite_is_the_programs_version() {
    let citation = fs::read_to_string(root().join("CITATION.cff")).unwrap();
    assert!(citation.lines().any(|line| line == concat!("version: ", env!("CARGO_PKG_VERSION"))));
}
