//! Parts of the packages that the program makes itself, and the report for faults.

use crate::cli::codrive;
use std::fs;

fn printed(arguments: &[&str]) -> String {
    let output = codrive(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_verbose_version_names_build_data_sumo_graphics_and_system() {
    let report = printed(&["--version", "--verbose"]);
    let value = |name: &str| {
        let line = report.lines().find(|line| line.split_whitespace().next() == Some(name));
        line.unwrap_or_else(|| panic!("{name} is missing in:\n{report}"))[name.len()..].trim().to_owned()
    };
    assert!(report.starts_with(concat!("codrive ", env!("CARGO_PKG_VERSION"), "\n")), "{report}");
    assert_eq!(value("features"), if cfg!(feature = "tune") { "desktop, onnx, tune" } else { "desktop, onnx" });
    assert!(value("build").contains(std::env::consts::ARCH) && value("build").contains("rustc 1."), "{report}");
    assert_eq!(value("program"), fs::canonicalize(env!("CARGO_BIN_EXE_codrive")).unwrap().display().to_string());
    assert_eq!(value("data"), env!("CARGO_MANIFEST_DIR"));
    // scripts/setup brings this version.
    assert!(value("SUMO").starts_with("SUMO 1.28.0 in "), "{report}");
    let kernel = fs::read_to_string("/proc/sys/kernel/osrelease").unwrap();
    assert!(value("system").contains(kernel.trim()), "{report}");
    assert!(!value("graphics").starts_with("none") && !value("commit").is_empty(), "{report}");
    assert_eq!(printed(&["-v", "-V"]), report);
    // One line, and features for scripts/drive.
    assert_eq!(printed(&["-V"]), concat!("codrive ", env!("CARGO_PKG_VERSION"), "\n"));
    assert!(printed(&["--version"]).lines().nth(1).unwrap().starts_with("features: desktop"));
}

#[test]
fn without_sumo_the_verbose_version_gives_the_reason() {
    let output = codrive(&["--version", "--verbose"]).env("CODRIVE_SUMO_HOME", "/nowhere").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && text.contains("\nSUMO       none: ") && text.contains("/nowhere"), "{text}");
}

#[test]
fn every_command_has_a_manual_page_with_all_its_flags() {
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("pages");
    printed(&["man", pages.to_str().unwrap()]);
    let read = |name: &str| fs::read_to_string(pages.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    for file in fs::read_dir(&pages).unwrap() {
        let name = file.unwrap().file_name().into_string().unwrap();
        let text = read(&name);
        // The first macro of a page of man(7) is TH.
        let first = text.lines().find(|line| line.starts_with(".TH")).unwrap_or_else(|| panic!("{name} has no .TH"));
        let title = name.trim_end_matches(".1").to_uppercase();
        assert!(
            first.starts_with(&format!(".TH {title} 1"))
                && first.contains(concat!("codrive ", env!("CARGO_PKG_VERSION"))),
            "{name}: {first}"
        );
        assert!(text.contains("\n.SH NAME\n") && text.contains("\n.SH SYNOPSIS\n"), "{name}");
    }
    // Commands as the help lists them: two spaces, then the name.
    let commands: Vec<String> = printed(&["--help"])
        .lines()
        .filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next().map(str::to_owned))
        .filter(|word| word.chars().all(|c| c.is_ascii_lowercase()))
        .collect();
    assert!(commands.len() > 15 && commands.iter().any(|name| name == "man"), "{commands:?}");
    for name in commands {
        assert!(read("codrive.1").contains(&format!("codrive\\-{name}(1)")), "{name}");
        read(&format!("codrive-{name}.1"));
    }
    read("codrive-map-list.1");
    assert!(!pages.join("codrive-check-network.1").exists(), "it is for the program itself");
    assert!(read("codrive-drive.1").contains("\\-\\-mirror\\-yaw"), "a flag that only --help-all lists");
}
