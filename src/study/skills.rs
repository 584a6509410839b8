//! Skills of a practice drive, each with the criterion that shows it. In: a map and a policy. Out: names, criteria, and the skills that a
//! drive cannot show.
//!
//! No standard says when a participant masters a simulator. The criteria are this project's: the least after which a trial is no longer
//! about the controls.

use crate::map::{Manoeuvre, PathLanes, RoadMap, StopRule};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Kind of the event at which a skill was shown; its detail is the skill's name.
pub const SKILL: &str = "skill";
/// Kind of the event at the end of a drive with the skills that were not shown.
pub const SKILLS_MISSING: &str = "skills_missing";

/// Speed below which the vehicle stands, m/s.
pub(super) const STANDING_MPS: f64 = 0.3;
/// Speed that a start reaches, m/s: 15 km/h.
pub(super) const STARTED_MPS: f64 = 15.0 / 3.6;
/// Largest distance from the front to the line of a stop, m: a car is 4.6 m long, so that no other fits between.
pub(super) const AT_LINE_M: f64 = 4.0;
/// Least speed at which following counts, m/s: 20 km/h, faster than a queue.
pub(super) const FOLLOWING_MPS: f64 = 20.0 / 3.6;
/// Time gaps of following, s: below 1 s is too close, and above 4 s a driver keeps their own speed (Vogel 2002 finds that vehicles up to
/// 6 s behind another are influenced by it).
pub(super) const FOLLOWING_GAPS_S: std::ops::RangeInclusive<f64> = 1.0..=4.0;
/// Time of following, all stretches together, s.
pub(super) const FOLLOWED_S: f64 = 10.0;
/// Unbroken time in the range of the advice, s.
pub(super) const IN_RANGE_S: f64 = 10.0;

/// A skill of a practice drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Skill {
    /// To start from standing.
    Start,
    /// To stop at a line.
    Stop,
    /// To turn at a junction.
    Turn,
    /// To follow another vehicle at speed.
    Follow,
    /// To use the dial: to keep the speed in the range of the advice.
    Dial,
}

/// All skills, in the order in which they are listed.
pub const SKILLS: [Skill; 5] = [Skill::Start, Skill::Stop, Skill::Turn, Skill::Follow, Skill::Dial];

impl Skill {
    /// Returns the word for the skill in study files and data.
    pub fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Stop => "stop",
            Self::Turn => "turn",
            Self::Follow => "follow",
            Self::Dial => "dial",
        }
    }

    /// Returns the criterion in words.
    pub fn criterion(self) -> String {
        match self {
            Self::Start => "from standing to 15 km/h".into(),
            Self::Stop => format!("stands at most {AT_LINE_M} m before the line of a stop sign or a red signal"),
            Self::Turn => "left or right at a junction, without leaving the road".into(),
            Self::Follow => {
                let [least_s, most_s] = [FOLLOWING_GAPS_S.start(), FOLLOWING_GAPS_S.end()];
                format!("{least_s} to {most_s} s behind a vehicle, faster than 20 km/h, for {FOLLOWED_S} s in all")
            }
            Self::Dial => format!("in the green band for {IN_RANGE_S} s without a break"),
        }
    }

    /// Returns what a drive lacks to show the skill; `None` if it can be shown.
    pub(super) fn lacks(self, map: &RoadMap, gives_advice: bool) -> Option<&'static str> {
        match self {
            Self::Start | Self::Follow => None,
            Self::Stop => {
                let lanes = PathLanes::new(map);
                let is_there = !lanes.stop_lines().is_empty()
                    || lanes.yield_lines(map).iter().any(|line| line.stop != StopRule::None);
                (!is_there).then_some("its path has no stop sign and no signal")
            }
            Self::Turn => {
                let guidance = PathLanes::new(map).guidance(map);
                let mut turns = guidance.manoeuvres().filter(|manoeuvre| is_turn(*manoeuvre));
                turns.next().is_none().then_some("its path does not turn at a junction")
            }
            Self::Dial => (!gives_advice).then_some("its policy gives no advice"),
        }
    }
}

/// Returns true for a turn to the left or right.
pub(super) fn is_turn(manoeuvre: Manoeuvre) -> bool {
    matches!(manoeuvre, Manoeuvre::Left | Manoeuvre::Right)
}

/// Skills that were shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShownSkills([bool; SKILLS.len()]);

impl ShownSkills {
    /// Notes that a participant has it.
    pub fn add(&mut self, skill: Skill) {
        self.0[skill as usize] = true;
    }

    /// Returns true if a skill was shown.
    pub fn contains(self, skill: Skill) -> bool {
        self.0[skill as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_road_without_junctions_or_advice_cannot_show_every_skill() {
        let lacking = |map: &RoadMap, gives_advice: bool| {
            let lacks = SKILLS.into_iter().filter(|skill| skill.lacks(map, gives_advice).is_some());
            lacks.map(Skill::name).collect::<Vec<_>>()
        };
        let town = RoadMap::load("town").expect("a shipped map");
        assert_eq!(lacking(&town, true), [""; 0]);
        assert_eq!(lacking(&town, false), ["dial"]);
        let ring = RoadMap::load("ring-250").expect("a shipped map");
        assert_eq!(lacking(&ring, true), ["stop", "turn"]);
    }

    #[test]
    fn names_are_those_of_study_files() {
        for skill in SKILLS {
            assert_eq!(serde_json::to_value(skill).expect("a word"), skill.name());
        }
    }
}
