//! Wheel, permissions and force. In: the system's devices. Out: [`Line`]s.

use super::Line;

#[cfg(not(target_os = "linux"))]
pub(super) fn examine() -> Vec<Line> {
    let remedy = "a study's rig runs on Linux, where wheels have kernel times";
    let force = match crate::input::sdl_force::look() {
        Ok(path) => Line::ok("force", format!("through {}, if the wheel's driver has a motor", path.display())),
        Err([why, remedy]) => Line::warning("force", why, remedy),
    };
    vec![Line::warning("wheel", "unknown on this system", remedy), force]
}

#[cfg(target_os = "linux")]
pub(super) fn examine() -> Vec<Line> {
    use super::Grade;
    use crate::input::{linux, profiles::Kind};

    let nodes = linux::wheels();
    if nodes.is_empty() {
        let remedy = "plug it in; a G29 with its switch at PS3. Keyboard and pads drive without";
        return vec![
            Line::warning("wheel", "none is plugged in", remedy),
            Line::warning("force", "none without a wheel", "as above"),
        ];
    }
    let mut lines = Vec::new();
    for node in &nodes {
        if let Kind::Unfit(text) = node.kind {
            lines.push(Line::told("wheel", Grade::Fault, text));
            continue;
        }
        lines.extend(usable(node));
    }
    if nodes.len() > 1 {
        lines.push(Line::warning("wheel", format!("{} are plugged in", nodes.len()), "unplug all but one"));
    }
    lines
}

#[cfg(target_os = "linux")]
fn usable(node: &crate::input::linux::Node) -> Vec<Line> {
    use super::Grade;
    use crate::input::{
        linux::{self, OpenWheel},
        profiles,
    };
    let id = format!("{:04x}:{:04x}", node.id.0, node.id.1);
    let opened = OpenWheel::open(node).map_err(|e| linux::trouble(node, &e));
    let device = match opened {
        Ok((_, device)) => device,
        Err(text) => return vec![Line::told("wheel", Grade::Fault, &text)],
    };
    let mut lines = Vec::new();
    match profiles::choose(&device, None) {
        Ok((profile, faults)) => {
            lines.push(Line::ok("wheel", format!("{} ({id}), profile {}", node.name, profile.name)));
            lines.extend(faults.iter().map(|text| Line::told("wheel", Grade::Warning, text)));
            lines.extend(range(node, profile.steering.range_deg));
        }
        Err(error) => lines.push(Line::told("wheel", Grade::Fault, &error.to_string())),
    }
    lines.push(match linux::capabilities(node) {
        Ok(can) if can.constant => {
            let yes = |has: bool| if has { "yes" } else { "no" };
            let (gain, autocentre) = (yes(can.gain), yes(can.autocentre));
            Line::ok(
                "force",
                format!("constant force yes, gain {gain}, autocentre {autocentre}, {} effects", can.effects),
            )
        }
        Ok(_) => Line::warning("force", "its driver has no constant force", "another wheel, or drive without force"),
        Err(error) => Line::told("force", Grade::Fault, &linux::trouble(node, &error)),
    });
    lines.push(if crate::input::force_thread::may_hurry() {
        Line::ok("force pace", "its thread runs in real time")
    } else {
        let remedy = "add to /etc/security/limits.conf: YOUR-NAME - rtprio 10   and log in again";
        Line::warning(
            "force pace",
            "its thread waits for others: late by milliseconds where the processor is busy",
            remedy,
        )
    });
    lines
}

/// The turn that the driver has set, where it tells.
#[cfg(target_os = "linux")]
fn range(node: &crate::input::linux::Node, expected_deg: f64) -> Option<Line> {
    let event = node.path.file_name()?;
    let path = std::path::Path::new("/sys/class/input").join(event).join("device/device/range");
    let deg: f64 = std::fs::read_to_string(&path).ok()?.trim().parse().ok()?;
    let found = format!("turns by {deg:.0} degrees");
    if deg == expected_deg {
        return Some(Line::ok("range", found));
    }
    let remedy = format!("echo {expected_deg:.0} | sudo tee {}", path.display());
    Some(Line::warning("range", format!("{found}, the profile says {expected_deg:.0}"), remedy))
}
