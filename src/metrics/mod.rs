//! Metrics of drives. In: speeds, gaps and advice at each step, of the fast ring and of whole drives alike. Out: results of a
//! drive, means with their intervals, fuel, and figures of them. SI units. [`registry`] defines every measure; [`TickTotals`] and
//! [`TrafficTotals`] sum up drives for all of them; [`waves`] and [`traffic_moments`] describe how vehicles follow each other.

mod conflicts;
mod correlation;
mod distribution;
mod episode_metrics;
mod estimate;
mod evaluated;
pub mod figures;
pub mod fuel;
mod motion_phases;
mod questions;
pub mod registry;
mod secondary_task;
mod takeover;
mod tick_totals;
pub mod traffic_moments;
mod traffic_totals;
mod trajectories;
pub mod waves;

pub use conflicts::{Approach, ConflictTotals, Conflicts, DrivenBy};
pub use correlation::correlation;
pub use episode_metrics::{AdvisedStep, EpisodeMetrics, EpisodeStep, EvaluationResult, NetworkFlow, mean_and_interval};
pub use estimate::Estimate;
pub use evaluated::{EVALUATED, EvaluatedValue, evaluated};
pub use questions::{QuestionChange, QuestionScore};
pub use registry::{Measure, MeasuredOn, RoadKinds, measure};
pub use secondary_task::{FIRST_HIT_S, TaskLog, TaskResponse, TaskScores, TaskStimulus};
pub use takeover::{
    AFTER_TAKEOVER_S, AutomationChange, GazeSample, SwitchedOffBy, SwitchedOnBy, TakeoverInput, TakeoverLog,
    TakeoverScores, eyes_on_road_s,
};
pub use tick_totals::{RunningMean, RunningMinimum, TickTotals};
pub use traffic_totals::TrafficTotals;
pub use trajectories::{SpeedTrace, Trajectories};
