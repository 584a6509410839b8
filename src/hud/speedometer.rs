//! From the world to the speedometer: the scale of the scenario, the steadied number. In: a snapshot per frame. Out: a
//! [`DialView`].

use super::{DialView, NumberFilter, SpeedometerScale};
use crate::{
    hud,
    scenario::GuidanceView,
    sim::{Snapshot, World},
    units::SpeedUnit,
};

/// State of the speedometer between frames.
#[derive(Clone, Debug)]
pub struct Speedometer {
    unit: SpeedUnit,
    scale: SpeedometerScale,
    /// True if the dial guides to the next manoeuvre.
    guides: bool,
    filter: NumberFilter,
}

impl Speedometer {
    /// Creates the speedometer of this drive; its scale does not change during the drive.
    pub fn new(world: &World) -> Self {
        let display = &world.scenario().display;
        Self {
            unit: display.units,
            scale: Self::scale(world),
            guides: display.guidance != GuidanceView::Off,
            filter: NumberFilter::default(),
        }
    }

    /// Returns the scale given by the scenario, or one that suits the drive.
    pub fn scale(world: &World) -> SpeedometerScale {
        let (scenario, expected) = (world.scenario(), world.expected_speeds());
        if scenario.display.dial_full > 0.0 {
            return SpeedometerScale::up_to(scenario.display.dial_full);
        }
        let top_mps = hud::expected_top_mps(expected.equilibrium_mps, expected.advised_mps, expected.limit_mps);
        DialView::scale_for(top_mps, scenario.display.units)
    }

    /// Returns the dial for this frame.
    pub fn read(&mut self, snapshot: &Snapshot) -> DialView {
        let advice = snapshot.advice.map(|advice| {
            let (low, high) = advice.band_mps();
            (advice.target_mps, low, high)
        });
        let reverse = snapshot.ego.gear < 0;
        DialView::new(snapshot.ego.speed_mps, advice, self.unit, self.scale, reverse)
            .indicating(snapshot.ego_indicator.lit_at(snapshot.tick.seconds()))
            .with_main_beam(snapshot.ego_main_beam)
            .guiding(snapshot.next_manoeuvre.filter(|_| self.guides))
            .with_pictogram(snapshot.stimuli.as_ref().and_then(|stimuli| stimuli.pictogram))
            .saying(snapshot.message.clone())
            .asking(snapshot.question.clone())
            .automated(&snapshot.automation, snapshot.tick.seconds())
            .steadied(&mut self.filter)
    }
}
