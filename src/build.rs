//! Builds a small shared library over libsumo from `src/traffic/sumo/shim.cpp`. The program opens it at run time (`traffic::sumo`). It
//! therefore builds and starts without SUMO, and SUMO's hundred bundled libraries do not get in the way of the graphics drivers. Without
//! SUMO or a C++ compiler, the build continues with a warning.

#[path = "map/shipped.rs"]
mod shipped;

use shipped::SHIPPED;
use std::{
    env,
    path::{Path, PathBuf},
    process::Command,
};

/// Source of the shim, and the files that it includes.
const SHIM: &str = "src/traffic/sumo/shim.cpp";
const INCLUDED: [&str; 2] = ["src/traffic/sumo/shim_data.hpp", "src/traffic/sumo/shim_state.hpp"];

fn main() {
    let package = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR"));
    let root = package.parent().expect("the package lies in src").to_owned();
    println!("cargo:rustc-env=CODRIVE_ROOT={}", root.display());
    for source in [SHIM].into_iter().chain(INCLUDED) {
        println!("cargo:rerun-if-changed={}", root.join(source).display());
    }
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=map/shipped.rs");
    println!("cargo:rerun-if-env-changed=SUMO_HOME");
    println!("cargo:rerun-if-env-changed=CODRIVE_SHIM_COMPILER");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    println!("cargo:rustc-env=CODRIVE_SHIM_DIR={}", out.display());
    let home = find_home(&root);
    // A missing path makes cargo check again at every build, as is needed while SUMO is missing.
    let header = home.clone().unwrap_or_else(|| root.join(".sumo/sumo")).join("include/libsumo/libsumo.h");
    println!("cargo:rerun-if-changed={}", header.display());
    embed(&root, &out).expect("the data that the program brings can be listed");
    let built = home
        .as_ref()
        .ok_or("SUMO is not here; run scripts/setup or set SUMO_HOME".to_string())
        .and_then(|home| build_shim(&root.join(SHIM), &out, home));
    if let Err(reason) = &built {
        println!("cargo:warning=built without SUMO: {reason}");
    }
    embed_shim(&out, built.is_ok()).expect("the list of libraries can be written");
    let home = home.filter(|_| built.is_ok()).unwrap_or_default();
    println!("cargo:rustc-env=CODRIVE_SUMO_HOME_AT_BUILD={}", home.display());
}

/// Lists the shim, if it was built, for embedding in the program (`traffic::sumo`). As a Python library the program has no folder of its
/// own.
fn embed_shim(out: &Path, is_built: bool) -> std::io::Result<()> {
    let name = shim_name();
    let text = match is_built {
        true => format!("&[({name:?}, include_bytes!({:?}))]\n", out.join(&name).display().to_string()),
        false => "&[]\n".into(),
    };
    std::fs::write(out.join("embedded_shim.rs"), text)
}

fn shim_name() -> String {
    format!("{}codrive_sumo{}", env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX)
}

/// Lists the files that are embedded in the program (`data_folders`): maps, the policies' own files, questionnaires, schemas, studies.
fn embed(root: &Path, out: &Path) -> std::io::Result<()> {
    let mut files = Vec::new();
    for (folder, endings) in [
        (
            "maps",
            &[
                "map.toml",
                "net.xml",
                "circuit.toml",
                "demand.rou.xml",
                "scenario.toml",
                "surroundings.xml",
                "leader.csv",
            ][..],
        ),
        ("assets/policies", &["policy.toml"]),
        ("assets/populations", &["toml"]),
        ("assets/questionnaires", &["json"]),
        ("assets/schemas", &["json"]),
        ("assets/studies", &["toml"]),
    ] {
        println!("cargo:rerun-if-changed={}", root.join(folder).display());
        list(&root.join(folder), endings, &mut files)?;
    }
    files.sort();
    let mut text = String::from("&[\n");
    for file in files {
        let name = file.strip_prefix(root).expect("below the root").to_string_lossy().replace('\\', "/");
        text += &format!("    ({name:?}, include_bytes!({:?})),\n", file.display().to_string());
    }
    std::fs::write(out.join("embedded.rs"), text + "]\n")
}

/// Collects the shipped files below `folder` with one of these name endings. Maps that a user has put beside the shipped ones are left out.
fn list(folder: &Path, endings: &[&str], files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            if !folder.ends_with("maps") || SHIPPED.contains(&name.as_str()) {
                list(&path, endings, files)?;
            }
        } else if endings.iter().any(|ending| name.ends_with(ending)) {
            files.push(path);
        }
    }
    Ok(())
}

/// Returns SUMO's home with headers and libraries: `SUMO_HOME`, else `.sumo/sumo` here.
fn find_home(root: &Path) -> Option<PathBuf> {
    let mut candidates: Vec<PathBuf> = env::var_os("SUMO_HOME").map(PathBuf::from).into_iter().collect();
    candidates.push(root.join(".sumo/sumo"));
    candidates
        .into_iter()
        .find(|home| home.join("include/libsumo/libsumo.h").exists() && library_folder(home).is_some())
}

fn library_folder(home: &Path) -> Option<PathBuf> {
    let names = ["libsumocpp.so", "libsumocpp.dylib"];
    ["lib64", "lib"].iter().map(|d| home.join(d)).find(|d| names.iter().any(|n| d.join(n).exists()))
}

fn build_shim(source: &Path, out: &Path, home: &Path) -> Result<(), String> {
    let folder = library_folder(home).ok_or("SUMO's libraries are not here")?;
    let mut build = cc::Build::new();
    // Optimised in every profile, as it runs in each step. Without debug symbols, as it is embedded in the program.
    build
        .cpp(true)
        .std("c++17")
        .pic(true)
        .opt_level(2)
        .debug(false)
        .include(home.join("include"))
        .cargo_metadata(false);
    // A cross compiler such as zig has another C++ library than SUMO, with which the shim exchanges objects.
    if let Some(compiler) = env::var_os("CODRIVE_SHIM_COMPILER").filter(|compiler| !compiler.is_empty()) {
        build.compiler(compiler);
    }
    let compiler = build.try_get_compiler().map_err(|error| error.to_string())?;
    let mut command: Command = compiler.to_command();
    let file = out.join(shim_name());
    command.args(["-shared", "-fvisibility=hidden"]).arg(source).arg("-o").arg(file);
    command.arg(format!("-L{}", folder.display())).arg("-lsumocpp");
    if cfg!(target_os = "linux") {
        // Without a path to libsumocpp: the program loads it first, from where SUMO is then. SUMO's bundled libraries are found through
        // its own paths.
        command.arg("-Wl,--allow-shlib-undefined");
    } else {
        command.arg(format!("-Wl,-rpath,{}", folder.display()));
    }
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("the C++ compiler failed ({status}) on {SHIM}")),
        Err(error) => Err(format!("no C++ compiler: {error}")),
    }
}
