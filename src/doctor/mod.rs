//! Checks whether a rig is fit for a study. In: the machine. Out: [`Finding`]s, each ok, a warning or a fault with its remedy. Facts that
//! cannot be determined are reported as unknown, never assumed.

mod finding;
mod lab;
mod machine;
mod picture;
mod quality;
mod wheel;

pub use finding::{Finding, FindingGrade, MonitorInfo, MonitorsUnknown};
pub use picture::frames_per_s;

use crate::scenario::Scenario;
use serde_json::{Value, json};
use std::{
    path::PathBuf,
    sync::mpsc::{self, RecvTimeoutError},
    thread,
    time::Duration,
};

/// Inputs of the checks.
pub struct DoctorOptions {
    /// Scenario to be driven.
    pub scenario: Scenario,
    /// Size of the picture, px.
    pub size: [u32; 2],
    /// Folder of the recordings.
    pub recordings: PathBuf,
    /// Monitors, or the reason why they are unknown; only a program with a window can list them.
    pub monitors: Result<Vec<MonitorInfo>, MonitorsUnknown>,
}

/// Runs all checks. Takes some seconds; each check that uses a device or a library takes at most [`ANSWER`].
pub fn examine(options: &DoctorOptions) -> Vec<Finding> {
    let (scenario, size, recordings) = (options.scenario.clone(), options.size, options.recordings.clone());
    let screen_hz = picture::screen_hz(&options.monitors);
    let picture = move || picture::examine(&scenario, size, screen_hz);
    let scenario = options.scenario.clone();
    let mut lines = within(ANSWER, "graphics", picture);
    lines.extend(within(ANSWER, "SUMO", move || vec![picture::sumo(&scenario)]));
    lines.extend(within(ANSWER, "wheel", wheel::examine));
    lines.push(picture::display(&options.scenario));
    lines.extend(picture::monitors(&options.monitors));
    lines.extend(within(ANSWER, "sound", || vec![machine::sound()]));
    if options.scenario.speaks() {
        lines.extend(within(ANSWER, "speech", || vec![machine::speech()]));
    }
    lines.extend(within(ANSWER, "disk speed", move || vec![machine::disk_speed(&recordings)]));
    lines.extend(machine::examine(&options.recordings));
    lines.extend(within(ANSWER, "LSL", || vec![lab::examine()]));
    lines
}

/// Maximum duration of a check that uses a device or a library.
pub const ANSWER: Duration = Duration::from_secs(20);

/// Runs a check on its own thread and returns its findings; a fault if it takes longer than `limit`. Such a thread is left running, as
/// neither a driver nor a library can be interrupted.
fn within(limit: Duration, what: &'static str, check: impl FnOnce() -> Vec<Finding> + Send + 'static) -> Vec<Finding> {
    let (sender, found) = mpsc::channel();
    // The receiver may already have given up.
    let begun = thread::Builder::new().name(format!("doctor: {what}")).spawn(move || drop(sender.send(check())));
    let unknown = |found: String, remedy: &str| vec![Finding::fault(what, found, remedy)];
    if let Err(why) = begun {
        return unknown(format!("not checked: {why}"), "close other programs");
    }
    match found.recv_timeout(limit) {
        Ok(lines) => lines,
        Err(RecvTimeoutError::Timeout) => {
            let remedy = "end other programs, and run codrive doctor again on the idle computer";
            unknown(format!("no result within {} s", limit.as_secs_f64()), remedy)
        }
        Err(RecvTimeoutError::Disconnected) => {
            unknown("the check ended early".into(), "run it with RUST_LOG=info for details")
        }
    }
}

/// Formats the findings as text for the terminal.
pub fn text(lines: &[Finding]) -> String {
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

/// Converts the findings to JSON, for a manifest.
pub fn json(lines: &[Finding]) -> Value {
    let worst = lines.iter().map(|line| line.grade).max().unwrap_or(FindingGrade::Ok);
    json!({ "program": concat!("codrive ", env!("CARGO_PKG_VERSION")), "grade": worst, "checks": lines })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_check_that_times_out_is_a_fault_with_its_time_limit() {
        let (held, hold) = mpsc::channel::<()>();
        let limit = Duration::from_millis(50);
        let lines = within(limit, "sound", move || {
            let _ = hold.recv();
            vec![Finding::ok("sound", "late")]
        });
        drop(held);
        assert_eq!((lines.len(), lines[0].what, lines[0].grade), (1, "sound", FindingGrade::Fault));
        assert!(lines[0].found == "no result within 0.05 s" && lines[0].remedy.is_some(), "{lines:?}");
        let lines = within(Duration::from_secs(60), "sound", || vec![Finding::ok("sound", "there")]);
        assert_eq!(lines, [Finding::ok("sound", "there")]);
        let lines = within(Duration::from_secs(60), "sound", || panic!("a driver's mistake"));
        assert!(lines[0].found.contains("ended early"), "{lines:?}");
    }

    #[test]
    fn the_text_has_each_finding_with_remedy_and_json_the_worst_grade() {
        let lines = [
            Finding::ok("disk", "fast"),
            Finding::from_message("wheel", FindingGrade::Fault, "at PS4\n  remedy: move it\n    to PS3"),
        ];
        let page = text(&lines);
        assert!(page.starts_with("ok       disk         fast\nFAULT    wheel        at PS4\n"), "{page}");
        assert!(page.contains("remedy: move it\n"), "{page}");
        let json = json(&lines);
        assert_eq!((json["grade"].as_str(), json["checks"][0].get("remedy")), (Some("fault"), None));
    }
}
