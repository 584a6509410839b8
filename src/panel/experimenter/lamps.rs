//! Warning lamps of the experimenter's window. In: measured values ([`DriveHealth`]). Out: lamps in green, amber or
//! red, each with a text and, where it is not green, what to do. The limits are defined here.

use crate::{panel::theme, record};
use egui::{Color32, RichText, Sense, Ui, vec2};

/// Measurements of a running drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveHealth {
    /// Mean and longest frame time of the last second or so, ms; zero before the first frame.
    pub frame_ms: [f64; 2],
    /// Time lost in stalls, s: since the start, and in the last ten seconds.
    pub dropped_s: [f64; 2],
    /// Latency from input to the picture that shows it, ms: median and 99th percentile; `None` without input.
    pub latency_ms: Option<[f64; 2]>,
    /// True before the start of a drive that will be recorded.
    pub will_record: bool,
    /// The recording; `None` if the drive is not recorded.
    pub recording: Option<RecordingHealth>,
    /// State of the steering wheel.
    pub wheel: WheelHealth,
    /// Contacts with other vehicles.
    pub contacts: ContactHealth,
    /// Name of the traffic engine; empty before there is a drive.
    pub engine: String,
    /// Reason that the drive cannot start or continue.
    pub error: Option<String>,
}

/// State of the recorder.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RecordingHealth {
    /// Batches waiting for the disk, and the capacity of the queue.
    pub waiting: [usize; 2],
    /// Free disk space, GB; `None` where the system does not report it.
    pub free_gb: Option<f64>,
}

/// Contacts of the ego with other vehicles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactHealth {
    /// Contacts since the start of the drive.
    pub count: u32,
    /// Closing speed of the last contact, m/s, and the time since it, s.
    pub last: Option<[f64; 2]>,
}

/// State of the steering wheel.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum WheelHealth {
    /// A wheel is plugged in; its name.
    There(String),
    /// No wheel: keyboard or pad.
    #[default]
    None,
    /// The wheel was unplugged during a drive.
    Lost,
}

/// Colour of a lamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LampColour {
    /// Nothing has been measured yet.
    Off,
    /// All values within the limits.
    Green,
    /// Needs a check when there is time.
    Amber,
    /// The trial is affected.
    Red,
}

/// Warning lamp with its text.
#[derive(Clone, Debug, PartialEq)]
pub struct Lamp {
    /// Subject of the lamp.
    pub name: &'static str,
    pub light: LampColour,
    /// Finding, in a few words.
    pub words: String,
    /// Tooltip: meaning, limits, remedy.
    pub tip: &'static str,
}

impl std::fmt::Display for LampColour {
    /// Writes the state as a word, so that it can be read without seeing the colour.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Off => "off",
            Self::Green => "good",
            Self::Amber => "check",
            Self::Red => "bad",
        })
    }
}

impl LampColour {
    /// Returns the colour on the screen.
    pub fn colour(self) -> Color32 {
        match self {
            Self::Off => Color32::from_rgb(84, 92, 102),
            Self::Green => theme::GREEN,
            Self::Amber => theme::AMBER,
            Self::Red => theme::RED,
        }
    }

    /// Returns green up to the first limit, amber up to the second, red above it.
    fn of(value: f64, limits: [f64; 2]) -> Self {
        if value <= limits[0] {
            Self::Green
        } else if value <= limits[1] {
            Self::Amber
        } else {
            Self::Red
        }
    }
}

/// Returns all lamps, in a fixed order.
pub fn lamps(health: &DriveHealth) -> Vec<Lamp> {
    vec![
        frames(health),
        dropped(health),
        latency(health),
        recorder(health),
        disk(health),
        wheel(health),
        contacts(health),
        traffic(health),
    ]
}

