//! Flash patch in the corner of the picture. In: the world after each tick and its controls. Out: whether the next
//! frame's square is white. It is white for one frame, so that a photodiode sees an edge for each event.

use crate::{
    controls::Controls,
    scenario::FlashPatch,
    sim::{EventKind, World},
};

/// Pedal effect above which a pedal counts as pressed. It counts as released below half of that, so that the state does
/// not flicker.
const PRESSED: f32 = 0.005;

/// Detector of the events that make the square white.
#[derive(Clone, Debug, Default)]
pub struct FlashTrigger {
    on: FlashPatch,
    /// Pressed states of accelerator and brake.
    pressed: [bool; 2],
    /// Last advised target, m/s.
    advised_mps: Option<f64>,
    due: bool,
}

impl FlashTrigger {
    /// Creates the detector for a setting of the scenario.
    pub fn new(on: FlashPatch) -> Self {
        Self { on, ..Self::default() }
    }

    /// Applies a tick of the world with these controls.
    pub fn tick(&mut self, world: &World, controls: &Controls) {
        let controls = controls.sane();
        for (pressed, way) in self.pressed.iter_mut().zip([controls.throttle, controls.brake]) {
            let now = way > if *pressed { PRESSED / 2.0 } else { PRESSED };
            self.due |= self.on == FlashPatch::Pedal && now && !*pressed;
            *pressed = now;
        }
        for event in world.events() {
            if let EventKind::Advice(advice) = event.kind
                && self.advised_mps.replace(advice.target_mps) != Some(advice.target_mps)
            {
                self.due |= self.on == FlashPatch::Advice;
            }
        }
    }

    /// Returns the square of the frame that is being drawn: `None` without a square, else true for white.
    pub fn frame(&self) -> Option<bool> {
        (self.on != FlashPatch::Off).then_some(self.due)
    }

    /// Notes that the frame was handed to the screen. Until then an event stays due, so that a frame which the screen
    /// did not take does not lose the edge.
    pub fn shown(&mut self) {
        self.due = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{DisplaySettings, Scenario};
    use crate::traffic::EngineChoice;

    /// Returns the squares of frames of three ticks with these pedals.
    fn frames(on: FlashPatch, policy: &str, pedals: &[[f32; 2]]) -> Vec<Option<bool>> {
        let scenario = Scenario {
            traffic: EngineChoice::Native,
            policy: policy.into(),
            hold_s: 0.1,
            display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
            ..Scenario::default()
        };
        let mut world = World::new(&scenario).unwrap();
        let mut flash = FlashTrigger::new(on);
        let frame = |[throttle, brake]: &[f32; 2]| {
            let controls = Controls { throttle: *throttle, brake: *brake, ..Controls::default() };
            for _ in 0..3 {
                world.tick(&controls).unwrap();
                flash.tick(&world, &controls);
            }
            let white = flash.frame();
            flash.shown();
            white
        };
        pedals.iter().map(frame).collect()
    }

    #[test]
    fn pressing_a_pedal_makes_one_white_frame() {
        let pedals =
            [[0.0, 0.0], [0.0, 0.5], [0.0, 0.6], [0.0, 0.004], [0.0, 0.006], [0.0, 0.0], [0.0, 0.006], [0.3, 0.0]];
        let white = frames(FlashPatch::Pedal, "none", &pedals);
        assert_eq!(white, [false, true, false, false, false, false, true, true].map(Some));
        assert_eq!(frames(FlashPatch::Off, "none", &pedals), [None; 8]);
    }

    #[test]
    fn new_advice_makes_one_white_frame_and_repeated_advice_makes_none() {
        let white = frames(FlashPatch::Advice, "constant", &[[0.0, 0.5]; 12]);
        assert_eq!(
            white.iter().filter(|w| **w == Some(true)).count(),
            1,
            "advised at the first tick, every 0.1 s again"
        );
        assert_eq!(white[0], Some(true));
    }
}
