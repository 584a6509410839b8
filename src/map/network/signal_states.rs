//! States of all signals of a network at one moment. In: SUMO's letters, signal by signal. Out: the light of any link.

use super::{Network, SignalId, SignalLight};

/// States of all signals: one SUMO letter per link, signal after signal. Empty for a network without signals.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct SignalStates {
    letters: Vec<u8>,
    /// Index of the first letter of each signal; one more entry at the end.
    starts: Vec<u32>,
}

impl Clone for SignalStates {
    fn clone(&self) -> Self {
        Self { letters: self.letters.clone(), starts: self.starts.clone() }
    }

    /// Reuses memory where the capacity suffices: a view takes the states in each step.
    fn clone_from(&mut self, source: &Self) {
        self.set(&source.letters, &source.starts);
    }
}

impl SignalStates {
    /// Computes the states `time_s` seconds after the start from the first program and the phase durations of each signal. A fixed
    /// program shows exactly these states; an actuated one shows them if no vehicle arrives. A signal without a program has no letters.
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

    /// Returns the states in which every link of every signal shows one of SUMO's letters.
    pub fn uniform(network: &Network, letter: u8) -> Self {
        let mut states = Self { letters: Vec::new(), starts: vec![0] };
        for signal in network.signals() {
            states.letters.resize(states.letters.len() + signal.links.len(), letter);
            states.starts.push(states.letters.len() as u32);
        }
        states
    }

    /// Replaces the letters and the start index of each signal (one more at the end). Reuses memory where the capacity suffices.
    pub fn set(&mut self, letters: &[u8], starts: &[u32]) {
        self.letters.clear();
        self.letters.extend_from_slice(letters);
        self.starts.clear();
        self.starts.extend_from_slice(starts);
    }

    /// Returns SUMO's letters of all signals, one per link, signal after signal.
    pub fn all_letters(&self) -> &[u8] {
        &self.letters
    }

    /// Returns SUMO's letters of a signal, one per link; none for an unknown signal.
    pub fn letters(&self, id: SignalId) -> &[u8] {
        let end = |k: usize| self.starts.get(k).map(|at| *at as usize);
        match (end(id.index()), end(id.index() + 1)) {
            (Some(from), Some(to)) => &self.letters[from..to],
            _ => &[],
        }
    }

    /// Returns the light of a link; `None` for an unknown link.
    pub fn light(&self, id: SignalId, link: u32) -> Option<SignalLight> {
        SignalLight::from_letter(*self.letters(id).get(link as usize)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fixed_program_shows_its_phases_in_order() {
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
