//! Checks of data, sound, disk, clock and power. In: system files. Out: [`Finding`]s. Facts that another system keeps elsewhere are
//! reported as unknown.

use super::Finding;
use crate::{audio, data_folders, input::TimeStamp, record};
use std::{
    fs::{self, File},
    io::Write,
    path::Path,
};

/// Number of bytes written to measure the disk.
const TRIAL_BYTES: usize = 16 << 20;
/// Write speed below which a warning is given, MB/s. A recording needs less than 0.2 MB/s, so a slower disk has another problem.
const SLOW_MBPS: f64 = 10.0;

pub(super) fn examine(recordings: &Path) -> Vec<Finding> {
    vec![data(), disk_space(free_gb(recordings)), clock(), power()]
}

/// Checks the folder of maps and assets.
fn data() -> Finding {
    let root = data_folders::root();
    if root.join("maps").is_dir() {
        return Finding::ok("data", root.display().to_string());
    }
    Finding::fault("data", format!("no data in {}", root.display()), "name the folder with maps and assets: --data DIR")
}

/// Checks sound by opening the output, as a drive does.
pub(super) fn sound() -> Finding {
    match audio::output() {
        Ok(output) => Finding::ok("sound", output),
        Err(why) => Finding::warning(
            "sound",
            format!("none: {why}"),
            "connect a card or start its server, or drive without sound",
        ),
    }
}

/// Checks the program that speaks guidance and digits.
pub(super) fn speech() -> Finding {
    match audio::speech_program() {
        Ok(program) => Finding::ok("speech", program),
        Err(why) => Finding::warning("speech", format!("none: {why}"), "install it, or drive without speech"),
    }
}

/// Measures the speed of a synced write to the disk.
pub(super) fn disk_speed(folder: &Path) -> Finding {
    let path = folder.join(".codrive-doctor");
    let trial = || -> std::io::Result<f64> {
        let bytes: Vec<u8> =
            (0..TRIAL_BYTES).map(|i| (i as u32).wrapping_mul(2_654_435_761).to_le_bytes()[3]).collect();
        let mut file = File::create(&path)?;
        let begin = TimeStamp::now();
        file.write_all(&bytes)?;
        file.sync_data()?;
        Ok(TRIAL_BYTES as f64 / 1e6 / begin.until(TimeStamp::now()).as_secs_f64().max(1e-6))
    };
    let speed = trial();
    let _ = fs::remove_file(&path);
    match speed {
        Ok(mbps) if mbps >= SLOW_MBPS => Finding::ok("disk speed", format!("{mbps:.0} MB/s, written through")),
        Ok(mbps) => Finding::warning(
            "disk speed",
            format!("{mbps:.1} MB/s, written through"),
            "record on another disk: --out DIR",
        ),
        Err(error) => {
            let found = format!("{} cannot be written to: {error}", folder.display());
            Finding::fault("disk speed", found, "name a writable folder: --out DIR")
        }
    }
}

fn free_gb(folder: &Path) -> Option<f64> {
    record::free_bytes(folder).map(|bytes| bytes as f64 / 1e9)
}

fn disk_space(free_gb: Option<f64>) -> Finding {
    let remedy = "make room, or record on another disk: --out DIR";
    match free_gb {
        None => Finding::warning("disk space", "unknown", "make sure that 5 GB are free"),
        Some(gb) if gb < record::TOO_LITTLE_GB => Finding::fault("disk space", format!("{gb:.1} GB free"), remedy),
        Some(gb) if gb < record::LITTLE_GB => Finding::warning("disk space", format!("{gb:.1} GB free"), remedy),
        Some(gb) => Finding::ok("disk space", format!("{gb:.0} GB free")),
    }
}

fn clock() -> Finding {
    let source = fs::read_to_string("/sys/devices/system/clocksource/clocksource0/current_clocksource").ok();
    // Smallest step of the clock that stamps inputs and frames.
    let step = (0..1000)
        .filter_map(|_| {
            let begin = TimeStamp::now();
            let step = begin.until(TimeStamp::now());
            (!step.is_zero()).then_some(step)
        })
        .min();
    judge_clock(source.as_deref().map(str::trim), step.map(|step| step.as_secs_f64()))
}