fn frames(health: &DriveHealth) -> Lamp {
    let [mean, longest] = health.frame_ms;
    let light = if mean <= 0.0 {
        LampColour::Off
    } else {
        LampColour::of(mean, [20.0, 34.0]).max(LampColour::of(longest, [50.0, 250.0]))
    };
    let words = if mean <= 0.0 { "no frame yet".into() } else { format!("{mean:.1} ms, longest {longest:.0} ms") };
    let tip = "Time from one picture to the next over the last second. Good: 50 pictures per second, none longer than \
        50 ms. Bad: fewer than 30 per second, or one longer than 250 ms. --quality low is faster";
    Lamp { name: "Frames", light, words, tip }
}

fn dropped(health: &DriveHealth) -> Lamp {
    let [all, lately] = health.dropped_s;
    let light = match (all > 0.0, lately > 0.0) {
        (_, true) => LampColour::Red,
        (true, false) => LampColour::Amber,
        _ => LampColour::Green,
    };
    let words = if all > 0.0 { format!("{all:.2} s in all, {lately:.2} s lately") } else { "none".into() };
    let tip = "Time lost through late pictures; the drive stood still for this time. Bad: any in the last ten seconds";
    Lamp { name: "Dropped time", light, words, tip }
}

fn latency(health: &DriveHealth) -> Lamp {
    let tip = "Time from a movement of hand or foot to the picture that shows it. Good: median up to 50 ms and 99th \
        percentile up to 70 ms";
    let name = "Input latency";
    match health.latency_ms {
        None => Lamp { name, light: LampColour::Off, words: "no input yet".into(), tip },
        Some([median, most]) => {
            let light = LampColour::of(median, [50.0, 80.0]).max(LampColour::of(most, [70.0, 150.0]));
            Lamp { name, light, words: format!("{median:.0} ms, 99 %: {most:.0} ms"), tip }
        }
    }
}

fn recorder(health: &DriveHealth) -> Lamp {
    let tip = "Rows that wait for the disk. Good: fewer than a quarter of the queue. A full queue ends the trial; all \
        earlier rows are kept";
    let name = "Recorder";
    match health.recording {
        None if health.engine.is_empty() => Lamp { name, light: LampColour::Off, words: "no drive yet".into(), tip },
        None if health.will_record => Lamp { name, light: LampColour::Off, words: "begins with the drive".into(), tip },
        None => Lamp { name, light: LampColour::Amber, words: "this drive is not recorded".into(), tip },
        Some(RecordingHealth { waiting: [waiting, most], .. }) => {
            let light = LampColour::of(waiting as f64, [most as f64 / 4.0, most as f64 / 2.0]);
            let words = match waiting {
                0 => "recording, no backlog".into(),
                _ => format!("recording, {waiting} of {most} batches waiting"),
            };
            Lamp { name, light, words, tip }
        }
    }
}

fn disk(health: &DriveHealth) -> Lamp {
    let tip = "Free space on the disk of the recording. A session needs a few dozen megabytes. Good: over 5 GB; bad: \
        under 1 GB";
    let name = "Disk";
    match health.recording.and_then(|recording| recording.free_gb) {
        None => Lamp { name, light: LampColour::Off, words: "not checked".into(), tip },
        Some(gb) => Lamp {
            name,
            light: LampColour::of(-gb, [-record::LITTLE_GB, -record::TOO_LITTLE_GB]),
            words: format!("{gb:.1} GB free"),
            tip,
        },
    }
}

fn wheel(health: &DriveHealth) -> Lamp {
    let (light, words) = match &health.wheel {
        WheelHealth::There(name) => (LampColour::Green, name.clone()),
        WheelHealth::None => (LampColour::Amber, "none: keyboard or pad in use".into()),
        WheelHealth::Lost => (LampColour::Red, "unplugged: plug it in again".into()),
    };
    let tip = "Steering wheel of the participant. An unplugged wheel pauses the drive until it is back";
    Lamp { name: "Wheel", light, words, tip }
}

