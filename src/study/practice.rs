//! Progress of a practice drive: the unbroken time in the acceptable range, and the skills shown. In: the drive, step by step. Out: a
//! [`PracticeProgress`]. The session window and the rehearsal both use these rules.
//!
//! There is no grace period: a step out of the range, or one without advice, resets the time to zero. The number on the speedometer turns
//! from green to white at the same edge, so the participant sees the rule that the criterion applies. A grace period would need a length
//! of its own, and a participant at the edge of the range could meet the criterion without holding the range. A change of advice resets
//! nothing while the speed is in the new range.

use super::skills::{
    AT_LINE_M, FOLLOWED_S, FOLLOWING_GAPS_S, FOLLOWING_MPS, IN_RANGE_S, STANDING_MPS, STARTED_MPS, ShownSkills, Skill,
    is_turn,
};
use crate::{
    map::{Manoeuvre, PathLanes, RoadMap, StopLine, StopRule, network::SignalLight},
    sim::Snapshot,
};

/// Unbroken time in the range, current and longest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UnbrokenTime {
    now_s: f64,
    longest_s: f64,
}

impl UnbrokenTime {
    /// Adds a step of this length, in or out of the range.
    pub fn add(&mut self, is_in_range: bool, step_s: f64) {
        self.now_s = if is_in_range { self.now_s + step_s } else { 0.0 };
        self.longest_s = self.longest_s.max(self.now_s);
    }

    /// Returns the current unbroken time in the range, s.
    pub fn now_s(&self) -> f64 {
        self.now_s
    }

    /// Returns the longest unbroken time so far, s. A criterion that was met for a single frame stays met.
    pub fn longest_s(&self) -> f64 {
        self.longest_s
    }

    /// Returns true once `enough_s` seconds were reached, with 1 ns of tolerance for rounding.
    pub fn has_reached(&self, enough_s: f64) -> bool {
        self.longest_s >= enough_s - 1e-9
    }
}

/// Goals of a practice drive; a drive that is not for practice has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PracticeGoals {
    /// Time in s that the speed must stay in the range without a break; the drive then ends early.
    pub until_in_range_s: Option<f64>,
    /// Skills that the participant shows in the drive.
    pub skills: Vec<Skill>,
}

impl PracticeGoals {
    /// Returns the criterion in words if it is met.
    pub fn met(&self, progress: &PracticeProgress) -> Option<String> {
        let met_s = self.until_in_range_s.filter(|enough_s| progress.in_range.has_reached(*enough_s));
        met_s.map(|enough_s| format!("{enough_s} s in the range without a break"))
    }

    /// Returns the skills that were shown between two moments.
    pub fn shown_between(&self, before: ShownSkills, now: ShownSkills) -> impl Iterator<Item = Skill> + '_ {
        self.skills.iter().copied().filter(move |skill| now.contains(*skill) && !before.contains(*skill))
    }

    /// Returns the skills that were not shown, by name and separated by commas; empty if all were.
    pub fn missing(&self, shown: ShownSkills) -> String {
        let names = self.skills.iter().filter(|skill| !shown.contains(**skill)).map(|skill| skill.name());
        names.collect::<Vec<_>>().join(", ")
    }
}

/// Progress of a practice drive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PracticeProgress {
    /// Unbroken time of the speed in the range.
    pub in_range: UnbrokenTime,
    /// Skills shown so far.
    pub shown: ShownSkills,
}

/// Observer of a practice drive.
#[derive(Debug, Default)]
pub struct PracticeObserver {
    /// Positions of the lines of stop signs on the path, metres.
    stop_signs: Vec<f64>,
    signals: Vec<StopLine>,
    progress: PracticeProgress,
    has_stood: bool,
    /// Left or right, while the vehicle is in the junction.
    turning: Option<Manoeuvre>,
    followed_s: f64,
}

impl PracticeObserver {
    /// Creates the observer of a drive on this map.
    pub fn new(map: &RoadMap) -> Self {
        let lanes = PathLanes::new(map);
        let lines = lanes.yield_lines(map);
        let stop_signs = lines.iter().filter(|line| line.stop != StopRule::None).map(|line| line.s_m).collect();
        Self { stop_signs, signals: lanes.stop_lines().to_vec(), ..Self::default() }
    }

