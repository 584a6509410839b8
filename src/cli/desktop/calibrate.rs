//! `codrive calibrate`: measures the axes of a wheel by prompts on the terminal and saves its profile.

use crate::cli::CliError;
#[cfg(target_os = "linux")]
use crate::{
    cli::out,
    input::{kinds::DeviceKind, linux::DeviceNode},
};
use clap::{Arg, ArgMatches, Command, value_parser};
use std::path::PathBuf;

pub(super) fn command() -> Command {
    Command::new("calibrate")
        .about("Calibrate a steering wheel and save a profile; a text asks for each turn and pedal")
        .arg(Arg::new("name").long("name").value_name("NAME").help("Name of the profile [default: the device's]"))
        .arg(
            Arg::new("device").long("device").value_name("VENDOR:PRODUCT").help(
                "USB id of the device, for one that is not known as a wheel [default: the wheel that is plugged in]",
            ),
        )
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("FILE.toml")
                .value_parser(value_parser!(PathBuf))
                .help("File of the profile, instead of a place among your own profiles"),
        )
        .arg(
            Arg::new("replay")
                .long("replay")
                .value_name("FILE")
                .value_parser(value_parser!(PathBuf))
                .help("Recording of a wheel's input by evemu-record, with its times, instead of a wheel"),
        )
}

#[cfg(not(target_os = "linux"))]
pub(super) fn main(_matches: &ArgMatches) -> Result<(), CliError> {
    let text = "wheels are calibrated on Linux only\n  remedy: on this system the wheel's own driver sets its range";
    Err(CliError::Failed(text.into()))
}

#[cfg(target_os = "linux")]
pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    use crate::input::{
        TimeStamp,
        calibrate::{Calibration, CalibrationStep},
        linux::{self, OpenWheel},
        parts, profiles,
        wheel::WheelMessage,
    };
    use std::time::Duration;

    let nodes = linux::controllers(None);
    let node = chosen(&nodes, matches.get_one::<String>("device"))?;
    let failed = |error: &std::io::Error| CliError::Failed(linux::trouble(node, error));
    let (mut wheel, device) = OpenWheel::open_rig(node, &nodes).map_err(|e| failed(&e))?;
    let name = matches.get_one::<String>("name").cloned().unwrap_or_else(|| device.name.clone());
    let begin = TimeStamp::now();
    let seconds = || begin.until(TimeStamp::now()).as_secs_f64();
    let mut calibration = Calibration::new(device.clone(), 0.0).map_err(|e| CliError::Failed(e.to_string()))?;
    let mut screen = CalibrationScreen::new();
    out::line(format_args!("{}", node.described()))?;
    for (number, part) in (1..).zip(&device.parts) {
        let node = nodes.iter().find(|node| (node.id, &node.place) == (part.id, &part.place));
        let name = node.map_or("a device", |node| &node.name);
        out::line(format_args!("with {name} ({})", parts::name(&device.parts, number).unwrap_or_default()))?;
    }
    let known = profiles::choose(&device, None).ok().map(|(profile, _)| profile);
    if let Some(known) = known.filter(|known| known.pedals_upside_down(&device.axes, &device.values)) {
        out::line(format_args!("{}", upside_down(&known)))?;
    }
    if let Some(path) = matches.get_one::<PathBuf>("replay") {
        for (at_s, code, raw) in events(path)? {
            screen.show(calibration.step().question(), &calibration.bars())?;
            calibration.moved(code, raw, at_s);
        }
    }
    while calibration.step() != CalibrationStep::Done && !matches.contains_id("replay") {
        screen.show(calibration.step().question(), &calibration.bars())?;
        let mut messages = Vec::new();
        wheel.read(Duration::from_millis(40), &mut messages).map_err(|e| failed(&e))?;
        for message in messages {
            if let WheelMessage::Axis { code, raw, .. } = message {
                calibration.moved(code, raw, seconds());
            }
        }
        calibration.time(seconds());
    }
    screen.show(CalibrationStep::Done.question(), &calibration.bars())?;
    let profile = calibration.profile(&name).map_err(|e| CliError::Failed(e.to_string()))?;
    let path = matches.get_one::<PathBuf>("out").map(PathBuf::as_path);
    let path = profiles::save(&profile, path).map_err(|e| CliError::Failed(e.to_string()))?;
    out::line(format_args!("\n{}\nsaved in {}", summary(&profile), path.display()))?;
    Ok(())
}

