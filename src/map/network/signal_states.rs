//! What all signals of a network show at one moment. In: SUMO's letters, signal by signal. Out: the light of any link.

use super::{Network, SignalId, SignalLight};

/// What all signals show: one of SUMO's letters a link, signal after signal. Empty where there are none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SignalStates {
    letters: Vec<u8>,
    /// Where the letters of each signal begin, and where the last ends.
    starts: Vec<u32>,
}

impl SignalStates {
    /// What the signals show `time_s` after the start, each by its first program and the times of its phases: what a fixed
    /// program shows, and what one that waits for vehicles shows if none come. A signal without a program shows nothing.
    pub fn by_first_program(network: &Network, time_s: f64) -> Self {
        let mut states = Self { letters: Vec::new(), starts: vec![0] };
        for signal in network.signals() {
            if let Some(program) = signal.programs.first() {
                let mut left_s = (time_s - program.offset_s.unwrap_or(0.0)).rem_euclid(program.cycle_s());
                let shown = program.phases.iter().find(|phase| {
                    left_s -= phase.duration_s;
                    left_s < 0.0
                });
                let phase = shown.unwrap_or(&program.phases[program.phases.len() - 1]);
                states.letters.extend_from_slice(phase.state.as_bytes());
            }
            states.starts.push(states.letters.len() as u32);
        }
        states
    }

    /// Takes over letters and where each signal's begin (one more at the end), without asking for memory where there is enough.
    pub fn set(&mut self, letters: &[u8], starts: &[u32]) {
        self.letters.clear();
        self.letters.extend_from_slice(letters);
        self.starts.clear();
        self.starts.extend_from_slice(starts);
    }

    /// SUMO's letters of all signals, one a link, signal after signal.
    pub fn all_letters(&self) -> &[u8] {
        &self.letters
    }

    /// SUMO's letters of a signal, one a link; none for a signal that is not known.
    pub fn letters(&self, id: SignalId) -> &[u8] {
        let end = |k: usize| self.starts.get(k).map(|at| *at as usize);
        match (end(id.index()), end(id.index() + 1)) {
            (Some(from), Some(to)) => &self.letters[from..to],
            _ => &[],
        }
    }

    /// What a link is shown; `None` for one that is not known.
    pub fn light(&self, id: SignalId, link: u32) -> Option<SignalLight> {
        SignalLight::from_letter(*self.letters(id).get(link as usize)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fixed_program_shows_its_phases_one_after_the_other() {
        let network = Network::load("tests/data/networks/grid-signals.net.xml").expect("a network");
        for (k, signal) in network.signals().iter().enumerate() {
            let (id, program) = (SignalId::from_index(k), &signal.programs[0]);
            let mut begin_s = program.offset_s.unwrap_or(0.0);
            for phase in program.phases.iter().chain(&program.phases) {
                for time_s in [begin_s, begin_s + phase.duration_s - 0.01] {
                    let states = SignalStates::by_first_program(&network, time_s);
                    assert_eq!(states.letters(id), phase.state.as_bytes(), "{} at {time_s} s", signal.id);
                    assert_eq!(states.light(id, 1), phase.light(1));
                }
                begin_s += phase.duration_s;
            }
        }
        assert!(!network.signals().is_empty());
        assert_eq!(SignalStates::default().light(SignalId::from_index(0), 0), None);
    }
}
