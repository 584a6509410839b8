//! Checks of LSL: whether liblsl is installed, and the streams that it sees. In: the network. Out: [`Finding`]s.

use super::{Finding, FindingGrade};
use crate::lsl::{self, library};
use std::path::Path;

/// Time to wait for streams, s; streams of a local network reply within half of it.
const WAIT_S: f64 = 1.0;

/// Note on which receivers can see the streams of a drive.
const HEARD: &str = "a drive's own streams are heard on this machine alone, or where interface in [lsl] says";

/// Returns a note if the working folder has an LSL configuration that is not read.
fn ignored_config() -> String {
    let whole = |path: &Path| path.canonicalize().ok();
    let named = std::env::var_os(lsl::CONFIG_VARIABLE).and_then(|named| whole(Path::new(&named)));
    match whole(Path::new(lsl::CONFIG)) {
        Some(here) if named.as_ref() != Some(&here) => {
            format!("{} of this folder is not read: name it in {}; ", lsl::CONFIG, lsl::CONFIG_VARIABLE)
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
            let only = "only for a study with [lsl]";
            let remedy = found.remedy.map_or(only.into(), |remedy| format!("{only}: {remedy}"));
            return Finding { remedy: Some(remedy), ..found };
        }
    };
    match lsl::resolve_all(WAIT_S) {
        Ok(streams) => {
            let words: Vec<String> = streams.iter().map(|stream| format!("\n{}", stream)).collect();
            let seen = if words.is_empty() {
                "no stream is seen".into()
            } else {
                format!("streams that are seen:{}", words.concat())
            };
            Finding::ok("LSL", format!("{}; {HEARD}; {}{seen}", library, ignored_config()))
        }
        Err(error) => {
            Finding::warning("LSL", error.to_string(), "look at the network's settings for LSL (lsl_api.cfg)")
        }
    }
}
