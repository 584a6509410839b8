//! State of the calibration page. In: its commands. Out: the participant's wheel for display, and a profile on disk.

use super::LiveDrive;
use crate::{
    input::{Rig, calibrate::CalibrationStep, profiles},
    panel::calibration::{CalibrationCommand, CalibrationProgress, PluggedWheel},
    time::Pace,
};

/// Returns the wheel for the calibration page; `None` if none is plugged in.
pub fn wheel(rig: &Rig) -> Option<PluggedWheel> {
    let (device, raw, last_button) = rig.raw()?;
    let profile = rig.profile()?.clone();
    let asked = rig.calibration().map(|calibration| CalibrationProgress {
        step: calibration.step(),
        bars: calibration.bars(),
        learnt: (calibration.step() == CalibrationStep::Done).then(|| calibration.profile(&device.name)),
    });
    let last_button = last_button.map(|code| device.button(code));
    Some(PluggedWheel { device: device.name.clone(), profile, raw: raw.clone(), last_button, asked })
}

impl LiveDrive {
    /// Carries out a command of the calibration page. Returns the message to show.
    pub fn calibrate(&mut self, command: CalibrationCommand) -> Option<String> {
        match command {
            CalibrationCommand::Begin => {
                // Wheel and pedals answer prompts now and do not drive. The pause also ends the force.
                self.drive.clock.set_pace(Pace::Paused);
                self.devices.rig_mut().calibrate().err().map(|error| error.to_string())
            }
            CalibrationCommand::Cancel | CalibrationCommand::Close => {
                self.devices.rig_mut().end_calibration();
                None
            }
            CalibrationCommand::Save(profile) => Some(match profiles::save(&profile, None) {
                Ok(path) => {
                    let name = profile.name.clone();
                    self.note("wheel calibrated", &name);
                    self.devices.rig_mut().take(*profile);
                    format!("Profile {name} is saved in {} and used from now on.", path.display())
                }
                Err(error) => error.to_string(),
            }),
        }
    }
}
