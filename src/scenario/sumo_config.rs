//! SUMO's configuration of a scenario (`.sumocfg`) as a [`Scenario`]. In: the file. Out: road, demand, additional files, begin, duration and
//! seed; and one warning that names the options that have no effect here. Other settings keep their default.

use super::Scenario;
use crate::{
    file::{SETTINGS_BYTES, read_text},
    settings::{Settings, SettingsError},
    traffic::time_of_day_s,
};
use quick_xml::{Reader, XmlVersion, events::Event};
use std::path::{Path, PathBuf};

/// Largest duration of a drive, s.
const LONGEST_S: f64 = 604_800.0;
/// Parts of the names of options that only write, draw or speak, and such names.
const SILENT_PARTS: [&str; 5] = ["output", "duration-log", "gui", "validation", "tls.actuated.show"];
const SILENT: &str = "log message-log error-log log.processed verbose no-warnings no-step-log human-readable-time print-options precision \
                      write-license start quit-on-end delay remote-port num-clients";

/// Returns true for a file that is read as SUMO's configuration, by the end of its name.
pub(super) fn is_sumo_config(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("sumocfg"))
}

/// Reads a configuration; paths in it are relative to its folder.
///
/// # Errors
/// The file cannot be read, is no XML, names no network, or an option has a value that is not allowed.
pub(super) fn read(path: &Path) -> Result<Scenario, SettingsError> {
    let named = |message: String| SettingsError { key: String::new(), message: format!("{}{message}", path.display()) };
    let text = read_text(path, SETTINGS_BYTES).map_err(|error| named(format!(": cannot be read: {error}")))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let files = |value: &str| -> Vec<PathBuf> {
        let names = value.split(',').map(str::trim).filter(|name| !name.is_empty());
        names.map(|name| folder.join(name)).collect()
    };
    let (mut scenario, mut end_s, mut unused) = (Scenario::default(), None, Vec::new());
    scenario.map.clear();
    // SUMO drives the scenario without them, too.
    scenario.demand.leave_out_faults = true;
    for ConfigOption { line, name, value } in
        options(&text).map_err(|(line, fault)| named(format!(":{line}: {fault}")))?
    {
        let time = || {
            let allowed = "allowed: seconds from 0, or h:mm:ss";
            time_of_day_s(&value).ok_or_else(|| named(format!(":{line}: {name} is \"{value}\"; {allowed}")))
        };
        match name.as_str() {
            "net-file" | "net" | "n" => scenario.map = folder.join(value.trim()).to_string_lossy().into_owned(),
            "route-files" | "routes" | "r" => scenario.demand.files = files(&value),
            "additional-files" | "additional" | "a" => scenario.demand.additional_files = files(&value),
            "begin" | "b" => scenario.demand.begin_s = time()?,
            // A negative end stands for none.
            "end" | "e" => end_s = if value.trim().starts_with('-') { None } else { Some(time()?) },
            "ignore-route-errors" => {}
            "seed" => {
                let seed = value.trim().parse();
                let wrong = |_| named(format!(":{line}: seed is \"{value}\"; allowed: a whole number from 0"));
                scenario.seed = seed.map_err(wrong)?;
            }
            _ if SILENT.split_whitespace().any(|silent| name == silent) => {}
            _ if SILENT_PARTS.iter().any(|part| name.contains(part)) => {}
            _ => unused.push(name),
        }
    }
    if scenario.map.is_empty() {
        return Err(named(": net-file is missing; allowed: the path of a net.xml, relative to this file".into()));
    }
    scenario.duration_s = end_s.map_or(LONGEST_S, |end_s| (end_s - scenario.demand.begin_s).clamp(0.0, LONGEST_S));
    scenario.check().map_err(|(_, fault)| named(format!(": {fault}")))?;
    if !unused.is_empty() {
        log::warn!("{}: without effect in codrive: {}", path.display(), unused.join(", "));
    }
    Ok(scenario)
}

/// Option of a configuration.
struct ConfigOption {
    line: usize,
    name: String,
    value: String,
}

/// Returns all options in their order; or the line and the text of the first fault.
fn options(text: &str) -> Result<Vec<ConfigOption>, (usize, String)> {
    let (mut reader, mut options) = (Reader::from_str(text), Vec::new());
    loop {
        let line = 1 + text[..reader.buffer_position() as usize].matches('\n').count();
        let fault = |error: &dyn ToString| (line, format!("this is not XML: {}", error.to_string()));
        let tag = match reader.read_event().map_err(|error| fault(&error))? {
            Event::Start(tag) | Event::Empty(tag) => tag,
            Event::DocType(_) => return Err((line, "a document type; codrive reads none".into())),
            Event::Eof => return Ok(options),
            _ => continue,
        };
        let name = String::from_utf8_lossy(tag.name().into_inner()).into_owned();
        for attribute in tag.attributes() {
            let attribute = attribute.map_err(|error| fault(&error))?;
            if matches!(attribute.key.into_inner(), b"value" | b"v") {
                let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|error| fault(&error))?;
                options.push(ConfigOption { line, name: name.clone(), value: value.into_owned() });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text_of(text: &str) -> Result<Scenario, String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("run.sumocfg");
        std::fs::write(&file, text).unwrap();
        let inside = |path: &Path| path.strip_prefix(folder.path()).unwrap().to_owned();
        let mut scenario = Scenario::from_file(&file)
            .map_err(|error| error.message.replace(&format!("{}/", folder.path().display()), ""))?;
        scenario.map = inside(Path::new(&scenario.map)).to_string_lossy().into_owned();
        scenario.demand.input_files_mut().for_each(|file| *file = inside(file));
        Ok(scenario)
    }

    #[test]
    fn a_configuration_becomes_road_demand_begin_and_duration() {
        let text = "<?xml version=\"1.0\"?><configuration><input><net-file value=\"town.net.xml\"/>\n\
                    <route-files value=\"bus.rou.xml, cars.rou.xml.gz\"/><additional-files v=\"stops.add.xml\"/></input>\
                    <time><begin value=\"7:00:00\"/><end value=\"28800\"/></time><time-to-teleport value=\"300\"/></configuration>";
        let scenario = read_text_of(text).unwrap();
        assert_eq!(scenario.map, "town.net.xml");
        assert_eq!(scenario.demand.files, [Path::new("bus.rou.xml"), Path::new("cars.rou.xml.gz")]);
        assert_eq!(scenario.demand.additional_files, [Path::new("stops.add.xml")]);
        assert_eq!((scenario.demand.begin_s, scenario.duration_s), (25_200.0, 3_600.0));
    }

    #[test]
    fn a_fault_of_a_configuration_has_file_line_value_and_remedy() {
        for (text, expected) in [
            (
                "<configuration>\n<begin value=\"soon\"/></configuration>",
                "run.sumocfg:2: begin is \"soon\"; allowed: seconds",
            ),
            (
                "<configuration><seed value=\"x\"/></configuration>",
                "run.sumocfg:1: seed is \"x\"; allowed: a whole number",
            ),
            ("<configuration/>", "run.sumocfg: net-file is missing; allowed: the path"),
            ("<configuration>\n\n<net-file value=\"a\"></configuration>", "run.sumocfg:3: this is not XML"),
            ("<!DOCTYPE x><configuration/>", "run.sumocfg:1: a document type"),
        ] {
            let error = read_text_of(text).expect_err(text);
            assert!(error.starts_with(expected), "{expected:?} is not the begin of {error}");
        }
    }
}
