//! Where the program's data lie: maps, policies, questionnaires, studies. In: what the person named, the environment, where the
//! program stands. Out: the folder that holds `maps/` and `assets/`, and the folder of the person's own maps. What the program
//! brings is in it, too, so that its file alone drives.

use crate::{native_code, private, temporary::TemporaryFolder};
use sha2::{Digest, Sha256};
use std::{
    env,
    ffi::OsString,
    fs, io,
    path::{Path, PathBuf},
    sync::OnceLock,
};

/// Paths below the root and their bytes (build.rs): each map, each policy's own file, questionnaires and studies.
const EMBEDDED: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/embedded.rs"));

/// A folder with this file holds the program's data.
const SIGN: &str = "maps/ring-250/net.xml";

/// True if a road network or a demand that comes with the program has these bytes.
pub fn is_shipped_for_sumo(bytes: &[u8]) -> bool {
    EMBEDDED.iter().any(|(name, shipped)| name.ends_with(".xml") && *shipped == bytes)
}

/// Why the program's data cannot be used; with the remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DataFolderError {
    /// The folder that was named holds none.
    #[error(
        "{}, named by {named_by}, does not hold {SIGN}\n  remedy: name the folder that holds maps and assets, or none: the \
         program brings its own",
        folder.display()
    )]
    NoData {
        /// Which folder.
        folder: PathBuf,
        /// The flag or the variable.
        named_by: &'static str,
    },
    /// They are nowhere, and the program's own copy cannot be written.
    #[error(
        "the program's maps and policies are nowhere on this machine, and its own copy cannot be written:\n  {}\n  remedy: \
         --data DIR names the folder with maps and assets, or TMPDIR one that can be written to",
        faults.join("\n  ")
    )]
    NotWritable {
        /// Each place and what the system said.
        faults: Vec<String>,
    },
}

static GIVEN: OnceLock<PathBuf> = OnceLock::new();
static FOUND: OnceLock<Result<PathBuf, DataFolderError>> = OnceLock::new();

/// The person named a folder, which comes before all others.
///
/// # Errors
/// It does not hold the program's data; the message says what is missing.
pub fn give(folder: &Path) -> Result<(), DataFolderError> {
    check(folder, "--data")?;
    let _ = GIVEN.set(folder.into());
    Ok(())
}

/// Checks the folder that the environment names, if it names one.
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

/// The folder that holds `maps/` and `assets/`, the first of: the one that was given (`--data`), `CODRIVE_DATA`, the program's
/// own folder, `../share/codrive` from there, `codrive` in the XDG data folders, the checkout that the program was built in and lies in.
/// Otherwise what is in the program, written to the user's cache. Maps and policies that lie in the working folder or above it
/// by chance are none of the program's.
///
/// Where that cannot be written either ([`require`] says why) it is a folder that is not there.
pub fn root() -> &'static Path {
    const NOWHERE: &str = "no-data";
    GIVEN.get().map_or_else(|| FOUND.get_or_init(find).as_deref().unwrap_or(Path::new(NOWHERE)), PathBuf::as_path)
}

/// What needs the data is not begun without.
///
/// # Errors
/// They are nowhere, and the program's own could not be written; with the remedy.
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

/// Place of the program, and the checkout around it.
struct ProgramPlace {
    program: Option<PathBuf>,
    checkout: Option<PathBuf>,
}

type EnvironmentLookup<'a> = &'a dyn Fn(&str) -> Option<OsString>;

fn set(variable: EnvironmentLookup<'_>, name: &str) -> Option<PathBuf> {
    variable(name).filter(|value| !value.is_empty()).map(PathBuf::from)
}

/// The variable that names a folder of data, and the folder, if one is named.
fn named(variable: EnvironmentLookup<'_>) -> Option<(&'static str, PathBuf)> {
    const NAME: &str = "CODRIVE_DATA";
    Some((NAME, set(variable, NAME)?))
}

/// The folder that the environment names, for a line at the start of the program; `None` if a person named one by hand.
pub fn named_by_environment() -> Option<(&'static str, PathBuf)> {
    named(&|name| env::var_os(name)).filter(|_| GIVEN.get().is_none())
}

/// All places in their order, those that are not there too.
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

/// The folder of the person's own data; `None` without a home.
pub fn user() -> Option<PathBuf> {
    user_by(&|name| env::var_os(name))
}