fn contacts(health: &DriveHealth) -> Lamp {
    let tip = "Contacts of the participant's vehicle with others. The recording has each contact with its speeds, and \
        the notes list it. Bad: any in the last ten seconds";
    let (light, words) = match health.contacts {
        _ if health.engine.is_empty() => (LampColour::Off, "no drive yet".into()),
        ContactHealth { count, last: Some([closing_mps, ago_s]) } => {
            let light = if ago_s < 10.0 { LampColour::Red } else { LampColour::Amber };
            (light, format!("{count}, the last at {closing_mps:.1} m/s"))
        }
        ContactHealth { .. } => (LampColour::Green, "none".into()),
    };
    Lamp { name: "Contacts", light, words, tip }
}

fn traffic(health: &DriveHealth) -> Lamp {
    let tip = "Traffic engine of the other vehicles";
    let (light, words) = match &health.error {
        Some(error) => (LampColour::Red, error.lines().next().unwrap_or_default().to_owned()),
        None if health.engine.is_empty() => (LampColour::Off, "not started".into()),
        None => (LampColour::Green, health.engine.clone()),
    };
    Lamp { name: "Traffic", light, words, tip }
}

/// Returns the worst colour of all lamps.
pub fn worst(lamps: &[Lamp]) -> LampColour {
    lamps.iter().map(|lamp| lamp.light).max().unwrap_or(LampColour::Off)
}

/// Shows all lamps with their texts. A lamp that is amber or red gets a line of its own with the full text.
pub fn show(ui: &mut Ui, lamps: &[Lamp]) {
    for lamp in lamps {
        let calm = lamp.light <= LampColour::Green;
        let line = ui.horizontal(|ui| {
            bulb(ui, lamp.light);
            ui.label(RichText::new(lamp.name).color(theme::TEXT));
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let (words, colour) =
                    if calm { (lamp.words.clone(), theme::DIM) } else { (lamp.light.to_string(), lamp.light.colour()) };
                ui.add(egui::Label::new(RichText::new(words).color(colour).size(12.0)).truncate());
            });
        });
        let mut response = line.response;
        if !calm {
            let words = RichText::new(&lamp.words).color(lamp.light.colour()).size(12.5);
            response = response.union(ui.add(egui::Label::new(words).wrap()));
        }
        response.on_hover_text(format!("{}: {}\n{}", lamp.name, lamp.words, lamp.tip));
    }
}

/// Shows all lamps in one line, for a narrow window: the bulbs, and the text of the worst.
pub fn strip(ui: &mut Ui, lamps: &[Lamp]) {
    for lamp in lamps {
        bulb(ui, lamp.light).on_hover_text(format!("{}: {}\n{}", lamp.name, lamp.words, lamp.tip));
    }
    let worst = worst(lamps);
    if let Some(lamp) = lamps.iter().find(|lamp| lamp.light == worst && worst >= LampColour::Amber) {
        let words = RichText::new(format!("{}: {}", lamp.name, lamp.words)).color(worst.colour());
        ui.add(egui::Label::new(words).truncate());
    }
}

