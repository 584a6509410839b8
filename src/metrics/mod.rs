//! Metrics of drives. In: speeds, gaps and advice at each step, of the fast ring and of whole drives alike. Out: results of a
//! drive, means with their intervals, fuel, and figures of them. SI units.

mod conflicts;
mod correlation;
mod episode_metrics;
mod estimate;
pub mod figures;
pub mod fuel;
mod motion_phases;
mod network_episode_metrics;
mod trajectories;

pub use conflicts::{Approach, ConflictTotals, Conflicts, DrivenBy};
pub use correlation::correlation;
pub use episode_metrics::{AdvisedStep, EpisodeMetrics, EpisodeStep, EvaluationResult, FlowTotals, mean_and_interval};
pub use estimate::Estimate;
pub use motion_phases::MotionTotals;
pub use network_episode_metrics::{NetworkEpisodeMetrics, NetworkFlow};
pub use trajectories::{SpeedTrace, Trajectories};
