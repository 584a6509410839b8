//! Analysed drives. In: the recordings found in a folder. Out: the measures of each drive and the data of its figures, and
//! drives by condition and participant.

mod analysed;
mod by_condition;
#[cfg(test)]
pub(super) mod test_drives;

pub use analysed::{AnalysedRecording, analyse, road_kinds};

pub(super) use by_condition::is_of_several_people;
pub use by_condition::{StatisticalPower, conditions, participants, per_participant, power, values};
