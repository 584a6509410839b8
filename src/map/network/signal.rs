//! Signals as data: programs of phases, one letter per link. Seconds.

use super::{ConnectionId, named_enum::named_enum};

named_enum! {
    /// Type of a signal program.
    ProgramKind {
        /// Fixed time: each phase has its duration.
        Static = "static",
        /// Actuated: green is extended while vehicles arrive.
        Actuated = "actuated",
        /// Delay-based: green is extended while vehicles lose time.
        DelayBased = "delay_based",
        /// NEMA, the American standard with rings and barriers.
        Nema = "NEMA",
        /// Signal of a railway, made by SUMO.
        RailSignal = "railSignal",
        /// Level crossing, controlled by SUMO.
        RailCrossing = "railCrossing",
        /// Self-organising program (SOTL), by phase.
        SotlPhase = "sotl_phase",
        /// Self-organising program (SOTL), by platoon.
        SotlPlatoon = "sotl_platoon",
        /// Self-organising program (SOTL), by request.
        SotlRequest = "sotl_request",
        /// Self-organising program (SOTL), green wave.
        SotlWave = "sotl_wave",
        /// Self-organising program (SOTL), marching.
        SotlMarching = "sotl_marching",
        /// Self-organising program, swarm-based.
        Swarm = "swarm",
        /// Self-organising program, deterministic.
        Deterministic = "deterministic",
    }
}

/// Light that a signal shows for a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalLight {
    Red,
    /// Red and yellow: green comes.
    RedYellow,
    /// Yellow, shown before red.
    Yellow,
    /// Green, yielding to others.
    GreenMinor,
    /// Green with priority over other links.
    GreenMajor,
    /// Green arrow to the right: stop first.
    GreenArrow,
    /// Off and blinking: yield.
    OffBlinking,
    /// Off: the junction's rule applies.
    Off,
}

impl SignalLight {
    /// Returns the light for a letter of SUMO's states; `None` for an unknown letter.
    pub fn from_letter(letter: u8) -> Option<Self> {
        Some(match letter {
            b'r' | b'R' => Self::Red,
            b'u' | b'U' => Self::RedYellow,
            b'y' | b'Y' => Self::Yellow,
            b'g' => Self::GreenMinor,
            b'G' => Self::GreenMajor,
            b's' | b'S' => Self::GreenArrow,
            b'o' => Self::OffBlinking,
            b'O' => Self::Off,
            _ => return None,
        })
    }
}

/// One phase of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalPhase {
    /// Duration of the phase, seconds.
    pub duration_s: f64,
    /// Minimum duration, seconds, if the phase may be shortened.
    pub min_s: Option<f64>,
    /// Maximum duration, seconds, if the phase may be extended.
    pub max_s: Option<f64>,
    /// SUMO's letters, one per link.
    pub state: String,
    /// Further attributes of the file, as name and value: `next`, `name`, those for NEMA.
    pub(super) other: Vec<(String, String)>,
}

impl SignalPhase {
    /// Returns the light of a link; `None` for a link that the signal lacks.
    pub fn light(&self, link: u32) -> Option<SignalLight> {
        SignalLight::from_letter(*self.state.as_bytes().get(link as usize)?)
    }
}

/// Program of a signal.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalProgram {
    /// SUMO's `programID`, unique within the signal.
    pub id: String,
    /// Type of the program.
    pub kind: ProgramKind,
    /// Start of the first phase, seconds; `None` for the start of the simulation, `offset="begin"`.
    pub offset_s: Option<f64>,
    /// Phases, at least one, all with the same number of letters.
    pub phases: Vec<SignalPhase>,
    /// Parameters of the program, as key and value.
    pub(super) parameters: Vec<(String, String)>,
}

impl SignalProgram {
    /// Returns the duration of one cycle, seconds.
    pub fn cycle_s(&self) -> f64 {
        self.phases.iter().map(|phase| phase.duration_s).sum()
    }
}

/// Signal: programs over links.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// SUMO's id, unique among signals.
    pub id: String,
    /// Programs, in the order of the file; none for a railway signal that SUMO makes itself.
    pub programs: Vec<SignalProgram>,
    /// Connections of each link; a link may control several or none.
    pub links: Vec<Vec<ConnectionId>>,
}

impl Signal {
    /// Returns true if the signal controls no connection.
    pub fn rules_nothing(&self) -> bool {
        self.links.iter().all(Vec::is_empty)
    }
}
