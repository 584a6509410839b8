//! Checks whether this rig is fit for a study. In: the machine. Out: [`Finding`]s, each ok, a warning or a fault with its
//! remedy. What cannot be found out is said, never assumed.

mod lab;
mod machine;
mod picture;
mod wheel;

use crate::scenario::Scenario;
use serde::Serialize;
use serde_json::{Value, json};
use std::{
    path::PathBuf,
    sync::mpsc::{self, RecvTimeoutError},
    thread,
    time::Duration,
};

/// What is checked.
pub struct DoctorOptions {
    /// The drive that is to be driven.
    pub scenario: Scenario,
    /// Size of its picture, pixels.
    pub size: [u32; 2],
    /// Folder of the recordings.
    pub recordings: PathBuf,
    /// The monitors, or why there are none: only a program with a window can ask.
    pub monitors: Result<Vec<MonitorInfo>, MonitorsUnknown>,
}

/// Why nobody knows the monitors; whoever asks the system has errors of its own.
pub type MonitorsUnknown = Box<dyn std::error::Error + Send + Sync>;

/// A monitor as the system tells of it.
#[derive(Clone, Debug, PartialEq)]
pub struct MonitorInfo {
    /// Its number for `--monitor`, from 1.
    pub number: usize,
    /// Its name.
    pub name: String,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Refresh rate, Hz, where the system tells.
    pub refresh_hz: Option<f64>,
    /// Rates that it has at this size, Hz, where the system tells.
    pub rates_hz: Vec<f64>,
    /// True for the one that windows open on by themselves.
    pub primary: bool,
}

impl MonitorInfo {
    /// In words.
    pub fn words(&self) -> String {
        let rate = self.refresh_hz.map_or("rate unknown".into(), |hz| format!("{hz:.2} Hz"));
        let primary = if self.primary { ", primary" } else { "" };
        let others: Vec<String> = self.rates_hz.iter().map(|hz| format!("{hz:.2}")).collect();
        let others = if others.len() > 1 { format!(" (can do {} Hz)", others.join(", ")) } else { String::new() };
        format!("{}: {}, {}x{}, {rate}{others}{primary}", self.number, self.name, self.size[0], self.size[1])
    }
}

/// How good something is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FindingGrade {
    /// Fit.
    Ok,
    /// A study can be driven, with care.
    Warning,
    /// A study must not be driven.
    Fault,
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// What was looked at.
    pub what: &'static str,
    /// How good it is.
    pub grade: FindingGrade,
    /// What was found.
    pub found: String,
    /// What to do about it; nothing where all is well.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
}

impl Finding {
    fn ok(what: &'static str, found: impl Into<String>) -> Self {
        Self { what, grade: FindingGrade::Ok, found: found.into(), remedy: None }
    }

    fn warning(what: &'static str, found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { what, grade: FindingGrade::Warning, found: found.into(), remedy: Some(remedy.into()) }
    }

    fn fault(what: &'static str, found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { what, grade: FindingGrade::Fault, found: found.into(), remedy: Some(remedy.into()) }
    }

    /// A message of the form `found\n  remedy: ...` as a line.
    fn told(what: &'static str, grade: FindingGrade, message: &str) -> Self {
        let (found, remedy) = message.split_once("\n  remedy: ").unwrap_or((message, ""));
        let remedy = (!remedy.is_empty()).then(|| remedy.to_owned());
        Self { what, grade, found: found.to_owned(), remedy }
    }
}

/// Looks at everything; some seconds, and never longer than [`ANSWER`] for each check that asks a device or a library.
pub fn examine(options: &DoctorOptions) -> Vec<Finding> {
    let (scenario, size, recordings) = (options.scenario.clone(), options.size, options.recordings.clone());
    let picture = move || picture::examine(&scenario, size);
    let scenario = options.scenario.clone();
    let mut lines = within(ANSWER, "graphics", picture);
    lines.extend(within(ANSWER, "SUMO", move || vec![picture::sumo(&scenario)]));
    lines.extend(within(ANSWER, "wheel", wheel::examine));
    lines.push(picture::display(&options.scenario));
    lines.extend(picture::monitors(&options.monitors));
    lines.extend(within(ANSWER, "sound", || vec![machine::sound()]));
    lines.extend(within(ANSWER, "disk speed", move || vec![machine::disk_speed(&recordings)]));
    lines.extend(machine::examine(&options.recordings));
    lines.extend(within(ANSWER, "LSL", || vec![lab::examine()]));
    lines
}

