//! Findings about a rig. In: what a check found, and the monitors that the window library lists. Out: [`Finding`]s with their grade and
//! remedy.

use serde::Serialize;

/// Reason why the monitors are unknown; the type of the error depends on the caller.
pub type MonitorsUnknown = Box<dyn std::error::Error + Send + Sync>;

/// Monitor as reported by the system.
#[derive(Clone, Debug, PartialEq)]
pub struct MonitorInfo {
    /// Number for `--monitor`, from 1.
    pub number: usize,
    /// Name reported by the system.
    pub name: String,
    /// Width and height, px.
    pub size: [u32; 2],
    /// Refresh rate, Hz, if known.
    pub refresh_hz: Option<f64>,
    /// Refresh rates available at this size, Hz, if known.
    pub rates_hz: Vec<f64>,
    /// True for the monitor on which windows open by default.
    pub primary: bool,
}

impl std::fmt::Display for MonitorInfo {
    /// Describes the monitor in one line.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let rate = self.refresh_hz.map_or("rate unknown".into(), |hz| format!("{hz:.2} Hz"));
        let primary = if self.primary { ", primary" } else { "" };
        let others: Vec<String> = self.rates_hz.iter().map(|hz| format!("{hz:.2}")).collect();
        let others = if others.len() > 1 { format!(" (can do {} Hz)", others.join(", ")) } else { String::new() };
        write!(f, "{}: {}, {}x{}, {rate}{others}{primary}", self.number, self.name, self.size[0], self.size[1])
    }
}

/// Grade of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FindingGrade {
    /// Good enough for a study.
    Ok,
    /// A study can be run, with care.
    Warning,
    /// A study must not be run.
    Fault,
}

/// One finding of the checks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Subject of the check.
    pub what: &'static str,
    /// Grade of the finding.
    pub grade: FindingGrade,
    /// Description of the finding.
    pub found: String,
    /// Advice to the user; `None` if all is well.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
}

impl Finding {
    pub(super) fn ok(what: &'static str, found: impl Into<String>) -> Self {
        Self { what, grade: FindingGrade::Ok, found: found.into(), remedy: None }
    }

    pub(super) fn warning(what: &'static str, found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { what, grade: FindingGrade::Warning, found: found.into(), remedy: Some(remedy.into()) }
    }

    pub(super) fn fault(what: &'static str, found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { what, grade: FindingGrade::Fault, found: found.into(), remedy: Some(remedy.into()) }
    }

    /// Creates a finding from a message of the form `found\n  remedy: ...`.
    pub(super) fn from_message(what: &'static str, grade: FindingGrade, message: &str) -> Self {
        let (found, remedy) = message.split_once("\n  remedy: ").unwrap_or((message, ""));
        let remedy = (!remedy.is_empty()).then(|| remedy.to_owned());
        Self { what, grade, found: found.to_owned(), remedy }
    }
}
