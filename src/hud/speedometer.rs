//! From the world to the speedometer: the scale of the scenario, the steadied number. In: a snapshot a frame. Out: a
//! [`DialView`].

use super::{DialView, NumberFilter, SpeedometerScale};
use crate::{
    hud,
    sim::{Snapshot, World},
    units::SpeedUnit,
};

/// What the speedometer keeps from frame to frame.
#[derive(Clone, Debug)]
pub struct Speedometer {
    unit: SpeedUnit,
    scale: SpeedometerScale,
    filter: NumberFilter,
}

impl Speedometer {
    /// The speedometer of this drive; its scale stays as it is to the end.
    pub fn new(world: &World) -> Self {
        Self { unit: world.scenario().display.units, scale: Self::scale(world), filter: NumberFilter::default() }
    }

    /// The scale that the scenario names, or one that suits the drive.
    pub fn scale(world: &World) -> SpeedometerScale {
        let (scenario, expected) = (world.scenario(), world.expected_speeds());
        if scenario.display.dial_full > 0.0 {
            return SpeedometerScale::up_to(scenario.display.dial_full);
        }
        let top_mps = hud::expected_top_mps(expected.equilibrium_mps, expected.advised_mps, expected.limit_mps);
        DialView::scale_for(top_mps, scenario.display.units)
    }

    /// The dial at this frame.
    pub fn read(&mut self, snapshot: &Snapshot) -> DialView {
        let advice = snapshot.advice.map(|advice| {
            let (low, high) = advice.band_mps();
            (advice.target_mps, low, high)
        });
        let reverse = snapshot.ego.gear < 0;
        DialView::new(snapshot.ego.speed_mps, advice, self.unit, self.scale, reverse)
            .indicating(snapshot.ego_indicator.lit_at(snapshot.tick.seconds()))
            .steadied(&mut self.filter)
    }
}
