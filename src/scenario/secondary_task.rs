//! Settings of the secondary task. In: the table `[secondary_task]` of a scenario. Out: a [`SecondaryTask`].

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Secondary task of the driver, with the settings of each kind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SecondaryTask {
    /// Task that the participant does beside driving
    pub kind: SecondaryTaskKind,
    /// Detection response: place of the signal
    pub signal: TaskSignal,
    /// n-back: number of digits back, 0 to 2; 0 asks for a press at each 0
    #[schemars(range(min = 0, max = 2))]
    pub n: u8,
    /// n-back: speak the digits in English, by the program espeak-ng; otherwise, and where they cannot be heard, they are shown
    pub spoken_digits: bool,
    /// n-back: responses are spoken. Blocks then have each digit once, and no button is scored
    pub spoken_response: bool,
    /// n-back: time from one digit to the next
    #[schemars(range(min = 1.0, max = 10.0), extend("unit" = "s"))]
    // From memory (docs/references.md: secondary-tasks).
    pub digit_interval_s: f64,
    /// n-back: pause between two blocks of ten digits
    #[schemars(range(min = 0.0, max = 120.0), extend("unit" = "s"))]
    pub block_pause_s: f64,
    /// Surrogate reference: number of columns of the cursor
    #[schemars(range(min = 2, max = 12))]
    pub columns: u8,
    /// Surrogate reference: diameter of the target, as a multiple of the other circles'
    #[schemars(range(min = 1.1, max = 3.0))]
    pub size_ratio: f64,
    /// Surrogate reference: place of the circles
    pub display: SearchPlace,
    /// Occlusion: time for which the shutter is open
    #[schemars(range(min = 0.1, max = 60.0), extend("unit" = "s"))]
    pub open_s: f64,
    /// Occlusion: time for which the shutter is closed
    #[schemars(range(min = 0.1, max = 60.0), extend("unit" = "s"))]
    pub closed_s: f64,
    /// Occlusion: the shutter opens on a press of the button alone
    pub self_paced: bool,
}

impl Default for SecondaryTask {
    fn default() -> Self {
        Self {
            kind: SecondaryTaskKind::None,
            signal: TaskSignal::Display,
            n: 1,
            spoken_digits: true,
            spoken_response: false,
            digit_interval_s: 2.25,
            block_pause_s: 7.5,
            columns: 6,
            size_ratio: 1.4,
            display: SearchPlace::Corner,
            open_s: 1.5,
            closed_s: 1.5,
            self_paced: false,
        }
    }
}

impl SecondaryTask {
    /// Returns true if the task speaks.
    pub fn speaks(&self) -> bool {
        self.kind == SecondaryTaskKind::NBack && self.spoken_digits
    }

    /// Returns true if the task has a window of its own.
    pub fn has_window(&self) -> bool {
        self.kind == SecondaryTaskKind::SurrogateReference && self.display == SearchPlace::Window
    }

    /// Returns true if the signal of the task is an LED.
    pub fn has_led(&self) -> bool {
        self.kind == SecondaryTaskKind::DetectionResponse && self.signal == TaskSignal::RemoteLed
    }
}

/// Place of the detection response task's signal (docs/references.md: secondary-tasks).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TaskSignal {
    /// A disc on the screen
    #[default]
    Display,
    /// All rev lamps of the wheel, or another LED; on the screen where that fails
    RemoteLed,
}

/// Kind of a secondary task (docs/references.md: secondary-tasks).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SecondaryTaskKind {
    /// No task beside driving
    #[default]
    None,
    /// A red signal every 3 to 5 s, to be answered by a press (ISO 17488)
    DetectionResponse,
    /// Digits to be kept in mind
    NBack,
    /// A larger circle to be found among many (ISO/TS 14198)
    SurrogateReference,
    /// A shutter before the picture
    Occlusion,
}

/// Place of the surrogate reference task's display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SearchPlace {
    /// Lower left corner of the picture
    #[default]
    Corner,
    /// Window of its own, for a second monitor
    Window,
}