fn user_by(variable: EnvironmentLookup<'_>) -> Option<PathBuf> {
    let data = set(variable, "XDG_DATA_HOME").or_else(|| set(variable, "APPDATA"));
    Some(data.or_else(|| Some(set(variable, "HOME")?.join(".local/share")))?.join("codrive"))
}

/// A folder with files that are in the program, such as a library that it opens: in the user's cache, else in the folder for temporary
/// files; written once a version.
///
/// # Errors
/// Neither can be written to.
pub fn unpacked_files(kind: &str, files: &[(&str, &[u8])]) -> Result<PathBuf, DataFolderError> {
    in_cache(&|name| env::var_os(name), kind, files)
}

/// The embedded files, as [`unpacked_files`] writes files.
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

/// A folder of this user among the temporary files.
fn temporary() -> PathBuf {
    let folder = env::temp_dir();
    let user = own_number(&folder).unwrap_or(0);
    folder.join(format!("codrive-{user}"))
}

/// The number of this user, as a file has it that is made in `folder`; 0 where systems have none.
fn own_number(folder: &Path) -> io::Result<u32> {
    // It has no name, or one that cannot be guessed.
    let made = tempfile::tempfile_in(folder)?.metadata();
    #[cfg(unix)]
    return made.map(|made| std::os::unix::fs::MetadataExt::uid(&made));
    #[cfg(not(unix))]
    made.map(|_| 0)
}

/// Makes the folder for the user alone. One that others could have made, or can write to, is not trusted.
fn private_folder(folder: &Path) -> io::Result<()> {
    private::folder(folder)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let there = fs::symlink_metadata(folder)?;
        if !there.is_dir() || there.mode() & 0o022 != 0 || own_number(folder)? != there.uid() {
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, "others can write to it"));
        }
    }
    Ok(())
}

/// What tells one version's files from another's.
fn hash(files: &[(&str, &[u8])]) -> String {
    let mut hash = Sha256::new();
    for (name, bytes) in files {
        hash.update(name.as_bytes());
        hash.update(bytes);
    }
    hash.finalize()[..6].iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Writes the files beside `folder` and moves them there whole, unless they are there and unchanged.
fn unpack(folder: &Path, files: &[(&str, &[u8])]) -> io::Result<PathBuf> {
    let is_there = || files.iter().all(|(name, bytes)| fs::read(folder.join(name)).is_ok_and(|there| there == *bytes));
    if is_there() {
        return Ok(folder.into());
    }
    let beside = TemporaryFolder::within(folder.parent().unwrap_or(folder))?;
    let unfinished = beside.path().join("files");
    for (name, bytes) in files {
        let file = unfinished.join(name);
        private::folder(file.parent().unwrap_or(&unfinished))?;
        fs::write(file, bytes)?;
    }
    let _ = fs::remove_dir_all(folder);
    let moved = fs::rename(&unfinished, folder);
    // Another program may have been sooner.
    if moved.is_err() && !is_there() {
        moved?;
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
    fn places_are_looked_through_in_their_order() {
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
        // A home of its own for data; empty variables say nothing.
        let set = [("XDG_DATA_HOME", "/data"), ("HOME", "/home/ada"), ("CODRIVE_DATA", ""), ("XDG_DATA_DIRS", "")];
        assert_eq!(places(&set, "/b/codrive", None)[..3], ["/b", "/share/codrive", "/data/codrive"]);
        assert!(places(&[], "/b/codrive", None).iter().all(|place| !place.contains(".local")));
    }

    #[test]
    fn what_is_embedded_is_what_is_shipped_and_is_written_whole_once() {
        let project = Path::new(env!("CARGO_MANIFEST_DIR"));
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
        // What somebody has changed is put right.
        fs::write(folder.join(SIGN), "<net/>").unwrap();
        assert_eq!(unpacked(&variable).unwrap(), folder);
        assert!(fs::read(folder.join(SIGN)).unwrap().len() > 1000);
        assert_eq!(fs::read_dir(folder.parent().unwrap()).unwrap().count(), 1, "nothing is left beside it");
        // Other files have a folder of their own, and other bytes another.
        let library = |bytes: &'static [u8]| in_cache(&variable, "library", &[("lib.so", bytes)]).unwrap();
        let (one, other) = (library(b"one"), library(b"other"));
        assert!(one != other && one.parent() == folder.parent());
        assert_eq!([one, other].map(|folder| fs::read(folder.join("lib.so")).unwrap()), [&b"one"[..], b"other"]);
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