/// Draws a disc for off and green, a triangle for amber, a square for red: distinguishable without colour.
fn bulb(ui: &mut Ui, light: LampColour) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(vec2(15.0, 15.0), Sense::hover());
    let (middle, colour, edge) =
        (rect.center(), light.colour(), egui::Stroke::new(1.0, Color32::from_black_alpha(120)));
    match light {
        LampColour::Off | LampColour::Green => ui.painter().circle(middle, 5.5, colour, edge),
        LampColour::Amber => {
            let corner = |x: f32, y: f32| middle + vec2(x, y);
            let corners = vec![corner(0.0, -6.5), corner(6.5, 5.0), corner(-6.5, 5.0)];
            ui.painter().add(egui::Shape::convex_polygon(corners, colour, edge))
        }
        LampColour::Red => {
            let square = egui::Rect::from_center_size(middle, vec2(11.0, 11.0));
            ui.painter().rect(square, 1.0, colour, edge, egui::StrokeKind::Inside)
        }
    };
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    fn healthy() -> DriveHealth {
        DriveHealth {
            frame_ms: [16.7, 18.0],
            dropped_s: [0.0, 0.0],
            latency_ms: Some([31.0, 44.0]),
            will_record: false,
            recording: Some(RecordingHealth { waiting: [0, 32], free_gb: Some(120.0) }),
            wheel: WheelHealth::There("G29 Racing Wheel".into()),
            contacts: ContactHealth::default(),
            engine: "SUMO 1.24.0".into(),
            error: None,
        }
    }

    fn light(health: &DriveHealth, name: &str) -> LampColour {
        lamps(health).into_iter().find(|lamp| lamp.name == name).unwrap().light
    }

    #[test]
    fn a_rig_in_order_is_green_throughout() {
        assert!(lamps(&healthy()).iter().all(|lamp| lamp.light == LampColour::Green), "{:?}", lamps(&healthy()));
        assert_eq!(worst(&lamps(&healthy())), LampColour::Green);
    }

    #[test]
    fn every_fault_lights_its_own_lamp_and_no_other() {
        type Fault = (&'static str, LampColour, fn(&mut DriveHealth));
        let cases: [Fault; 14] = [
            ("Frames", LampColour::Amber, |h| h.frame_ms = [25.0, 30.0]),
            ("Frames", LampColour::Red, |h| h.frame_ms = [17.0, 400.0]),
            ("Dropped time", LampColour::Amber, |h| h.dropped_s = [0.4, 0.0]),
            ("Dropped time", LampColour::Red, |h| h.dropped_s = [0.4, 0.4]),
            ("Input latency", LampColour::Amber, |h| h.latency_ms = Some([45.0, 90.0])),
            ("Input latency", LampColour::Red, |h| h.latency_ms = Some([120.0, 140.0])),
            ("Recorder", LampColour::Red, |h| {
                h.recording = h.recording.map(|r| RecordingHealth { waiting: [20, 32], ..r })
            }),
            ("Disk", LampColour::Amber, |h| {
                h.recording = h.recording.map(|r| RecordingHealth { free_gb: Some(2.0), ..r })
            }),
            ("Disk", LampColour::Red, |h| {
                h.recording = h.recording.map(|r| RecordingHealth { free_gb: Some(0.1), ..r })
            }),
            ("Wheel", LampColour::Amber, |h| h.wheel = WheelHealth::None),
            ("Wheel", LampColour::Red, |h| h.wheel = WheelHealth::Lost),
            ("Contacts", LampColour::Red, |h| h.contacts = ContactHealth { count: 1, last: Some([10.0, 2.0]) }),
            ("Contacts", LampColour::Amber, |h| h.contacts = ContactHealth { count: 3, last: Some([0.4, 60.0]) }),
            ("Traffic", LampColour::Red, |h| h.error = Some("SUMO ended\nat once".into())),
        ];
        for (name, expected, spoil) in cases {
            let mut health = healthy();
            spoil(&mut health);
            assert_eq!(light(&health, name), expected, "{name}: {health:?}");
            let others = lamps(&health).into_iter().filter(|lamp| lamp.name != name);
            assert!(others.map(|lamp| lamp.light).all(|light| light == LampColour::Green), "{name}");
        }
    }

    #[test]
    fn missing_measurements_are_off_and_an_unrecorded_drive_is_amber() {
        let health = DriveHealth { recording: None, latency_ms: None, frame_ms: [0.0; 2], ..healthy() };
        assert_eq!(light(&health, "Input latency"), LampColour::Off);
        assert_eq!(light(&health, "Frames"), LampColour::Off);
        assert_eq!(light(&health, "Disk"), LampColour::Off);
        assert_eq!(light(&health, "Recorder"), LampColour::Amber);
        // A drive that will be recorded has not begun: no warning.
        assert_eq!(light(&DriveHealth { will_record: true, ..health }, "Recorder"), LampColour::Off);
    }
}
