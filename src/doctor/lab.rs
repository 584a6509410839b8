//! Checks of LSL: whether liblsl is installed, and the streams that it sees. In: the network. Out: [`Finding`]s.

use super::{Finding, FindingGrade};
use crate::lsl::{self, library};
use std::path::Path;

/// Time to wait for streams, s; streams of a local network reply within half of it.
const WAIT_S: f64 = 1.0;

/// Note on which receivers can see the streams of a drive.
const HEARD: &str = "only this machine receives the streams of a drive, unless interface in [lsl] allows more";

/// Returns a note if the working folder has an LSL configuration that is not read.
fn ignored_config() -> String {
    let whole = |path: &Path| path.canonicalize().ok();
    let named = std::env::var_os(lsl::CONFIG_VARIABLE).and_then(|named| whole(Path::new(&named)));
    match whole(Path::new(lsl::CONFIG)) {
        Some(here) if named.as_ref() != Some(&here) => {
            format!("{} in this folder is not used; to use it, name it in {}; ", lsl::CONFIG, lsl::CONFIG_VARIABLE)
        }
        _ => String::new(),
    }
}

/// Checks LSL. A missing library is not a fault, as only a study with `[lsl]` needs it.
pub(super) fn examine() -> Finding {
    let library = match library::open() {
        Ok(library) => library,
        Err(error) => {
            let found = Finding::from_message("LSL", FindingGrade::Ok, &error.to_string());
            let only = "needed only for a study with [lsl]";
            let remedy = found.remedy.map_or(only.into(), |remedy| format!("{only}: {remedy}"));
            return Finding { remedy: Some(remedy), ..found };
        }
    };
    match lsl::resolve_all(WAIT_S) {
        Ok(streams) => {
            let words: Vec<String> = streams.iter().map(|stream| format!("\n{}", stream)).collect();
            let seen =
                if words.is_empty() { "no stream found".into() } else { format!("streams found:{}", words.concat()) };
            Finding::ok("LSL", format!("{}; {HEARD}; {}{seen}", library, ignored_config()))
        }
        Err(error) => Finding::warning("LSL", error.to_string(), "check the network settings for LSL (lsl_api.cfg)"),
    }
}
