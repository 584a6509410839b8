//! What there is to be heard at a tick, as plain numbers. In: the world after a tick. Out: a [`SoundScene`].

use crate::{
    controls::Controls,
    ego::GroundSurface,
    sim::{Event, EventKind, Snapshot},
    traffic::VehicleId,
};

/// Places for other cars that are heard.
pub const NEAR: usize = 8;
/// So many of the nearest cars get a place; one that has one keeps it while it is among the nearest [`NEAR`].
const NEAREST: usize = 6;
/// A place stays empty for so many ticks before another car gets it: it fades out first.
const EMPTY_TICKS: u32 = 30;
/// A car further away than this is not heard, metres.
const FAR_M: f64 = 70.0;
/// Advised speeds that differ by less are the same advice to the ear, m/s: a quarter of a mile an hour.
const SAME_ADVICE_MPS: f64 = 0.11;

/// Another car, in the own car's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NearbyVehicle {
    /// How far ahead, metres; behind is negative.
    pub ahead_m: f32,
    /// How far to the left, metres.
    pub left_m: f32,
    /// Its speed, m/s.
    pub speed_mps: f32,
}

/// All that is heard.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SoundScene {
    /// True while time runs.
    pub running: bool,
    /// Own speed, m/s, negative in reverse.
    pub speed_mps: f32,
    /// Engine speed, 1/min.
    pub engine_rpm: f32,
    /// Accelerator, 0..1: the engine's load.
    pub throttle: f32,
    /// Share of the wheels on grass.
    pub grass: f32,
    /// A hand is on the horn.
    pub horn: bool,
    /// Cars near by; each keeps its place for as long as it is heard.
    pub near: [Option<NearbyVehicle>; NEAR],
    /// How many contacts there have been, and closing speed of the last, m/s.
    pub contacts: u32,
    /// See `contacts`.
    pub contact_mps: f32,
    /// How often another speed has been advised, where that is to be heard.
    pub advices: u32,
    /// How often something was asked.
    pub questions: u32,
}

/// Numbers in a [`SoundScene`] written as words for the hand-over to another thread.
pub(super) const WORDS: usize = SINGLE + 3 * NEAR;
/// Those that are not about another car.
const SINGLE: usize = 10;

impl SoundScene {
    /// As numbers in a row; a place without a car has no number.
    pub(super) fn to_words(self) -> [f32; WORDS] {
        let flag = |on: bool| f32::from(u8::from(on));
        let mut words = [f32::NAN; WORDS];
        words[..SINGLE].copy_from_slice(&[
            flag(self.running),
            self.speed_mps,
            self.engine_rpm,
            self.throttle,
            self.grass,
            flag(self.horn),
            self.contacts as f32,
            self.contact_mps,
            self.advices as f32,
            self.questions as f32,
        ]);
        for (words, near) in words[SINGLE..].chunks_mut(3).zip(self.near) {
            if let Some(near) = near {
                words.copy_from_slice(&[near.ahead_m, near.left_m, near.speed_mps]);
            }
        }
        words
    }

    /// Back from numbers in a row.
    pub(super) fn from_words(words: &[f32; WORDS]) -> Self {
        let near = |at: usize| {
            let car = &words[SINGLE + 3 * at..][..3];
            let there = car.iter().all(|number| number.is_finite());
            there.then(|| NearbyVehicle { ahead_m: car[0], left_m: car[1], speed_mps: car[2] })
        };
        Self {
            running: words[0] > 0.5,
            speed_mps: words[1],
            engine_rpm: words[2],
            throttle: words[3],
            grass: words[4],
            horn: words[5] > 0.5,
            contacts: words[6] as u32,
            contact_mps: words[7],
            advices: words[8] as u32,
            questions: words[9] as u32,
            near: std::array::from_fn(near),
        }
    }
}

/// Collects what is audible of a drive, tick by tick.
#[derive(Clone, Debug)]
pub struct Listener {
    hear: SoundScene,
    /// Whose places these are, and of an empty one for how many ticks it must stay so.
    places: [Result<VehicleId, u32>; NEAR],
    advised_mps: Option<f64>,
    /// True if a changed advice has a tone.
    tone: bool,
}

impl Listener {
    /// At the start of a drive; `tone` as the scenario has it.
    pub fn new(tone: bool) -> Self {
        Self { hear: SoundScene::default(), places: [Err(0); NEAR], advised_mps: None, tone }
    }

    /// After a tick that was driven with these controls.
    pub fn tick(&mut self, snapshot: &Snapshot, events: &[Event], controls: &Controls) {
        let ego = &snapshot.ego;
        let on_grass = ego.wheels.iter().filter(|wheel| wheel.surface == GroundSurface::Grass).count();
        self.hear.speed_mps = ego.speed_mps as f32;
        self.hear.engine_rpm = ego.engine_rpm;
        self.hear.throttle = controls.sane().throttle;
        self.hear.grass = on_grass as f32 / ego.wheels.len() as f32;
        for event in events {
            if let EventKind::Contact { closing_mps, .. } = event.kind {
                self.hear.contacts += 1;
                self.hear.contact_mps = closing_mps as f32;
            }
        }
        self.hear_advice(snapshot.advice.map(|advice| advice.target_mps));
        self.hear_cars(snapshot);
    }

    /// Something is asked.
    pub fn chime(&mut self) {
        self.hear.questions += 1;
    }

    fn hear_advice(&mut self, advised_mps: Option<f64>) {
        let changed = match (self.advised_mps, advised_mps) {
            (None, None) => false,
            (Some(before), Some(now)) => (before - now).abs() >= SAME_ADVICE_MPS,
            _ => true,
        };
        if changed {
            self.advised_mps = advised_mps;
            self.hear.advices += u32::from(self.tone);
        }
    }

    /// The nearest cars. One that was heard before keeps its place, so that no car jumps from ear to ear.
    fn hear_cars(&mut self, snapshot: &Snapshot) {
        let pose = snapshot.ego.pose();
        let mut near: Vec<(f64, VehicleId, NearbyVehicle)> = snapshot
            .cars
            .iter()
            .filter_map(|car| {
                let way = car.pose.position - pose.position;
                let place = NearbyVehicle {
                    ahead_m: way.dot(pose.forward()) as f32,
                    left_m: way.dot(pose.left()) as f32,
                    speed_mps: car.speed_mps as f32,
                };
                (way.length() < FAR_M).then_some((way.length(), car.id, place))
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.truncate(NEAR);
        for place in &mut self.places {
            *place = match *place {
                Ok(id) if near.iter().any(|(_, heard, _)| *heard == id) => Ok(id),
                Ok(_) => Err(EMPTY_TICKS),
                Err(ticks) => Err(ticks.saturating_sub(1)),
            };
        }
        for (_, id, _) in near.iter().take(NEAREST) {
            if !self.places.contains(&Ok(*id))
                && let Some(free) = self.places.iter_mut().find(|place| **place == Err(0))
            {
                *free = Ok(*id);
            }
        }
        self.hear.near = self.places.map(|place| {
            let id = place.ok()?;
            near.iter().find(|(_, heard, _)| *heard == id).map(|(.., car)| *car)
        });
    }

    /// What is to be heard now; `running` while time goes on, `horn` while a hand is on it.
    pub fn scene(&self, running: bool, horn: bool) -> SoundScene {
        SoundScene { running, horn, ..self.hear }
    }
}
