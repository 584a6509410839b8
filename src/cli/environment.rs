//! What the libraries below read from the environment, put right before one of them does. In: variables. Out: changed ones.

use crate::traffic::sumo;
use std::{env, ffi::OsString, path::Path};

/// A locale that C libraries know everywhere; the program itself speaks one language and UTF-8.
const LOCALE: &str = "C.UTF-8";

/// Changes the variables at which a library below would end the program or complain.
///
/// # Safety
/// No other thread runs yet: the environment is not guarded against reading while it changes.
pub unsafe fn prepare() {
    let home = sumo::home().ok();
    for (name, value) in changes(|name| env::var_os(name).filter(|value| !value.is_empty()), home.as_deref()) {
        // SAFETY: the caller promises that this thread is alone.
        unsafe { env::set_var(name, value) };
    }
}

/// The variables to be changed; `sumo` is SUMO's folder, where it is on this machine.
fn changes(of: impl Fn(&str) -> Option<OsString>, sumo: Option<&Path>) -> Vec<(&'static str, OsString)> {
    let mut changes = Vec::new();
    // Xerces in SUMO takes what follows the dot as the name of an encoding, and ends the process (exit 255) where there is
    // none of that name, as in C.UTF-8@x.
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(&of);
    let encoding = locale.and_then(|name| Some(name.to_string_lossy().split_once('.')?.1.to_ascii_lowercase()));
    if encoding.is_some_and(|encoding| !["utf-8", "utf8"].contains(&encoding.as_str())) {
        changes.push(("LC_ALL", LOCALE.into()));
    }
    // Mesa's layer that moves the desktop's graphics card to the front asks Wayland for it, which complains on the standard
    // error when this is missing, once for each look. The card is chosen by its power in any case.
    let asked = ["MESA_VK_DEVICE_SELECT", "DRI_PRIME"].into_iter().any(|name| of(name).is_some());
    if of("XDG_RUNTIME_DIR").is_none() && !asked {
        changes.push(("NODEVICE_SELECT", "1".into()));
    }
    // SUMO's library of projections reads a table of its own version, and complains of another's and of none.
    if let Some(table) = sumo.map(|home| home.join("data/proj")).filter(|folder| folder.join("proj.db").is_file()) {
        // Its name since version 9.1, and before.
        changes.extend(["PROJ_DATA", "PROJ_LIB"].map(|name| (name, table.clone().into_os_string())));
    }
    // liblsl reads settings from the working folder, which may name a file to write. Those of the user and of the machine stay.
    if of("LSLAPICFG").is_none() {
        let home = of("HOME").map(|home| Path::new(&home).join("lsl_api/lsl_api.cfg"));
        let known = home.into_iter().chain(["/etc/lsl_api/lsl_api.cfg", "/dev/null"].map(Into::into));
        changes.extend(known.into_iter().find(|file| file.exists()).map(|file| ("LSLAPICFG", file.into_os_string())));
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(there: &[(&str, &str)]) -> Vec<&'static str> {
        let of = |name: &str| there.iter().find(|(n, _)| *n == name).map(|(_, value)| value.into());
        let names = changes(of, None).into_iter().map(|(name, _)| name);
        // Which file it is depends on this machine.
        names.filter(|name| *name != "LSLAPICFG").collect()
    }

    #[test]
    fn liblsl_reads_settings_of_the_user_and_the_machine_and_none_of_the_working_folder() {
        let home = tempfile::tempdir().unwrap();
        let settings = |named: Option<&str>| {
            let of = |name: &str| match name {
                "HOME" => Some(home.path().as_os_str().to_owned()),
                "LSLAPICFG" => named.map(Into::into),
                _ => None,
            };
            changes(of, None).into_iter().find(|(name, _)| *name == "LSLAPICFG").map(|(_, file)| file)
        };
        // Without a file that is named, the library would look in the working folder first.
        assert!(settings(None).is_some_and(|file| file == "/dev/null" || file == "/etc/lsl_api/lsl_api.cfg"));
        let own = home.path().join("lsl_api/lsl_api.cfg");
        std::fs::create_dir_all(own.parent().unwrap()).unwrap();
        std::fs::write(&own, "").unwrap();
        assert_eq!(settings(None), Some(own.into_os_string()));
        assert_eq!(settings(Some("/lab/lsl_api.cfg")), None, "what a person names stays");
    }

    #[test]
    fn a_locale_with_an_encoding_of_its_own_is_replaced_and_others_stay() {
        let session = ("XDG_RUNTIME_DIR", "/run/user/1000");
        for locale in ["C.UTF-8@x", "../x", "de_DE.UTF-8@euro", "de_DE.ISO-8859-1", "."] {
            assert_eq!(changed(&[session, ("LC_ALL", locale)]), ["LC_ALL"], "{locale}");
            assert_eq!(changed(&[session, ("LANG", locale)]), ["LC_ALL"], "{locale}");
        }
        for locale in ["C", "POSIX", "de_DE.UTF-8", "de_DE.utf8", "xx_YY", "de_DE@euro"] {
            assert_eq!(changed(&[session, ("LC_ALL", locale), ("LANG", "../x")]), [""; 0], "{locale}");
        }
    }

    #[test]
    fn the_table_of_projections_is_sumos_own_whatever_was_set() {
        let home = tempfile::tempdir().unwrap();
        let table = home.path().join("data/proj");
        std::fs::create_dir_all(&table).unwrap();
        let of = |name: &str| (name == "PROJ_DATA").then(|| "/usr/share/proj".into());
        let changed = || changes(of, Some(home.path())).into_iter().filter(|(name, _)| name.starts_with("PROJ"));
        assert_eq!(changed().count(), 0, "a folder without the table would be worse than the system's");
        std::fs::write(table.join("proj.db"), "").unwrap();
        let expected = ["PROJ_DATA", "PROJ_LIB"].map(|name| (name, table.clone().into_os_string()));
        assert_eq!(changed().collect::<Vec<_>>(), expected);
    }

    #[test]
    fn without_a_session_no_graphics_card_is_asked_for_by_wayland() {
        assert_eq!(changed(&[]), ["NODEVICE_SELECT"]);
        assert_eq!(changed(&[("DRI_PRIME", "1")]), [""; 0]);
    }
}
