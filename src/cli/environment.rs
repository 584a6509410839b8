//! Corrects environment variables before a library reads them. In: variables. Out: changed variables.

use crate::traffic::sumo;
use std::{env, ffi::OsString, path::Path};

/// Locale that every C library has; the program itself prints English in UTF-8 only.
const LOCALE: &str = "C.UTF-8";

/// Changes the variables that would make a library end the program or print complaints.
///
/// # Safety
/// No other thread may run: reading the environment while it changes is a data race.
pub unsafe fn prepare() {
    let home = sumo::home().ok();
    for (name, value) in changes(|name| env::var_os(name).filter(|value| !value.is_empty()), home.as_deref()) {
        // SAFETY: the caller promises that this thread is alone.
        unsafe { env::set_var(name, value) };
    }
}

/// Returns the variables to change; `sumo` is SUMO's folder, if it is on this machine.
fn changes(of: impl Fn(&str) -> Option<OsString>, sumo: Option<&Path>) -> Vec<(&'static str, OsString)> {
    let mut changes = Vec::new();
    // Xerces in SUMO takes the text after the dot as an encoding. It ends the process (exit 255) if there is no such encoding,
    // as in C.UTF-8@x.
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(&of);
    let encoding = locale.and_then(|name| Some(name.to_string_lossy().split_once('.')?.1.to_ascii_lowercase()));
    if encoding.is_some_and(|encoding| !["utf-8", "utf8"].contains(&encoding.as_str())) {
        changes.push(("LC_ALL", LOCALE.into()));
    }
    // Mesa's device-select layer asks Wayland for the desktop's graphics card. Without XDG_RUNTIME_DIR, Wayland prints a
    // complaint at each query. This program chooses the card by its power in any case.
    let asked = ["MESA_VK_DEVICE_SELECT", "DRI_PRIME"].into_iter().any(|name| of(name).is_some());
    if of("XDG_RUNTIME_DIR").is_none() && !asked {
        changes.push(("NODEVICE_SELECT", "1".into()));
    }
    // SUMO's PROJ library needs a table of its own version; it complains about any other and about none.
    if let Some(table) = sumo.map(|home| home.join("data/proj")).filter(|folder| folder.join("proj.db").is_file()) {
        // PROJ_DATA since PROJ 9.1, PROJ_LIB before.
        changes.extend(["PROJ_DATA", "PROJ_LIB"].map(|name| (name, table.clone().into_os_string())));
    }
    // liblsl reads settings from the working folder, which may name a file to write. Settings of the user and of the machine
    // stay.
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
        // The file depends on this machine.
        names.filter(|name| *name != "LSLAPICFG").collect()
    }

    #[test]
    fn liblsl_ignores_settings_in_the_working_folder() {
        let home = tempfile::tempdir().unwrap();
        let settings = |named: Option<&str>| {
            let of = |name: &str| match name {
                "HOME" => Some(home.path().as_os_str().to_owned()),
                "LSLAPICFG" => named.map(Into::into),
                _ => None,
            };
            changes(of, None).into_iter().find(|(name, _)| *name == "LSLAPICFG").map(|(_, file)| file)
        };
        // Without LSLAPICFG, the library would look in the working folder first.
        assert!(settings(None).is_some_and(|file| file == "/dev/null" || file == "/etc/lsl_api/lsl_api.cfg"));
        let own = home.path().join("lsl_api/lsl_api.cfg");
        std::fs::create_dir_all(own.parent().unwrap()).unwrap();
        std::fs::write(&own, "").unwrap();
        assert_eq!(settings(None), Some(own.into_os_string()));
        assert_eq!(settings(Some("/lab/lsl_api.cfg")), None, "what a person names stays");
    }

    #[test]
    fn only_locales_with_an_unknown_encoding_are_replaced() {
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
    fn proj_reads_sumos_table_even_if_another_one_was_set() {
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
    fn without_a_session_mesa_does_not_ask_wayland_for_a_card() {
        assert_eq!(changed(&[]), ["NODEVICE_SELECT"]);
        assert_eq!(changed(&[("DRI_PRIME", "1")]), [""; 0]);
    }
}
