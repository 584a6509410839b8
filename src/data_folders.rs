//! Folders of the program's data: maps, policies, questionnaires, studies. In: `--data`, the environment, the program's
//! location. Out: the folder that holds `maps/` and `assets/`, and the folder of the user's own data. The shipped data are also
//! embedded in the program, so that its file alone is enough to drive.

use crate::{native_code, private, temporary::TemporaryFolder};
use sha2::{Digest, Sha256};
use std::{
    env,
    ffi::OsString,
    fs, io,
    path::{Path, PathBuf},
    sync::OnceLock,
};

/// Paths relative to the root, and contents (build.rs): each map, each policy's own file, questionnaires and studies.
const EMBEDDED: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/embedded.rs"));

/// File by which a folder is recognised as the program's data.
const SIGN: &str = "maps/ring-250/net.xml";

/// Checks whether a shipped road network or demand has these bytes.
pub fn is_shipped_for_sumo(bytes: &[u8]) -> bool {
    EMBEDDED.iter().any(|(name, shipped)| name.ends_with(".xml") && *shipped == bytes)
}

/// Reason why the program's data cannot be used, with the remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DataFolderError {
    /// Named folder without data.
    #[error(
        "{}, named by {named_by}, does not hold {SIGN}\n  remedy: name the folder with maps and assets, or name none \
         to use the program's own data",
        folder.display()
    )]
    NoData {
        /// Path of the folder.
        folder: PathBuf,
        /// Name of the flag or the environment variable.
        named_by: &'static str,
    },
    /// No data found, and the program's own copy cannot be written.
    #[error(
        "the program's maps and policies were not found, and its own copy cannot be written:\n  {}\n  remedy: name the \
         folder with maps and assets with --data DIR, or set TMPDIR to a writable folder",
        faults.join("\n  ")
    )]
    NotWritable {
        /// Each place tried, with the system's error.
        faults: Vec<String>,
    },
}

static GIVEN: OnceLock<PathBuf> = OnceLock::new();
static FOUND: OnceLock<Result<PathBuf, DataFolderError>> = OnceLock::new();

/// Sets the folder of the data, which then precedes all others.
///
/// # Errors
/// The folder does not hold the program's data; the message says what is missing.
pub fn give(folder: &Path) -> Result<(), DataFolderError> {
    check(folder, "--data")?;
    let _ = GIVEN.set(folder.into());
    Ok(())
}

/// Returns the folder that [`give`] has set.
pub fn given() -> Option<&'static Path> {
    GIVEN.get().map(PathBuf::as_path)
}

/// Checks the folder named by the environment, if any.
///
/// # Errors
/// As [`give`].
pub fn check_environment() -> Result<(), DataFolderError> {
    named(&|name| env::var_os(name)).map_or(Ok(()), |(name, folder)| check(&folder, name))
}

fn check(folder: &Path, named_by: &'static str) -> Result<(), DataFolderError> {
    if holds_data(folder) {
        return Ok(());
    }
    Err(DataFolderError::NoData { folder: folder.into(), named_by })
}

/// Returns the folder that holds `maps/` and `assets/`. It is the first of: the given folder (`--data`), `CODRIVE_DATA`, the
/// program's own folder, `../share/codrive` from there, `codrive` in the XDG data folders, and the checkout that the program
/// was built in and lies in. Otherwise it is a copy of the embedded data in the user's cache. Maps and policies in the working
/// folder or above it are never used.
///
/// If that copy cannot be written ([`require`] says why), the returned folder does not exist.
pub fn root() -> &'static Path {
    const NOWHERE: &str = "no-data";
    GIVEN.get().map_or_else(|| FOUND.get_or_init(find).as_deref().unwrap_or(Path::new(NOWHERE)), PathBuf::as_path)
}