/// Grades the clock by the kernel's clock source and the smallest step seen, s.
fn judge_clock(source: Option<&str>, step_s: Option<f64>) -> Finding {
    let name = source.unwrap_or("unknown source");
    let Some(step_s) = step_s else {
        return Finding::fault("clock", format!("{name}: it does not advance"), "restart the computer");
    };
    let found = format!("{name}, steps of {:.0} ns", step_s * 1e9);
    match name {
        _ if step_s > 1e-3 => Finding::fault("clock", found, "steps above 1 ms hide latencies: use another computer"),
        "hpet" | "acpi_pm" | "jiffies" => {
            let remedy =
                "slow to read: the kernel does not use the processor's own clock (tsc); see dmesg, update the BIOS";
            Finding::warning("clock", found, remedy)
        }
        _ => Finding::ok("clock", found),
    }
}

fn power() -> Finding {
    let entries = fs::read_dir("/sys/devices/system/cpu").into_iter().flatten().flatten();
    let mut governors: Vec<String> = entries
        .filter_map(|entry| fs::read_to_string(entry.path().join("cpufreq/scaling_governor")).ok())
        .map(|text| text.trim().to_owned())
        .collect();
    governors.sort();
    governors.dedup();
    let supplies = fs::read_dir("/sys/class/power_supply").into_iter().flatten().flatten();
    let discharging = supplies
        .filter_map(|entry| fs::read_to_string(entry.path().join("status")).ok())
        .any(|status| status.trim() == "Discharging");
    judge_power(&governors, discharging)
}

fn judge_power(governors: &[String], discharging: bool) -> Finding {
    if discharging {
        return Finding::warning("power", "on battery; processor and graphics are slower", "connect the power supply");
    }
    match governors {
        [] => Finding::ok("power", "the system has no governor for the processor's speed"),
        [one] if one == "performance" => Finding::ok("power", "governor performance"),
        all => {
            let remedy =
                "for a study: sudo cpupower frequency-set -g performance (or powerprofilesctl set performance)";
            Finding::warning("power", format!("governor {}: frames may come late", all.join(", ")), remedy)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{super::FindingGrade, *};

    #[test]
    fn a_saving_governor_or_a_battery_is_a_warning_with_its_remedy() {
        let of = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
        assert_eq!(judge_power(&of(&["performance"]), false).grade, FindingGrade::Ok);
        let saving = judge_power(&of(&["performance", "powersave"]), false);
        assert!(saving.grade == FindingGrade::Warning && saving.remedy.unwrap().contains("cpupower"));
        assert_eq!(judge_power(&of(&["performance"]), true).grade, FindingGrade::Warning);
    }

    #[test]
    fn a_coarse_clock_is_a_fault_and_a_full_disk_too() {
        assert_eq!(judge_clock(Some("tsc"), Some(4e-8)).grade, FindingGrade::Ok);
        assert_eq!(judge_clock(Some("hpet"), Some(1e-6)).grade, FindingGrade::Warning);
        assert_eq!(judge_clock(Some("tsc"), Some(4e-3)).grade, FindingGrade::Fault);
        assert_eq!(judge_clock(None, None).grade, FindingGrade::Fault);
        let grades = [Some(100.0), Some(3.0), Some(0.5), None].map(|gb| disk_space(gb).grade);
        assert_eq!(grades, [FindingGrade::Ok, FindingGrade::Warning, FindingGrade::Fault, FindingGrade::Warning]);
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_a_fault_and_nothing_is_left_behind() {
        let folder = tempfile::tempdir().unwrap();
        assert_ne!(disk_speed(folder.path()).grade, FindingGrade::Fault);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        assert_eq!(disk_speed(&folder.path().join("absent")).grade, FindingGrade::Fault);
    }
}
