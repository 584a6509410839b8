//! The world at one tick, as everybody above the simulation sees it: plain data, world axes, SI.

use crate::{ego::EgoState, policy::Advice, space::Pose, time::Tick, traffic::CarId};

/// One car of the traffic at a tick, between two steps of its engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarView {
    /// Which car; never the ego.
    pub id: CarId,
    /// Pose of its centre now.
    pub pose: Pose,
    /// Pose one tick earlier, so that a frame can be drawn between the two.
    pub pose_before: Pose,
    /// Front bumper along the route, metres.
    pub s_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Acceleration, m/s2.
    pub accel_mps2: f64,
    /// Way driven since the start, metres: wheels turn by it.
    pub odometer_m: f64,
    /// True while the brake lamps are lit.
    pub braking: bool,
}

/// Everything at one tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// When.
    pub tick: Tick,
    /// The ego now.
    pub ego: EgoState,
    /// The ego one tick earlier.
    pub ego_before: EgoState,
    /// Ego's front bumper along the route, metres.
    pub ego_s_m: f64,
    /// Ego's lateral offset from the lane's centre line, metres, positive to the left.
    pub lane_offset_m: f64,
    /// All other cars, by ascending id.
    pub cars: Vec<CarView>,
    /// The leader: its id, the gap in metres (bumper to bumper) and its speed in m/s. `None` if the ego is alone.
    pub leader: Option<Leader>,
    /// Advice that stands now.
    pub advice: Option<Advice>,
    /// Mean speed of all vehicles, the ego included, m/s (HC22's measure).
    pub mean_speed_mps: f64,
}

/// The car ahead in the lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leader {
    /// Which car.
    pub id: CarId,
    /// Own front bumper to its rear bumper, metres.
    pub gap_m: f64,
    /// Its speed, m/s.
    pub speed_mps: f64,
}