/// Checks that the data are available, before work that needs them.
///
/// # Errors
/// No data were found, and the program's own copy cannot be written; with the remedy.
pub fn require() -> Result<(), DataFolderError> {
    match GIVEN.get() {
        Some(_) => Ok(()),
        None => FOUND.get_or_init(find).as_ref().map(|_| ()).map_err(Clone::clone),
    }
}

fn find() -> Result<PathBuf, DataFolderError> {
    let here = ProgramPlace { program: native_code::program(), checkout: native_code::checkout() };
    let variable = |name: &str| env::var_os(name);
    candidates(&variable, &here).into_iter().find(|folder| holds_data(folder)).map_or_else(|| unpacked(&variable), Ok)
}

fn holds_data(folder: &Path) -> bool {
    folder.join(SIGN).is_file()
}

/// Location of the program, and the checkout around it.
struct ProgramPlace {
    program: Option<PathBuf>,
    checkout: Option<PathBuf>,
}

type EnvironmentLookup<'a> = &'a dyn Fn(&str) -> Option<OsString>;

fn set(variable: EnvironmentLookup<'_>, name: &str) -> Option<PathBuf> {
    variable(name).filter(|value| !value.is_empty()).map(PathBuf::from)
}

/// Returns the environment variable that names a folder of data, and the folder, if it is set.
fn named(variable: EnvironmentLookup<'_>) -> Option<(&'static str, PathBuf)> {
    const NAME: &str = "CODRIVE_DATA";
    Some((NAME, set(variable, NAME)?))
}

/// Returns the folder named by the environment, for a line at the start of the program; `None` if `--data` was given.
pub fn named_by_environment() -> Option<(&'static str, PathBuf)> {
    named(&|name| env::var_os(name)).filter(|_| GIVEN.get().is_none())
}

/// Returns all candidate folders in their order; they need not exist.
fn candidates(variable: EnvironmentLookup<'_>, here: &ProgramPlace) -> Vec<PathBuf> {
    let mut list: Vec<PathBuf> = named(variable).into_iter().map(|(_, folder)| folder).collect();
    let beside = here.program.as_deref().and_then(Path::parent);
    list.extend(beside.map(Path::to_path_buf));
    list.extend(beside.and_then(Path::parent).map(|above| above.join("share/codrive")));
    list.extend(user_by(variable));
    let system = set(variable, "XDG_DATA_DIRS").unwrap_or_else(|| "/usr/local/share:/usr/share".into());
    list.extend(env::split_paths(&system).filter(|folder| folder.is_absolute()).map(|folder| folder.join("codrive")));
    list.extend(here.checkout.clone());
    list
}

/// Returns the folder of the user's own data; `None` without a home.
pub fn user() -> Option<PathBuf> {
    user_by(&|name| env::var_os(name))
}

fn user_by(variable: EnvironmentLookup<'_>) -> Option<PathBuf> {
    let data = set(variable, "XDG_DATA_HOME").or_else(|| set(variable, "APPDATA"));
    Some(data.or_else(|| Some(set(variable, "HOME")?.join(".local/share")))?.join("codrive"))
}

/// Writes embedded files, such as a library that the program opens, to a folder in the user's cache, or else among the
/// temporary files. Each version is written once. Returns the folder.
///
/// # Errors
/// Neither place can be written to.
pub fn unpacked_files(kind: &str, files: &[(&str, &[u8])]) -> Result<PathBuf, DataFolderError> {
    in_cache(&|name| env::var_os(name), kind, files)
}

/// Writes the embedded data, as [`unpacked_files`] does.
fn unpacked(variable: EnvironmentLookup<'_>) -> Result<PathBuf, DataFolderError> {
    in_cache(variable, "data", EMBEDDED)
}

