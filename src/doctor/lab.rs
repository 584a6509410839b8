//! Checks of other devices: is liblsl here, and which streams does it see? In: the network. Out: [`Finding`]s.

use super::{Finding, FindingGrade};
use crate::lsl::{self, FoundStream, library};

/// So long streams are waited for, seconds: those of a local network answer within half of it.
const WAIT_S: f64 = 1.0;

/// Without the library nothing is wrong: only a study with `[lsl]` needs it.
pub(super) fn examine() -> Finding {
    let library = match library::open() {
        Ok(library) => library,
        Err(error) => {
            let found = Finding::told("LSL", FindingGrade::Ok, &error.to_string());
            let only = "only for a study with [lsl]";
            let remedy = found.remedy.map_or(only.into(), |remedy| format!("{only}: {remedy}"));
            return Finding { remedy: Some(remedy), ..found };
        }
    };
    match lsl::resolve_all(WAIT_S) {
        Ok(streams) if streams.is_empty() => Finding::ok("LSL", format!("{}; no stream is seen", library.describe())),
        Ok(streams) => {
            let words: Vec<String> = streams.iter().map(FoundStream::words).collect();
            Finding::ok("LSL", format!("{}; streams that are seen:\n{}", library.describe(), words.join("\n")))
        }
        Err(error) => {
            Finding::warning("LSL", error.to_string(), "look at the network's settings for LSL (lsl_api.cfg)")
        }
    }
}