/// Returns the device to be calibrated: the one that a person named, or the first wheel.
#[cfg(target_os = "linux")]
fn chosen<'a>(nodes: &'a [DeviceNode], named: Option<&String>) -> Result<&'a DeviceNode, CliError> {
    let described = |nodes: &[&DeviceNode]| nodes.iter().map(|node| node.described()).collect::<Vec<_>>().join(", ");
    let all: Vec<&DeviceNode> = nodes.iter().collect();
    if let Some(named) = named {
        let matching = nodes.iter().find(|node| node.described().ends_with(&format!("({})", named.to_lowercase())));
        return matching.ok_or_else(|| {
            let there = if all.is_empty() { "none".into() } else { described(&all) };
            CliError::Failed(format!(
                "no device with axes has the id {named}; there are: {there}\n  remedy: name one of these ids, as \
                 --device 346e:0004"
            ))
        });
    }
    for node in nodes {
        if let DeviceKind::Unfit(text) = node.kind {
            out::status_line(format_args!("{text}"));
        }
    }
    let wheels: Vec<&DeviceNode> = nodes.iter().filter(|node| node.kind == DeviceKind::Wheel).collect();
    if let [first, _, ..] = wheels[..] {
        out::status_line(format_args!(
            "{} wheels are plugged in, {}; {} is calibrated\n  remedy: unplug the others, or name one with --device",
            wheels.len(),
            described(&wheels),
            first.name
        ));
    }
    let others: Vec<&DeviceNode> =
        nodes.iter().filter(|node| node.kind == DeviceKind::Controller || node.kind == DeviceKind::Pad).collect();
    let seen = if others.is_empty() {
        String::new()
    } else {
        format!(
            "\n  not known as a wheel by force, maker, name or profile: {}\n  remedy: if one of these is the wheel, name \
             its id with --device",
            described(&others)
        )
    };
    wheels.first().copied().ok_or_else(|| {
        CliError::Failed(format!(
            "no steering wheel is plugged in\n  remedy: plug it in, wait until it has turned, and begin again{seen}"
        ))
    })
}

/// Returns the axis events of a file of evemu-record: seconds, code, value. Other lines describe the device and are skipped.
#[cfg(target_os = "linux")]
fn events(path: &std::path::Path) -> Result<Vec<(f64, u16, i32)>, CliError> {
    /// Type of axis events.
    const EV_ABS: u16 = 3;
    /// Maximum size of a recording of a wheel, bytes: about a quarter of an hour of turning.
    const EVENTS_BYTES: u64 = 64 << 20;
    let shown = path.display();
    let text = crate::file::read_text(path, EVENTS_BYTES).map_err(|e| {
        CliError::Input(format!("{shown}: cannot be read: {e}\n  remedy: evemu-record makes such a file"))
    })?;
    let mut found = Vec::new();
    for (row, line) in text.lines().enumerate() {
        let Some(event) = line.strip_prefix("E: ") else { continue };
        let mut words = event.split_whitespace();
        let mut word = || words.next().unwrap_or_default();
        let hex = |text: &str| u16::from_str_radix(text, 16);
        match (word().parse(), hex(word()), hex(word()), word().parse()) {
            (Ok(at_s), Ok(EV_ABS), Ok(code), Ok(raw)) => found.push((at_s, code, raw)),
            (Ok(_), Ok(_), Ok(_), Ok(_)) => {}
            _ => {
                let text =
                    format!("{shown}:{}: \"{line}\" is not an event; allowed: E: SECONDS TYPE CODE VALUE", row + 1);
                return Err(CliError::Input(text));
            }
        }
    }
    Ok(found)
}

/// Terminal output of the calibration: questions, and live bars if the output is a terminal.
#[cfg(target_os = "linux")]
struct CalibrationScreen {
    question: &'static str,
    live: bool,
}

#[cfg(target_os = "linux")]
impl CalibrationScreen {
    fn new() -> Self {
        use std::io::IsTerminal;
        Self { question: "", live: std::io::stdout().is_terminal() }
    }

    fn show(&mut self, question: &'static str, bars: &[(u16, String, f64)]) -> Result<(), CliError> {
        if question != self.question {
            self.question = question;
            out::line(format_args!("{}{question}", if self.live { "\n" } else { "" }))?;
        }
        if self.live {
            let bars: Vec<String> = bars.iter().map(|(_, name, share)| format!("{name} {}", bar(*share))).collect();
            out::redrawn(format_args!("  {}", bars.join("  ")))?;
        }
        Ok(())
    }
}

/// Returns a bar of ten characters, filled from the left; `share` is 0..1.
#[cfg(target_os = "linux")]
fn bar(share: f64) -> String {
    let full = (share.clamp(0.0, 1.0) * 10.0).round() as usize;
    format!("{}{}", "#".repeat(full), ".".repeat(10 - full))
}

/// Returns the question for a wheel whose driver reports the pedals the other way round than `known` expects.
#[cfg(target_os = "linux")]
fn upside_down(known: &crate::input::WheelProfile) -> String {
    format!(
        "Is a foot on the pedals? If so, release them. If not, the wheel's driver turns them round: they rest where the \
         profile \"{}\" calls them pressed. This calibration measures them, and its profile then replaces that one.",
        known.name
    )
}

/// Returns the measured profile as text, with each pedal's curve at quarters of its travel.
#[cfg(target_os = "linux")]
fn summary(profile: &crate::input::WheelProfile) -> String {
    let s = &profile.steering;
    let mut lines = vec![format!(
        "{}: steering axis {}, {} left, {} straight, {} right, {} deg",
        profile.name, s.axis, s.left, s.centre, s.right, s.range_deg
    )];
    for (name, pedal) in profile.pedals() {
        let way = |share: f64| pedal.released + ((f64::from(pedal.pressed - pedal.released)) * share) as i32;
        let curve: Vec<String> =
            [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| format!("{:.2}", pedal.effect(way(share)))).into();
        lines.push(format!(
            "{name}: axis {}{}, {} released, {} pressed, dead {:.1} %, curve {}",
            pedal.axis,
            pedal.device.as_ref().map_or_else(String::new, |device| format!(" of {device}")),
            pedal.released,
            pedal.pressed,
            100.0 * pedal.dead,
            curve.join(" ")
        ));
    }
    lines.join("\n")
}
