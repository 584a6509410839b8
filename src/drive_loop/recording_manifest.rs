//! Manifest of a recording. In: the world, the driver, the graphics device. Out: a [`Manifest`].

use crate::{
    hud::Speedometer,
    policy,
    record::{
        Manifest, RecordError, Recorder, inputs,
        manifest::{DialScale, NamedHash, RecordingFormat, RecordingState},
    },
    sim::World,
};
use std::{path::Path, time::SystemTime};

/// Returns the manifest of a drive that starts now.
pub fn manifest(world: &World, driver: String, graphics: Option<String>) -> Manifest {
    let scenario = world.scenario();
    let policy = &world.policy().name;
    Manifest {
        format: RecordingFormat::default(),
        program: concat!("codrive ", env!("CARGO_PKG_VERSION")).into(),
        build: if cfg!(debug_assertions) { "dev" } else { "release" }.into(),
        traffic: world.traffic_engine(),
        seed: scenario.seed,
        map: NamedHash::of_text(inputs::last(&world.map().name), world.map().network.sumo_text().as_str()),
        policy: NamedHash::of(inputs::last(policy), policy::file_of(policy).as_deref()),
        policy_asked: world.policy().why.clone(),
        lateral_accel_mps2: scenario.lateral_accel_bound_mps2(&world.map().route),
        hand_over: world.hand_over(),
        network_tables: world.drive().is_open(),
        advised_table: world.has_other_agents(),
        driver,
        participant: None,
        began: now(),
        machine: machine(),
        graphics,
        display_m: [scenario.display.screen_width_m, scenario.display.eye_distance_m],
        screen: None,
        dial: DialScale { full: Speedometer::scale(world).full, unit: scenario.display.units.label().into() },
        state: RecordingState::Running,
        ended: None,
        hash: None,
        checksums: None,
        sha256: None,
    }
}

/// Starts the recording of this world's drive, with copies of its input files.
///
/// # Errors
/// The folder holds a recording already, or cannot be written.
pub fn begin(folder: &Path, world: &World, manifest: Manifest) -> Result<Recorder, RecordError> {
    let mut recorder = Recorder::begin(folder, &inputs::portable(world), manifest)?;
    recorder.start(world);
    inputs::carry(folder, world)?;
    Ok(recorder)
}

/// Returns the present time, UTC.
#[allow(clippy::disallowed_methods, reason = "when a drive was made is a fact of the wall clock")]
pub fn now() -> String {
    utc(SystemTime::now())
}

/// Formats a time by ISO 8601. A clock beyond the year 9999, the limit of the format, gives the last possible time.
fn utc(time: SystemTime) -> String {
    let stamp = jiff::Timestamp::try_from(time).unwrap_or_else(|error| {
        log::warn!("the computer's clock is wrong: {error}\n  remedy: set the clock; recordings need the right date");
        if time < SystemTime::UNIX_EPOCH { jiff::Timestamp::MIN } else { jiff::Timestamp::MAX }
    });
    stamp.strftime("%Y-%m-%dT%H:%M:%SZ").to_string()
}

/// Returns operating system and processor.
fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let model = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    format!("{} {}, {}, {cores} cores", std::env::consts::OS, std::env::consts::ARCH, model.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{DisplaySettings, Scenario};
    use crate::traffic::EngineChoice;
    use std::time::Duration;

    #[test]
    fn a_clock_beyond_the_year_9999_gives_the_last_time() {
        let at = |s| utc(SystemTime::UNIX_EPOCH + Duration::from_secs(s));
        assert_eq!(at(0), "1970-01-01T00:00:00Z");
        assert_eq!(at(1_795_000_000), "2026-11-18T11:06:40Z");
        // Times in the year 11540, and far beyond any calendar.
        for s in [302_000_000_000, i64::MAX as u64] {
            assert!(at(s).starts_with("9999-12-30T"), "{}", at(s));
        }
    }

    #[test]
    fn a_manifest_names_map_policy_driver_and_computer() {
        let scenario = Scenario {
            traffic: EngineChoice::Native,
            policy: "constant".into(),
            seed: 42,
            display: DisplaySettings { screen_width_m: 1.25, eye_distance_m: 0.75, ..Default::default() },
            ..Default::default()
        };
        let world = World::new(&scenario).unwrap();
        let manifest = manifest(&world, "keyboard".into(), None);
        assert_eq!(manifest.program, format!("codrive {}", env!("CARGO_PKG_VERSION")));
        assert_eq!(
            (manifest.traffic.as_str(), manifest.seed, manifest.driver.as_str()),
            ("native IDM", 42, "keyboard")
        );
        assert_eq!((manifest.map.name.as_str(), manifest.policy.name.as_str()), ("ring-250", "constant"));
        // An independent checksum of the same file; a built-in policy has no file.
        let sum = std::process::Command::new("sha256sum").arg(&world.map().net_file).output().unwrap();
        assert_eq!(manifest.map.sha256.as_deref(), String::from_utf8_lossy(&sum.stdout).split_whitespace().next());
        assert!(!manifest.is_complete() && manifest.ended.is_none() && manifest.participant.is_none());
        assert_eq!((manifest.policy.sha256, manifest.graphics, manifest.display_m), (None, None, [1.25, 0.75]));
        let cores = std::thread::available_parallelism().unwrap();
        let [system, processor] = [std::env::consts::OS, std::env::consts::ARCH];
        assert!(manifest.machine.starts_with(&format!("{system} {processor}, ")), "{}", manifest.machine);
        assert!(manifest.machine.ends_with(&format!(", {cores} cores")), "{}", manifest.machine);
        // By ISO 8601: the text sorts like time, and ends in Z.
        let before = utc(SystemTime::UNIX_EPOCH + Duration::from_secs(1_700_000_000));
        assert!(
            manifest.began > before && manifest.began.len() == before.len() && manifest.began.ends_with('Z'),
            "{}",
            manifest.began
        );
    }
}