fn in_cache(variable: EnvironmentLookup<'_>, kind: &str, files: &[(&str, &[u8])]) -> Result<PathBuf, DataFolderError> {
    let name = format!("{kind}-{}", hash(files));
    let cache = set(variable, "XDG_CACHE_HOME").or_else(|| Some(set(variable, "HOME")?.join(".cache")));
    let places: Vec<PathBuf> = cache.into_iter().map(|cache| cache.join("codrive")).chain([temporary()]).collect();
    let mut faults = Vec::new();
    for place in &places {
        match private_folder(place).and_then(|()| unpack(&place.join(&name), files)) {
            Ok(folder) => return Ok(folder),
            Err(error) => faults.push(format!("{}: {error}", place.display())),
        }
    }
    Err(DataFolderError::NotWritable { faults })
}

/// Returns the path of this user's folder among the temporary files.
fn temporary() -> PathBuf {
    let folder = env::temp_dir();
    let user = own_number(&folder).unwrap_or(0);
    folder.join(format!("codrive-{user}"))
}

/// Returns this user's id, as the owner of a file made in `folder`; 0 on systems without ids.
fn own_number(folder: &Path) -> io::Result<u32> {
    // The file has no name, or one that cannot be guessed.
    let made = tempfile::tempfile_in(folder)?.metadata();
    #[cfg(unix)]
    return made.map(|made| std::os::unix::fs::MetadataExt::uid(&made));
    #[cfg(not(unix))]
    made.map(|_| 0)
}

/// Makes a private folder. A folder owned or writable by others is refused.
fn private_folder(folder: &Path) -> io::Result<()> {
    private::folder(folder)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let there = fs::symlink_metadata(folder)?;
        if !there.is_dir() || there.mode() & 0o022 != 0 || own_number(folder)? != there.uid() {
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, "other users can write to it"));
        }
    }
    Ok(())
}

