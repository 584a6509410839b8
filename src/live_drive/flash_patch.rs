//! The flash patch: when the square in the corner is white. In: the world after each tick and the controls that it used.
//! Out: whether the next frame's square is white. One frame, so that a photodiode sees an edge for each event.

use crate::{
    controls::Controls,
    scenario::FlashPatch,
    sim::{EventKind, World},
};

/// A pedal with more effect than this has left its rest (which is exactly 0), and one with less than half of it is back: no
/// flicker between.
const PRESSED: f32 = 0.005;

/// Watches for what makes the square white.
#[derive(Clone, Debug, Default)]
pub struct FlashTrigger {
    on: FlashPatch,
    /// Whether a foot is on accelerator and brake.
    pressed: [bool; 2],
    /// Target that was advised last, m/s.
    advised_mps: Option<f64>,
    due: bool,
}

impl FlashTrigger {
    /// As the scenario has it.
    pub fn new(on: FlashPatch) -> Self {
        Self { on, ..Self::default() }
    }

    /// The world has made a tick with these controls.
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

    /// Of the frame that is drawn now: `None` without a square, else whether it is white.
    pub fn frame(&self) -> Option<bool> {
        (self.on != FlashPatch::Off).then_some(self.due)
    }

    /// That frame has been handed to the screen. Until then what is due stays due: a frame that the screen did not take would
    /// swallow the edge.
    pub fn shown(&mut self) {
        self.due = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{DisplaySettings, Scenario};
    use crate::traffic::EngineChoice;

    /// Frames of three ticks with these pedals: which are white.
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
    fn a_pedal_that_leaves_its_rest_is_one_white_frame() {
        let pedals =
            [[0.0, 0.0], [0.0, 0.5], [0.0, 0.6], [0.0, 0.004], [0.0, 0.006], [0.0, 0.0], [0.0, 0.006], [0.3, 0.0]];
        let white = frames(FlashPatch::Pedal, "none", &pedals);
        assert_eq!(white, [false, true, false, false, false, false, true, true].map(Some));
        assert_eq!(frames(FlashPatch::Off, "none", &pedals), [None; 8]);
    }

    #[test]
    fn another_advice_is_one_white_frame_and_the_same_again_is_none() {
        let white = frames(FlashPatch::Advice, "constant", &[[0.0, 0.5]; 12]);
        assert_eq!(
            white.iter().filter(|w| **w == Some(true)).count(),
            1,
            "advised at the first tick, every 0.1 s again"
        );
        assert_eq!(white[0], Some(true));
    }
}
