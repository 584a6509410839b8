//! The view of a drive: what is drawn of it. In: snapshots, and how far the frame is between two of them. Out: a [`View`].

use super::flash_patch::FlashTrigger;
use crate::{
    controls::Controls,
    hud::Speedometer,
    scene::{self, StaticScene, View, ViewKind, ViewOptions, view_options},
    sim::{Snapshot, World},
};

/// What is to be seen of a drive, as data.
pub struct DrivePicture {
    /// What stands still: road, land, trees, models.
    pub stage: StaticScene,
    /// Which view is on the screen.
    pub kind: ViewKind,
    options: ViewOptions,
    speedometer: Speedometer,
    flash: FlashTrigger,
    /// The square in the corner as the next frame has it.
    patch: Option<bool>,
}

impl DrivePicture {
    /// That of a drive, from the driver's seat.
    pub(super) fn new(world: &World, stage: StaticScene) -> Self {
        let scenario = world.scenario();
        Self {
            stage,
            kind: ViewKind::Driver,
            options: view_options(scenario),
            speedometer: Speedometer::new(world),
            flash: FlashTrigger::new(scenario.flash_patch),
            patch: None,
        }
    }

    /// Another drive is seen from the same view; without a stage of its own, on the same one.
    pub(super) fn restart(&mut self, world: &World, stage: Option<StaticScene>) {
        let scenario = world.scenario();
        self.options = view_options(scenario);
        self.speedometer = Speedometer::new(world);
        self.flash = FlashTrigger::new(scenario.flash_patch);
        if let Some(stage) = stage {
            self.stage = stage;
        }
    }

    /// The world has made a tick with these controls.
    pub(super) fn tick(&mut self, world: &World, controls: &Controls) {
        self.flash.tick(world, controls);
    }

    /// The view of the moment, `fraction` of a tick after the snapshot; to be asked once a picture.
    pub(super) fn view(&mut self, snapshot: &Snapshot, fraction: f32) -> View {
        let mut view = scene::view(snapshot, fraction, self.kind, &self.options, &self.stage);
        if self.kind.has_dial() {
            view.dial = Some(self.speedometer.read(snapshot));
        }
        self.patch = self.flash.frame();
        view.patch = self.patch;
        view
    }

    /// The picture has been handed to the screen. How its square was, if it has one.
    pub(super) fn shown(&mut self) -> Option<bool> {
        self.patch.take().inspect(|_| self.flash.shown())
    }

    /// The next view in the order driver, chase, bird's-eye, mirror.
    pub fn next_view(&mut self) {
        self.kind = match self.kind {
            ViewKind::Driver => ViewKind::Chase,
            ViewKind::Chase => ViewKind::Birdseye,
            ViewKind::Birdseye => ViewKind::Mirror,
            ViewKind::Mirror => ViewKind::Driver,
        };
    }
}
