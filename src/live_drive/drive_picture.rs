//! View of a drive. In: snapshots, and the fraction of a tick between two of them. Out: a [`View`].

use super::flash_patch::FlashTrigger;
use crate::{
    controls::Controls,
    hud::Speedometer,
    scene::{self, StaticScene, View, ViewKind, ViewOptions, view_options},
    sim::{Snapshot, World},
};

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

    /// Returns the view `fraction` of a tick after the snapshot; to be called once per picture.
    pub(super) fn view(&mut self, snapshot: &Snapshot, fraction: f32) -> View {
        let mut view = scene::view(snapshot, fraction, self.kind, &self.options, &self.static_scene);
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