    /// Adds a step of the drive of this length.
    pub fn step(&mut self, snapshot: &Snapshot, map: &RoadMap, step_s: f64) {
        let speed_mps = snapshot.ego.speed_mps;
        let PracticeProgress { in_range, shown } = &mut self.progress;
        in_range.add(snapshot.advice.is_some_and(|advice| advice.accepts(speed_mps)), step_s);
        if in_range.has_reached(IN_RANGE_S) {
            shown.add(Skill::Dial);
        }
        let stands = speed_mps.abs() < STANDING_MPS;
        self.has_stood |= stands;
        if self.has_stood && speed_mps >= STARTED_MPS {
            shown.add(Skill::Start);
        }
        let is_near = |s_m: f64| (0.0..=AT_LINE_M).contains(&map.route.difference(snapshot.ego_s_m, s_m));
        let is_red = |line: &StopLine| snapshot.signals.light(line.signal, line.link) == Some(SignalLight::Red);
        let mut lines = self.stop_signs.iter().copied();
        let mut red = self.signals.iter().filter(|line| is_red(line)).map(|line| line.s_m);
        if stands && snapshot.ego_lane.is_some() && (lines.any(is_near) || red.any(is_near)) {
            shown.add(Skill::Stop);
        }
        let under_way = snapshot.next_manoeuvre.filter(|next| next.ahead_m <= 0.0 && snapshot.ego_lane.is_some());
        let under_way = under_way.map(|next| next.manoeuvre).filter(|manoeuvre| is_turn(*manoeuvre));
        // A turn is over where its street begins; off all lanes there is none.
        if self.turning.is_some() && under_way.is_none() && snapshot.ego_lane.is_some() {
            shown.add(Skill::Turn);
        }
        self.turning = under_way;
        let gap_s = snapshot.leader_in_lane().map(|leader| leader.gap_m / speed_mps.max(STANDING_MPS));
        if speed_mps >= FOLLOWING_MPS && gap_s.is_some_and(|gap_s| FOLLOWING_GAPS_S.contains(&gap_s)) {
            self.followed_s += step_s;
        }
        if self.followed_s >= FOLLOWED_S - 1e-9 {
            shown.add(Skill::Follow);
        }
    }

    /// Returns the progress so far.
    pub fn progress(&self) -> PracticeProgress {
        self.progress
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        ego::EgoState,
        map::{
            PathGuidance,
            network::{LanePosition, SignalStates},
        },
        sim::Leader,
        study::skills::SKILLS,
        traffic::VehicleId,
    };

    /// A practice on a crossing with signals, where the path turns right: its line is at 69.2 m, and the turn ends at 78.2 m.
    struct Practice {
        map: RoadMap,
        guidance: PathGuidance,
        observer: PracticeObserver,
        signals: SignalStates,
    }

    impl Practice {
        /// Creates a practice in which every signal shows a letter.
        fn showing(letter: u8) -> Self {
            let map =
                RoadMap::load_along("tests/data/networks/grid-signals.net.xml", &["B0B1", "B1C1"]).expect("a path");
            let signals = SignalStates::uniform(&map.network, letter);
            let guidance = PathLanes::new(&map).guidance(&map);
            Self { observer: PracticeObserver::new(&map), map, guidance, signals }
        }

        /// Returns the view of a vehicle on the path at this position and speed.
        fn view(&self, s_m: f64, speed_mps: f64) -> Snapshot {
            let (index, on_lane_m) = self.map.route.lane_at(s_m);
            let lane = self.map.route.lanes()[index].lane.expect("a lane");
            Snapshot {
                ego: EgoState { speed_mps, ..EgoState::default() },
                ego_s_m: s_m,
                ego_lane: Some(LanePosition { lane, s_m: on_lane_m, offset_m: 0.0 }),
                next_manoeuvre: self.guidance.next(&self.map, s_m),
                signals: self.signals.clone(),
                ..Snapshot::default()
            }
        }

        /// Adds a step of 0.1 s; returns the names of all skills shown so far.
        fn step(&mut self, view: &Snapshot) -> String {
            self.observer.step(view, &self.map, 0.1);
            let shown = self.observer.progress().shown;
            SKILLS.into_iter().filter(|skill| shown.contains(*skill)).map(Skill::name).collect::<Vec<_>>().join(" ")
        }
    }