/// Returns a hash that separates the files of different versions.
fn hash(files: &[(&str, &[u8])]) -> String {
    let mut hash = Sha256::new();
    for (name, bytes) in files {
        hash.update(name.as_bytes());
        hash.update(bytes);
    }
    hash.finalize()[..6].iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Writes the files of `folder` that are missing or changed. Each is replaced atomically and never removed: another program may be opening
/// it now.
fn unpack(folder: &Path, files: &[(&str, &[u8])]) -> io::Result<PathBuf> {
    let is_there = |name: &str, bytes: &[u8]| fs::read(folder.join(name)).is_ok_and(|there| there == bytes);
    let missing: Vec<_> = files.iter().filter(|(name, bytes)| !is_there(name, bytes)).collect();
    if missing.is_empty() {
        return Ok(folder.into());
    }
    let beside = TemporaryFolder::within(folder.parent().unwrap_or(folder))?;
    let unfinished = beside.path().join("file");
    for (name, bytes) in missing {
        let file = folder.join(name);
        private::folder(file.parent().unwrap_or(folder))?;
        let moved = private::replace_by(&file, &unfinished, bytes, |_| Ok(()));
        // Another program may have written it first, and have it open.
        if moved.is_err() && !is_there(name, bytes) {
            moved?;
        }
    }
    Ok(folder.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(set: &[(&str, &str)], program: &str, checkout: Option<&str>) -> Vec<String> {
        let variable = |name: &str| set.iter().find(|(n, _)| *n == name).map(|(_, value)| OsString::from(value));
        let here = ProgramPlace { program: Some(program.into()), checkout: checkout.map(Into::into) };
        candidates(&variable, &here).into_iter().map(|place| place.to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn candidate_folders_are_in_the_documented_order() {
        let set =
            [("CODRIVE_DATA", "/lab/data"), ("HOME", "/home/ada"), ("XDG_DATA_DIRS", "/opt/share:relative:/usr/share")];
        let list = places(&set, "/opt/codrive/bin/codrive", None);
        let all = [
            "/lab/data",
            "/opt/codrive/bin",
            "/opt/codrive/share/codrive",
            "/home/ada/.local/share/codrive",
            "/opt/share/codrive",
            "/usr/share/codrive",
        ];
        assert_eq!(list, all, "nothing of the working folder, and nothing above");
        let built = places(&set, "/home/ada/codrive/target/debug/codrive", Some("/home/ada/codrive"));
        assert_eq!(built.last().map(String::as_str), Some("/home/ada/codrive"));
        // XDG_DATA_HOME replaces the home; empty variables are ignored.
        let set = [("XDG_DATA_HOME", "/data"), ("HOME", "/home/ada"), ("CODRIVE_DATA", ""), ("XDG_DATA_DIRS", "")];
        assert_eq!(places(&set, "/b/codrive", None)[..3], ["/b", "/share/codrive", "/data/codrive"]);
        assert!(places(&[], "/b/codrive", None).iter().all(|place| !place.contains(".local")));
    }

    #[test]
    fn embedded_files_equal_the_shipped_ones_and_are_written_once() {
        let project = Path::new(env!("CODRIVE_ROOT"));
        for (name, bytes) in EMBEDDED {
            assert!(fs::read(project.join(name)).unwrap() == *bytes, "{name}");
        }
        let names: Vec<&str> = EMBEDDED.iter().map(|(name, _)| *name).collect();
        for name in [
            SIGN,
            "maps/ring-641/map.toml",
            "maps/practice/net.xml",
            "assets/policies/ring-250-speed/policy.toml",
            "assets/questionnaires/ssq.json",
            "assets/schemas/study.schema.json",
            "assets/studies/congestion.toml",
        ] {
            assert!(names.contains(&name), "{name} is not among {names:?}");
        }
        let cache = tempfile::tempdir().unwrap();
        let home = cache.path().as_os_str().to_owned();
        let variable = |name: &str| (name == "XDG_CACHE_HOME").then(|| home.clone());
        let folder = unpacked(&variable).unwrap();
        assert!(folder.starts_with(cache.path()) && holds_data(&folder));
        let written = fs::metadata(folder.join(SIGN)).unwrap().modified().unwrap();
        assert_eq!(unpacked(&variable).unwrap(), folder);
        assert_eq!(fs::metadata(folder.join(SIGN)).unwrap().modified().unwrap(), written, "not written again");
        // A changed file is restored.
        fs::write(folder.join(SIGN), "<net/>").unwrap();
        assert_eq!(unpacked(&variable).unwrap(), folder);
        assert!(fs::read(folder.join(SIGN)).unwrap().len() > 1000);
        assert_eq!(fs::read_dir(folder.parent().unwrap()).unwrap().count(), 1, "nothing is left beside it");
        // Other kinds of files get their own folder, and other contents as well.
        let library = |bytes: &'static [u8]| in_cache(&variable, "library", &[("lib.so", bytes)]).unwrap();
        let (one, other) = (library(b"one"), library(b"other"));
        assert!(one != other && one.parent() == folder.parent());
        assert_eq!([one, other].map(|folder| fs::read(folder.join("lib.so")).unwrap()), [&b"one"[..], b"other"]);
    }

    #[test]
    fn programs_that_start_at_once_never_take_each_others_files_away() {
        // Eight environments of one vector start at once on a machine where codrive has never run.
        for _ in 0..20 {
            let cache = tempfile::tempdir().unwrap();
            let home = cache.path().as_os_str().to_owned();
            let start = std::sync::Barrier::new(8);
            std::thread::scope(|scope| {
                for _ in 0..8 {
                    scope.spawn(|| {
                        start.wait();
                        let variable = |name: &str| (name == "XDG_CACHE_HOME").then(|| home.clone());
                        let folder = in_cache(&variable, "sumo", &[("lib.so", b"library")]).unwrap();
                        for _ in 0..50 {
                            assert_eq!(fs::read(folder.join("lib.so")).expect("it stays there"), b"library");
                        }
                    });
                }
            });
        }
    }

    #[test]
    fn a_folder_that_holds_no_data_is_refused_with_what_is_missing() {
        let folder = tempfile::tempdir().unwrap();
        let why = give(folder.path()).unwrap_err().to_string();
        assert!(
            why.contains("named by --data, does not hold maps/ring-250/net.xml") && why.contains("remedy"),
            "{why}"
        );
    }
}
