//! Checks of steering wheel, permissions and force feedback. In: the system's devices. Out: [`Finding`]s.

use super::Finding;

#[cfg(not(target_os = "linux"))]
pub(super) fn examine() -> Vec<Finding> {
    let remedy = "use Linux for a study: wheels then have time stamps of the kernel";
    let force = match crate::input::sdl_force::look() {
        Ok(path) => Finding::ok("force", format!("through {}, if the wheel's driver has a motor", path.display())),
        Err(none) => Finding::warning("force", none.to_string(), none.remedy),
    };
    vec![Finding::warning("wheel", "unknown on this system", remedy), force]
}

#[cfg(target_os = "linux")]
pub(super) fn examine() -> Vec<Finding> {
    use super::FindingGrade;
    use crate::input::{
        kinds::DeviceKind,
        linux::{self, DeviceNode},
        profiles,
    };

    let nodes = linux::controllers(None);
    let (wheels, others): (Vec<&DeviceNode>, Vec<&DeviceNode>) = nodes.iter().partition(|node| node.is_wheel());
    let seen: Vec<String> = others.iter().map(|node| node.described()).collect();
    if wheels.is_empty() {
        let remedy = "plug in a wheel; set the switch of a G29 to PS3. Keyboard and pads also work";
        let mut lines = vec![
            Finding::warning("wheel", "none is plugged in", remedy),
            Finding::warning("force", "none without a wheel", "as above"),
        ];
        if !seen.is_empty() {
            let found = format!("{}: not known as a wheel by force, maker, name or profile", seen.join(", "));
            lines.push(Finding::ok(
                "other devices",
                format!("{found}; if one is the wheel: codrive calibrate --device ID"),
            ));
        }
        let faults = profiles::own_profiles().1;
        lines.extend(faults.iter().map(|text| Finding::from_message("wheel", FindingGrade::Warning, text)));
        return lines;
    }
    let mut lines = Vec::new();
    for node in &wheels {
        if let DeviceKind::Unfit(text) = node.kind {
            lines.push(Finding::from_message("wheel", FindingGrade::Fault, text));
            continue;
        }
        lines.extend(usable(node, &nodes));
    }
    if wheels.len() > 1 {
        lines.push(Finding::warning("wheel", format!("{} are plugged in", wheels.len()), "unplug all but one"));
    }
    if !seen.is_empty() {
        lines.push(Finding::ok("other devices", format!("not taken for wheels: {}", seen.join(", "))));
    }
    lines
}

#[cfg(target_os = "linux")]
fn usable(node: &crate::input::linux::DeviceNode, others: &[crate::input::linux::DeviceNode]) -> Vec<Finding> {
    use super::FindingGrade;
    use crate::input::{
        linux::{self, OpenWheel},
        profiles,
    };
    let opened = OpenWheel::open_rig(node, others).map_err(|e| linux::trouble(node, &e));
    let device = match opened {
        Ok((_, device)) => device,
        Err(text) => return vec![Finding::from_message("wheel", FindingGrade::Fault, &text)],
    };
    let mut lines = Vec::new();
    match profiles::choose(&device, None) {
        Ok((profile, faults)) => {
            lines.push(if profile.pedals_upside_down(&device.axes, &device.values) {
                let text = profile.upside_down_message(&node.described());
                Finding::from_message("wheel", FindingGrade::Fault, &text)
            } else {
                Finding::ok("wheel", format!("{}, profile {}", node.described(), profile.name))
            });
            lines.extend(faults.iter().map(|text| Finding::from_message("wheel", FindingGrade::Warning, text)));
            lines.extend(range(node, profile.steering.range_deg));
        }
        Err(error) => lines.push(Finding::from_message("wheel", FindingGrade::Fault, &error.to_string())),
    }
    lines.push(match linux::capabilities(node) {
        Ok(can) if can.constant => {
            let yes = |has: bool| if has { "yes" } else { "no" };
            let (gain, autocentre) = (yes(can.gain), yes(can.autocentre));
            Finding::ok(
                "force",
                format!("constant force yes, gain {gain}, autocentre {autocentre}, {} effects", can.effects),
            )
        }
        Ok(_) => Finding::warning("force", "its driver has no constant force", "another wheel, or drive without force"),
        Err(error) => Finding::from_message("force", FindingGrade::Fault, &linux::trouble(node, &error)),
    });
    lines.push(if crate::input::force_thread::may_hurry() {
        Finding::ok("force pace", "its thread runs in real time")
    } else {
        let remedy = "add to /etc/security/limits.conf: YOUR-NAME - rtprio 10   and log in again";
        Finding::warning("force pace", "its thread has no priority: late by milliseconds on a busy processor", remedy)
    });
    lines
}

/// Checks the range of rotation set in the driver against the profile; `None` if the driver does not report it.
#[cfg(target_os = "linux")]
fn range(node: &crate::input::linux::DeviceNode, expected_deg: f64) -> Option<Finding> {
    let event = node.path.file_name()?;
    let path = std::path::Path::new("/sys/class/input").join(event).join("device/device/range");
    let deg: f64 = std::fs::read_to_string(&path).ok()?.trim().parse().ok()?;
    let found = format!("turns by {deg:.0} degrees");
    if deg == expected_deg {
        return Some(Finding::ok("range", found));
    }
    let remedy = format!("echo {expected_deg:.0} | sudo tee {}", path.display());
    Some(Finding::warning("range", format!("{found}, the profile says {expected_deg:.0}"), remedy))
}
