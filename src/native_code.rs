//! Places from which the program loads libraries and runs other programs. In: the program's own file, the environment, places
//! fixed at build time. Out: folders in their order.
//!
//! Files in the working folder or above it are data: a library or program there is never loaded or run by itself. Allowed
//! places are: those named by an environment variable, beside the program, in the checkout that the program was built in and
//! still lies in, and those of the system.

use std::{
    env,
    path::{Path, PathBuf},
    process::Command,
    sync::OnceLock,
};

static FILE: OnceLock<PathBuf> = OnceLock::new();

/// Sets the file that counts as the program if codrive is a library in another one, as in Python.
pub fn program_is(file: PathBuf) {
    let _ = FILE.set(file);
}

/// Returns the program's file, with links resolved.
pub fn program() -> Option<PathBuf> {
    let file = FILE.get().cloned().or_else(|| env::current_exe().ok())?;
    Some(file.canonicalize().unwrap_or(file))
}

/// Returns the checkout that the program was built in, if the program lies in it or where that build put it.
pub fn checkout() -> Option<PathBuf> {
    let root = Path::new(env!("CODRIVE_ROOT"));
    checkout_around(&program()?, root, built_into(Path::new(env!("CODRIVE_SHIM_DIR"))))
}

/// Returns the folder of cargo's build output, from the output folder of a build script: `PROFILE/build/NAME/out`.
fn built_into(out: &Path) -> Option<&Path> {
    out.ancestors().nth(3)
}

fn checkout_around(program: &Path, root: &Path, built_into: Option<&Path>) -> Option<PathBuf> {
    let whole = |folder: &Path| folder.canonicalize().ok();
    let root = whole(root)?;
    let is_inside = |folder: &Path| whole(folder).is_some_and(|folder| program.starts_with(folder));
    (is_inside(&root) || built_into.is_some_and(is_inside)).then_some(root)
}

/// Returns the folder of the SUMO shim that the build made; `None` if the program has left its checkout.
pub fn build_output() -> Option<PathBuf> {
    checkout().map(|_| env!("CODRIVE_SHIM_DIR").into())
}

/// Returns candidate homes of SUMO, the most specific first; they need not exist.
pub fn sumo_homes() -> Vec<PathBuf> {
    let named = env::var_os("SUMO_HOME").filter(|home| !home.is_empty()).map(PathBuf::from);
    let at_build = Path::new(env!("CODRIVE_SUMO_HOME_AT_BUILD"));
    homes(named, program().as_deref(), checkout().as_deref(), at_build)
}

fn homes(named: Option<PathBuf>, program: Option<&Path>, checkout: Option<&Path>, at_build: &Path) -> Vec<PathBuf> {
    let mut homes: Vec<PathBuf> = named.into_iter().collect();
    if let Some(folder) = program.and_then(Path::parent) {
        homes.extend(
            [".sumo/sumo", "../lib/codrive/sumo", "../lib/sumo", "../share/sumo"].map(|name| folder.join(name)),
        );
    }
    if let Some(checkout) = checkout {
        homes.extend([at_build.to_path_buf(), checkout.join(".sumo/sumo")]);
    }
    // Outside its checkout, only a SUMO in a system folder is kept: another user may own other folders by now.
    if ["/usr", "/opt"].iter().any(|system| at_build.starts_with(system)) {
        homes.push(at_build.into());
    }
    homes.retain(|home| !home.as_os_str().is_empty());
    homes
}

/// Returns the folders, beside the program or in its checkout, for a library of this kind.
pub fn library_folders(kind: &str) -> Vec<PathBuf> {
    let beside = program().and_then(|program| program.parent().map(Path::to_path_buf));
    let in_folder = beside.iter().flat_map(|folder| [folder.clone(), folder.join("../lib")]);
    in_folder.chain(checkout().map(|root| root.join(format!(".{kind}")))).collect()
}

