//! Location of SUMO and of the shim on this machine. Out: paths, or [`TrafficError::Absent`] with the files that were sought.

use super::shim::Shim;
use crate::{data_folders, native_code, traffic::TrafficError};
use std::{
    env::{self, consts},
    path::{Path, PathBuf},
};

/// Returns SUMO's home: `CODRIVE_SUMO_HOME` alone if it is set, else the first of [`native_code::sumo_homes`] that holds libsumo.
pub fn home() -> Result<PathBuf, TrafficError> {
    if let Some(home) = env::var_os("CODRIVE_SUMO_HOME").map(PathBuf::from) {
        return library(&home).map(|_| home);
    }
    native_code::sumo_homes().into_iter().find(|home| library(home).is_ok()).ok_or_else(|| {
        let text =
            "libsumocpp is neither in SUMO_HOME, nor in a folder beside the program, nor in the program's checkout";
        TrafficError::Absent(text.to_string())
    })
}

/// Returns SUMO's home and the version that its library reports. Loads the library.
///
/// # Errors
/// SUMO is not here, in use, or cannot be loaded.
pub fn version() -> Result<(PathBuf, String), TrafficError> {
    let home = home()?;
    let version = Shim::open(&home)?.version()?;
    Ok((home, version))
}

/// Returns the path of SUMO's program in `home`.
pub fn program(home: &Path) -> PathBuf {
    home.join("bin").join(format!("sumo{}", consts::EXE_SUFFIX))
}

/// Returns the path of libsumo in `home`, on which the shim depends.
pub(super) fn library(home: &Path) -> Result<PathBuf, TrafficError> {
    let file = format!("{}sumocpp{}", consts::DLL_PREFIX, consts::DLL_SUFFIX);
    let found = ["lib64", "lib", "bin"].iter().map(|folder| home.join(folder).join(&file)).find(|path| path.exists());
    found.ok_or_else(|| TrafficError::Absent(format!("no {file} in {}", home.display())))
}

/// Shim embedded in the program: file name and bytes (build.rs); empty if the program was built without SUMO.
const EMBEDDED_SHIM: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/embedded_shim.rs"));

/// Returns the path of the shim: beside the program (as shipped), else in the build output if it still exists, else the program's own copy
/// in the user's cache.
pub(super) fn shim() -> Result<PathBuf, TrafficError> {
    let file = format!("{}codrive_sumo{}", consts::DLL_PREFIX, consts::DLL_SUFFIX);
    let beside = native_code::program().and_then(|program| Some(program.parent()?.join(&file)));
    let built = native_code::build_output().map(|folder| folder.join(&file));
    shim_of(beside.into_iter().chain(built), &file)
}

/// Returns the first of these paths that exists, else the program's own copy.
fn shim_of(mut places: impl Iterator<Item = PathBuf>, file: &str) -> Result<PathBuf, TrafficError> {
    if let Some(found) = places.find(|path| path.exists()) {
        return Ok(found);
    }
    if EMBEDDED_SHIM.is_empty() {
        return Err(TrafficError::Absent(
            "this program was built without SUMO; build it again on a machine with SUMO".to_string(),
        ));
    }
    let folder = data_folders::unpacked_files("sumo", EMBEDDED_SHIM);
    folder.map(|folder| folder.join(file)).map_err(|why| TrafficError::Absent(why.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_missing_shim_is_written_from_the_copy_in_the_program() {
        let (name, bytes) = EMBEDDED_SHIM.first().expect("built with SUMO");
        let built = Path::new(env!("CODRIVE_SHIM_DIR")).join(name);
        assert!(fs::read(&built).expect("the build left it") == *bytes);
        assert_eq!(shim_of([built.clone()].into_iter(), name).expect("it is there"), built);
        let own = shim_of([PathBuf::from("nowhere").join(name)].into_iter(), name).expect("it can be written");
        assert!(own.ends_with(name) && own != built);
        assert!(fs::read(&own).expect("written") == *bytes);
    }
}
