//! What the libraries below read from the environment, put right before one of them does. In: variables. Out: changed ones.

use std::{env, ffi::OsString};

/// A locale that C libraries know everywhere; the program itself speaks one language and UTF-8.
const LOCALE: &str = "C.UTF-8";

/// Changes the variables at which a library below would end the program or complain.
///
/// # Safety
/// No other thread runs yet: the environment is not guarded against reading while it changes.
pub unsafe fn prepare() {
    for (name, value) in changes(|name| env::var_os(name).filter(|value| !value.is_empty())) {
        // SAFETY: the caller promises that this thread is alone.
        unsafe { env::set_var(name, value) };
    }
}

fn changes(of: impl Fn(&str) -> Option<OsString>) -> Vec<(&'static str, &'static str)> {
    let mut changes = Vec::new();
    // Xerces in SUMO takes what follows the dot as the name of an encoding, and ends the process (exit 255) where there is
    // none of that name, as in C.UTF-8@x.
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(&of);
    let encoding = locale.and_then(|name| Some(name.to_string_lossy().split_once('.')?.1.to_ascii_lowercase()));
    if encoding.is_some_and(|encoding| !["utf-8", "utf8"].contains(&encoding.as_str())) {
        changes.push(("LC_ALL", LOCALE));
    }
    // Mesa's layer that moves the desktop's graphics card to the front asks Wayland for it, which complains on the standard
    // error when this is missing, once for each look. The card is chosen by its power in any case.
    let asked = ["MESA_VK_DEVICE_SELECT", "DRI_PRIME"].into_iter().any(|name| of(name).is_some());
    if of("XDG_RUNTIME_DIR").is_none() && !asked {
        changes.push(("NODEVICE_SELECT", "1"));
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(there: &[(&str, &str)]) -> Vec<&'static str> {
        let of = |name: &str| there.iter().find(|(n, _)| *n == name).map(|(_, value)| value.into());
        changes(of).into_iter().map(|(name, _)| name).collect()
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
    fn without_a_session_no_graphics_card_is_asked_for_by_wayland() {
        assert_eq!(changed(&[]), ["NODEVICE_SELECT"]);
        assert_eq!(changed(&[("DRI_PRIME", "1")]), [""; 0]);
    }
}