/// Opens a library. A bare name is searched in the system's library folders only.
///
/// # Errors
/// The library is missing, or not for this system.
///
/// # Safety
/// The library may run code when it is loaded.
pub unsafe fn open(path: &Path) -> Result<libloading::Library, libloading::Error> {
    #[cfg(windows)]
    if path.components().count() == 1 {
        use libloading::os::windows::{LOAD_LIBRARY_SEARCH_DEFAULT_DIRS, Library};
        // SAFETY: as the caller promises. Without this flag Windows looks in the working folder, too.
        return unsafe { Library::load_with_flags(path, LOAD_LIBRARY_SEARCH_DEFAULT_DIRS) }.map(Into::into);
    }
    // SAFETY: as the caller promises.
    unsafe { libloading::Library::new(path) }
}

/// Makes the child process of a command end with the thread that starts it, and so with this program in any case. On systems
/// other than Linux the child outlives a killed program.
pub fn end_with_parent(command: &mut Command) -> &mut Command {
    #[cfg(target_os = "linux")]
    {
        use nix::libc;
        let parent = std::process::id();
        let arm = move || {
            // SAFETY: neither call takes a pointer.
            let is_orphan = unsafe {
                libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL);
                // The parent may have ended before the call.
                libc::getppid().unsigned_abs() != parent
            };
            if is_orphan { Err(std::io::Error::from_raw_os_error(libc::ESRCH)) } else { Ok(()) }
        };
        // SAFETY: between fork and exec only system calls are made: no allocation, no lock.
        unsafe { std::os::unix::process::CommandExt::pre_exec(command, arm) };
    }
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checkout_counts_only_for_programs_in_it_or_built_by_it() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| {
            let path = folder.path().canonicalize().unwrap().join(name);
            std::fs::create_dir_all(&path).unwrap();
            path
        };
        let (root, elsewhere) = (place("checkout"), place("elsewhere/debug"));
        let around =
            |program: &Path| checkout_around(program, &root, built_into(&place("elsewhere/debug/build/x/out")));
        assert_eq!(around(&root.join("target/debug/codrive")), Some(root.clone()));
        assert_eq!(around(&elsewhere.join("codrive")), Some(root.clone()), "CARGO_TARGET_DIR lies elsewhere");
        assert_eq!(around(&place("bin").join("codrive")), None, "it was installed");
        assert_eq!(around(&place("checkout-of-mine").join("codrive")), None, "the name alone begins alike");
        assert_eq!(checkout_around(&place("bin").join("codrive"), &place("bin").join("gone"), None), None);
        // This test program was built in the checkout.
        assert!(checkout().is_some_and(|root| root.join("maps").is_dir()));
    }

    #[test]
    fn homes_of_sumo_are_named_beside_the_program_in_its_checkout_or_systems() {
        let text = |homes: Vec<PathBuf>| homes.iter().map(|home| home.display().to_string()).collect::<Vec<_>>();
        let beside = ["/p/bin/.sumo/sumo", "/p/bin/../lib/codrive/sumo", "/p/bin/../lib/sumo", "/p/bin/../share/sumo"];
        let program = Some(Path::new("/p/bin/codrive"));
        let all = homes(Some("/named".into()), program, Some(Path::new("/c")), Path::new("/c/.sumo/sumo"));
        assert_eq!(text(all), [&["/named"][..], &beside, &["/c/.sumo/sumo", "/c/.sumo/sumo"]].concat());
        // Installed: the folder of the build may belong to another user now.
        assert_eq!(text(homes(None, program, None, Path::new("/home/ada/c/.sumo/sumo"))), beside);
        assert_eq!(
            text(homes(None, program, None, Path::new("/usr/share/sumo"))),
            [&beside[..], &["/usr/share/sumo"]].concat()
        );
        assert_eq!(text(homes(None, program, None, Path::new(""))), beside, "built without SUMO");
    }
}