/// The longest time that a check may take.
pub const ANSWER: Duration = Duration::from_secs(20);

/// Findings of a check, on a thread of its own; a fault where it does not answer in time. Such a thread is left behind: neither a driver
/// nor a library can be broken off.
fn within(limit: Duration, what: &'static str, check: impl FnOnce() -> Vec<Finding> + Send + 'static) -> Vec<Finding> {
    let (say, found) = mpsc::channel();
    // Whoever waited may have given up.
    let begun = thread::Builder::new().name(format!("doctor: {what}")).spawn(move || drop(say.send(check())));
    let unknown = |found: String, remedy: &str| vec![Finding::fault(what, found, remedy)];
    if let Err(why) = begun {
        return unknown(format!("not looked at: {why}"), "close other programs");
    }
    match found.recv_timeout(limit) {
        Ok(lines) => lines,
        Err(RecvTimeoutError::Timeout) => {
            let remedy = "look at what else the computer does, and start codrive doctor again when it is idle";
            unknown(format!("not answered within {} s", limit.as_secs_f64()), remedy)
        }
        Err(RecvTimeoutError::Disconnected) => unknown("the check broke off".into(), "RUST_LOG=info says more"),
    }
}

/// The page.
pub fn words(lines: &[Finding]) -> String {
    let mut page = String::new();
    for line in lines {
        let grade = match line.grade {
            FindingGrade::Ok => "ok     ",
            FindingGrade::Warning => "WARNING",
            FindingGrade::Fault => "FAULT  ",
        };
        page += &format!("{grade}  {:<12} {}\n", line.what, line.found.replace('\n', "\n                      "));
        if let Some(remedy) = &line.remedy {
            page += &format!("                      remedy: {}\n", remedy.replace('\n', "\n                      "));
        }
    }
    page
}

/// The same for a manifest.
pub fn json(lines: &[Finding]) -> Value {
    let worst = lines.iter().map(|line| line.grade).max().unwrap_or(FindingGrade::Ok);
    json!({ "program": concat!("codrive ", env!("CARGO_PKG_VERSION")), "grade": worst, "checks": lines })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_check_that_does_not_answer_is_a_fault_with_the_time_it_had() {
        let (held, hold) = mpsc::channel::<()>();
        let limit = Duration::from_millis(50);
        let lines = within(limit, "sound", move || {
            let _ = hold.recv();
            vec![Finding::ok("sound", "late")]
        });
        drop(held);
        assert_eq!((lines.len(), lines[0].what, lines[0].grade), (1, "sound", FindingGrade::Fault));
        assert!(lines[0].found == "not answered within 0.05 s" && lines[0].remedy.is_some(), "{lines:?}");
        let lines = within(Duration::from_secs(60), "sound", || vec![Finding::ok("sound", "there")]);
        assert_eq!(lines, [Finding::ok("sound", "there")]);
        let lines = within(Duration::from_secs(60), "sound", || panic!("a driver's mistake"));
        assert!(lines[0].found.contains("broke off"), "{lines:?}");
    }

    #[test]
    fn a_page_has_a_line_and_a_remedy_for_each_finding_and_json_says_the_worst() {
        let lines = [
            Finding::ok("disk", "fast"),
            Finding::told("wheel", FindingGrade::Fault, "at PS4\n  remedy: move it\n    to PS3"),
        ];
        let page = words(&lines);
        assert!(page.starts_with("ok       disk         fast\nFAULT    wheel        at PS4\n"), "{page}");
        assert!(page.contains("remedy: move it\n"), "{page}");
        let json = json(&lines);
        assert_eq!((json["grade"].as_str(), json["checks"][0].get("remedy")), (Some("fault"), None));
    }
}
