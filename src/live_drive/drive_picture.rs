//! View of a drive. In: snapshots, the fraction of a tick between two of them, the jolt of a contact. Out: a [`View`].

use super::{contacts::Jolt, flash_patch::FlashTrigger};
use crate::{
    controls::Controls,
    hud::Speedometer,
    scene::{self, Camera, StaticScene, View, ViewKind, ViewOptions, view_options},
    sim::{Snapshot, World},
};
use glam::Quat;
use std::f32::consts::TAU;

/// Largest movement of the driver's eye in a contact, up and down, m, and its frequency, Hz.
const SHAKE_M: f32 = 0.04;
const SHAKE_HZ: f32 = 9.0;
/// Largest nod of the driver's view in a contact, rad (1.1 degrees), and its frequency, Hz.
const NOD_RAD: f32 = 0.02;
const NOD_HZ: f32 = 7.0;

/// Picture of a drive, as data.
pub struct DrivePicture {
    /// Static scene: road, land, trees, models.
    pub static_scene: StaticScene,
    /// View on the screen.
    pub kind: ViewKind,
    options: ViewOptions,
    speedometer: Speedometer,
    flash: FlashTrigger,
    /// State of the flash patch in the next frame.
    patch: Option<bool>,
}

impl DrivePicture {
    /// Makes the picture of a drive, from the driver's seat.
    pub(super) fn new(world: &World, static_scene: StaticScene) -> Self {
        let scenario = world.scenario();
        Self {
            static_scene,
            kind: ViewKind::Driver,
            options: view_options(scenario),
            speedometer: Speedometer::new(world),
            flash: FlashTrigger::new(scenario.flash_patch),
            patch: None,
        }
    }

    /// Shows another drive in the same view; without a static scene of its own, on the present one.
    pub(super) fn restart(&mut self, world: &World, static_scene: Option<StaticScene>) {
        let scenario = world.scenario();
        self.options = view_options(scenario);
        self.speedometer = Speedometer::new(world);
        self.flash = FlashTrigger::new(scenario.flash_patch);
        if let Some(static_scene) = static_scene {
            self.static_scene = static_scene;
        }
    }

    /// Applies a tick of the world with these controls.
    pub(super) fn tick(&mut self, world: &World, controls: &Controls) {
        self.flash.tick(world, controls);
    }

    /// Returns the view `fraction` of a tick after the snapshot; to be called once per picture. A contact shakes the
    /// driver's view of the road; nothing of it is recorded.
    pub(super) fn view(&mut self, snapshot: &Snapshot, fraction: f32, jolt: Jolt) -> View {
        let mut view = scene::view(snapshot, fraction, self.kind, &self.options, &self.static_scene);
        if self.kind == ViewKind::Driver {
            view.camera = shaken(view.camera, jolt);
        }
        if self.kind.has_dial() {
            view.dial = Some(self.speedometer.read(snapshot));
        }
        self.patch = self.flash.frame();
        view.patch = self.patch;
        view
    }

    /// Notes that the picture was handed to the screen. Returns the state of its flash patch, if it has one.
    pub(super) fn shown(&mut self) -> Option<bool> {
        self.patch.take().inspect(|_| self.flash.shown())
    }

    /// Switches to the next view in the order driver, chase, bird's-eye, mirror.
    pub fn next_view(&mut self) {
        self.kind = match self.kind {
            ViewKind::Driver => ViewKind::Chase,
            ViewKind::Chase => ViewKind::Birdseye,
            ViewKind::Birdseye => ViewKind::Mirror,
            ViewKind::Mirror => ViewKind::Driver,
        };
    }
}

/// Returns a camera as a contact shakes it.
fn shaken(camera: Camera, jolt: Jolt) -> Camera {
    let (strength, since_s) = (jolt.strength as f32, jolt.since_s as f32);
    let swing = |hz: f32| strength * (TAU * hz * since_s).sin();
    let nod = Quat::from_axis_angle(camera.forward.cross(camera.up).normalize(), NOD_RAD * swing(NOD_HZ));
    let eye = camera.eye + camera.up * (SHAKE_M * swing(SHAKE_HZ));
    Camera { eye, forward: nod * camera.forward, up: nod * camera.up, ..camera }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Lens;
    use glam::Vec3;

    #[test]
    fn a_contact_moves_the_eye_by_centimetres_and_then_no_more() {
        let lens = Lens::Perspective { fov_x_rad: 1.1 };
        let still = Camera { eye: Vec3::new(3.0, 5.0, 1.2), forward: Vec3::X, up: Vec3::Z, lens };
        let after = |strength, since_s| shaken(still, Jolt { strength, since_s });
        let jolted = after(0.8, 1.0 / 36.0);
        let (moved_m, turned_rad) = (jolted.eye.distance(still.eye), jolted.forward.angle_between(still.forward));
        assert!(
            (0.02..0.05).contains(&moved_m) && (0.005..0.03).contains(&turned_rad),
            "{moved_m} m, {turned_rad} rad"
        );
        assert_eq!(shaken(still, Jolt::default()), still);
    }
}
