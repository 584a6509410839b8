//! Signals as data: programs of phases, one letter a link. Seconds.

use super::{ConnectionId, words::word_enum};

word_enum! {
    /// How a program goes through its phases.
    ProgramKind {
        /// Each phase has its time.
        Static = "static",
        /// Green goes on while vehicles come.
        Actuated = "actuated",
        /// Green goes on while vehicles lose time.
        DelayBased = "delay_based",
        /// The American standard with rings and barriers.
        Nema = "NEMA",
        /// A signal of a railway.
        RailSignal = "railSignal",
        /// A level crossing.
        RailCrossing = "railCrossing",
        /// One of the self-organising programs.
        SotlPhase = "sotl_phase",
        /// One of the self-organising programs.
        SotlPlatoon = "sotl_platoon",
        /// One of the self-organising programs.
        SotlRequest = "sotl_request",
        /// One of the self-organising programs.
        SotlWave = "sotl_wave",
        /// One of the self-organising programs.
        SotlMarching = "sotl_marching",
        /// One of the self-organising programs.
        Swarm = "swarm",
        /// One of the self-organising programs.
        Deterministic = "deterministic",
    }
}

/// What a link is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalLight {
    /// Red.
    Red,
    /// Red and yellow: green comes.
    RedYellow,
    /// Yellow: red comes.
    Yellow,
    /// Green, yielding to others.
    GreenMinor,
    /// Green with priority.
    GreenMajor,
    /// A green arrow to the right: stop first.
    GreenArrow,
    /// Off and blinking: yield.
    OffBlinking,
    /// Off: the rule of the road.
    Off,
}

impl SignalLight {
    /// What a letter of SUMO's states stands for.
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
    /// How long it lasts, seconds.
    pub duration_s: f64,
    /// The least that it lasts, seconds, where it may be shorter.
    pub min_s: Option<f64>,
    /// The most that it lasts, seconds, where it may be longer.
    pub max_s: Option<f64>,
    /// SUMO's letters, one a link.
    pub state: String,
    /// What else the file says of it, as words: `next`, `name`, those of NEMA.
    pub(super) other: Vec<(String, String)>,
}

impl SignalPhase {
    /// What a link is shown; `None` for one that the signal has not.
    pub fn light(&self, link: u32) -> Option<SignalLight> {
        SignalLight::from_letter(*self.state.as_bytes().get(link as usize)?)
    }
}

/// A program of a signal.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalProgram {
    /// SUMO's `programID`.
    pub id: String,
    /// How it goes through its phases.
    pub kind: ProgramKind,
    /// When its first phase begins, seconds; `None` at the start of the simulation, wherever that is.
    pub offset_s: Option<f64>,
    /// Its phases, at least one, with as many letters each.
    pub phases: Vec<SignalPhase>,
    /// Its settings, as words.
    pub(super) parameters: Vec<(String, String)>,
}

impl SignalProgram {
    /// Time of one round, seconds.
    pub fn cycle_s(&self) -> f64 {
        self.phases.iter().map(|phase| phase.duration_s).sum()
    }
}

/// A signal: programs over links.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// SUMO's id.
    pub id: String,
    /// Its programs, in the order of the file; none where SUMO makes the signal itself, at railways.
    pub programs: Vec<SignalProgram>,
    /// The connections of each link; a link may rule several, or none.
    pub links: Vec<Vec<ConnectionId>>,
}

impl Signal {
    /// True if it rules no connection at all.
    pub fn rules_nothing(&self) -> bool {
        self.links.iter().all(Vec::is_empty)
    }
}
