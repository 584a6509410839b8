//! Decisions of drivers on networks. In: the lanes and lines of a route, and the [`Snapshot`](crate::snapshot::Snapshot) of a tick. Out:
//! where a driver waits for others ([`RightOfWay`]), when and along which line they change lanes ([`LaneChanging`]), and which vehicles
//! they see in the lane beside ([`lane_beside()`]). Metres, m/s.

mod lane_beside;
mod lane_change;
mod right_of_way;

pub use lane_beside::{lane_beside, lanes_beside};
pub use lane_change::LaneChanging;
pub use right_of_way::RightOfWay;