    #[test]
    fn a_start_goes_from_standing_to_15_kmh() {
        let mut practice = Practice::showing(b'G');
        assert_eq!(practice.step(&practice.view(10.0, 8.0)), "", "it did not stand before");
        practice.step(&practice.view(12.0, 0.0));
        assert_eq!(practice.step(&practice.view(14.0, 4.1)), "");
        assert_eq!(practice.step(&practice.view(15.0, 4.2)), "start");
    }

    #[test]
    fn a_stop_is_at_the_line_of_a_red_signal() {
        // 69.2 m less 4 m.
        for (letter, s_m, speed_mps, shown) in [
            (b'r', 65.3, 0.0, "stop"),
            (b'r', 65.1, 0.0, ""),
            (b'r', 69.5, 0.0, ""),
            (b'r', 67.0, 1.0, ""),
            (b'G', 67.0, 0.0, ""),
        ] {
            let mut practice = Practice::showing(letter);
            assert_eq!(practice.step(&practice.view(s_m, speed_mps)), shown, "{s_m} m, {speed_mps} m/s");
        }
    }

    #[test]
    fn a_turn_is_shown_on_the_street_behind_it_unless_the_road_was_left() {
        let mut practice = Practice::showing(b'G');
        let mut shown = |s_m: f64, is_on_road: bool| {
            let view = practice.view(s_m, 5.0);
            practice.step(&Snapshot { ego_lane: view.ego_lane.filter(|_| is_on_road), ..view })
        };
        assert_eq!([shown(60.0, true), shown(72.0, true), shown(77.0, true)], ["", "", ""]);
        assert_eq!(shown(80.0, true), "turn");
        let mut practice = Practice::showing(b'G');
        let mut shown = |s_m: f64, is_on_road: bool| {
            let view = practice.view(s_m, 5.0);
            practice.step(&Snapshot { ego_lane: view.ego_lane.filter(|_| is_on_road), ..view })
        };
        assert_eq!([shown(72.0, true), shown(75.0, false), shown(80.0, true)], ["", "", ""]);
    }

    #[test]
    fn following_counts_at_one_to_four_seconds_and_above_20_kmh() {
        // At 10 m/s; ten seconds are 100 steps.
        for (gap_m, speed_mps, shown) in [(20.0, 10.0, "follow"), (9.0, 10.0, ""), (41.0, 10.0, ""), (10.0, 5.5, "")] {
            let mut practice = Practice::showing(b'G');
            let leader = Some(Leader { id: VehicleId(1), gap_m, speed_mps });
            let view = Snapshot { leader, ..practice.view(20.0, speed_mps) };
            for step in 1..100 {
                // Stretches add up.
                assert_eq!(practice.step(&view), "", "step {step}");
                practice.step(&practice.view(20.0, speed_mps));
            }
            assert_eq!(practice.step(&view), shown, "{gap_m} m, {speed_mps} m/s");
        }
    }

    #[test]
    fn skills_not_shown_are_listed_by_name() {
        let goals = PracticeGoals { skills: vec![Skill::Turn, Skill::Stop], until_in_range_s: None };
        let mut shown = ShownSkills::default();
        assert_eq!(goals.missing(shown), "turn, stop");
        let before = shown;
        [Skill::Stop, Skill::Dial].into_iter().for_each(|skill| shown.add(skill));
        assert_eq!(goals.missing(shown), "turn");
        assert_eq!(goals.shown_between(before, shown).collect::<Vec<_>>(), [Skill::Stop], "the dial is not asked for");
        assert_eq!(goals.shown_between(shown, shown).count(), 0);
    }

    #[test]
    fn leaving_the_range_resets_the_time() {
        let mut time = UnbrokenTime::default();
        // Twice 1.9 s with one step between them: 3.8 s in total, but never 2 s without a break.
        for k in 0..39 {
            time.add(k != 19, 0.1);
        }
        assert!((time.longest_s() - 1.9).abs() < 1e-9 && !time.has_reached(2.0), "{time:?}");
        time.add(true, 0.1);
        assert!(time.has_reached(2.0) && (time.now_s() - 2.0).abs() < 1e-9, "{time:?}");
        time.add(false, 0.1);
        assert!(time.has_reached(2.0) && time.now_s() == 0.0, "what was reached stays reached: {time:?}");
    }
}
