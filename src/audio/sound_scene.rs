//! Audible state of the world at a tick, as plain numbers. In: the world after a tick. Out: a [`SoundScene`].

use crate::{
    controls::Controls,
    ego::GroundSurface,
    metrics::QuestionChange,
    scenario::Scenario,
    sim::{Event, EventKind, Snapshot},
    snapshot::VehicleSnapshot,
    time::Tick,
    traffic::{VehicleId, VehicleKind, gait},
};

/// Number of other vehicles that can be heard at once.
pub const NEAR: usize = 8;
/// Number of nearest vehicles and persons that get a place; one with a place keeps it while it is among the nearest [`NEAR`].
const NEAREST: usize = 6;
/// Ticks for which a place stays empty before another vehicle gets it: the old sound fades out first.
const EMPTY_TICKS: u32 = 30;
/// Difference of advised speeds below which no tone sounds, m/s: a quarter of a mile per hour.
const SAME_ADVICE_MPS: f64 = 0.11;

/// Source of the sound of another vehicle or person.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SoundSource {
    /// Engine and tyres of a motor vehicle.
    #[default]
    Motor,
    /// Footsteps of a person.
    Feet,
    /// Tyres of a bicycle.
    Bicycle,
}

impl SoundSource {
    const ALL: [Self; 3] = [Self::Motor, Self::Feet, Self::Bicycle];

    fn of(kind: VehicleKind) -> Self {
        match kind {
            VehicleKind::Pedestrian => Self::Feet,
            VehicleKind::Bicycle => Self::Bicycle,
            _ => Self::Motor,
        }
    }

    /// Returns the distance from which the source is not heard, m. Of two sources, the one at the smaller share of it counts as the nearer one.
    pub fn range_m(self) -> f64 {
        match self {
            Self::Motor => 70.0,
            Self::Feet => 20.0,
            Self::Bicycle => 35.0,
        }
    }
}

/// Another vehicle or a person, in the ego's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NearbyVehicle {
    /// Source of the sound.
    pub source: SoundSource,
    /// Distance ahead, m; negative behind.
    pub ahead_m: f32,
    /// Distance to the left, m; negative to the right.
    pub left_m: f32,
    /// Speed of the vehicle, m/s.
    pub speed_mps: f32,
    /// Number of times that a foot of a person has touched the ground since the start of their way.
    pub steps: u32,
}

impl NearbyVehicle {
    /// Number of values for the transfer to another thread.
    const WORDS: usize = 5;

    /// Returns a vehicle or person from their snapshot and the way from the ego to them, in the ego's axes.
    fn of(car: &VehicleSnapshot, ahead_m: f64, left_m: f64) -> Self {
        let source = SoundSource::of(car.body.kind);
        let cycles = if source == SoundSource::Feet { gait::cycles(car.id.0, car.odometer_m) } else { 0.0 };
        Self {
            source,
            ahead_m: ahead_m as f32,
            left_m: left_m as f32,
            speed_mps: car.speed_mps as f32,
            steps: (2.0 * cycles) as u32,
        }
    }

    fn to_words(self) -> [f32; Self::WORDS] {
        [self.ahead_m, self.left_m, self.speed_mps, f32::from(self.source as u8), self.steps as f32]
    }

    fn from_words(words: &[f32]) -> Self {
        let &[ahead_m, left_m, speed_mps, source, steps] = words else { unreachable!("five words a vehicle") };
        let source = SoundSource::ALL[(source as usize).min(2)];
        Self { source, ahead_m, left_m, speed_mps, steps: steps as u32 }
    }
}

/// All audible state at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SoundScene {
    /// True while the clock runs.
    pub running: bool,
    /// Ego speed, m/s, negative in reverse.
    pub speed_mps: f32,
    /// Engine speed, 1/min.
    pub engine_rpm: f32,
    /// Accelerator, 0 to 1: the engine's load.
    pub throttle: f32,
    /// Share of the wheels on grass, 0 to 1.
    pub grass: f32,
    /// Intensity of the rain, mm/h; 0 is dry.
    pub rain_mmph: f32,
    /// True while the horn is pressed.
    pub horn: bool,
    /// Vehicles and persons nearby; each keeps its place as long as it is heard.
    pub near: [Option<NearbyVehicle>; NEAR],
    /// Number of contacts so far.
    pub contacts: u32,
    /// Closing speed of the last contact, m/s.
    pub contact_mps: f32,
    /// Number of changes of the advised speed, if they have a tone.
    pub advices: u32,
    /// Number of questions asked so far.
    pub questions: u32,
}

/// Length of a [`SoundScene`] as a row of numbers, for the transfer to another thread.
pub(super) const WORDS: usize = SINGLE + NearbyVehicle::WORDS * NEAR;
/// Number of values that are not about another vehicle.
const SINGLE: usize = 11;

impl SoundScene {
    /// Converts the scene to a row of numbers; a place without a vehicle is NaN.
    pub(super) fn to_words(self) -> [f32; WORDS] {
        let flag = |on: bool| f32::from(u8::from(on));
        let mut words = [f32::NAN; WORDS];
        words[..SINGLE].copy_from_slice(&[
            flag(self.running),
            self.speed_mps,
            self.engine_rpm,
            self.throttle,
            self.grass,
            self.rain_mmph,
            flag(self.horn),
            self.contacts as f32,
            self.contact_mps,
            self.advices as f32,
            self.questions as f32,
        ]);
        for (words, near) in words[SINGLE..].chunks_mut(NearbyVehicle::WORDS).zip(self.near) {
            if let Some(near) = near {
                words.copy_from_slice(&near.to_words());
            }
        }
        words
    }

    /// Converts a row of numbers back to a scene.
    pub(super) fn from_words(words: &[f32; WORDS]) -> Self {
        let near = |at: usize| {
            let car = &words[SINGLE + NearbyVehicle::WORDS * at..][..NearbyVehicle::WORDS];
            let there = car.iter().all(|number| number.is_finite());
            there.then(|| NearbyVehicle::from_words(car))
        };
        Self {
            running: words[0] > 0.5,
            speed_mps: words[1],
            engine_rpm: words[2],
            throttle: words[3],
            grass: words[4],
            rain_mmph: words[5],
            horn: words[6] > 0.5,
            contacts: words[7] as u32,
            contact_mps: words[8],
            advices: words[9] as u32,
            questions: words[10] as u32,
            near: std::array::from_fn(near),
        }
    }
}

/// Collects the audible state of a drive, tick by tick.
#[derive(Clone, Debug)]
pub struct Listener {
    sound_scene: SoundScene,
    /// Vehicle in each place, or the number of ticks for which an empty place must stay empty.
    places: [Result<VehicleId, u32>; NEAR],
    advised_mps: Option<f64>,
    /// True if a change of advice has a tone.
    tone: bool,
    /// First tick of a takeover request.
    request: Option<Tick>,
}

impl Listener {
    /// Starts a drive of this scenario.
    pub fn new(scenario: &Scenario) -> Self {
        let sound_scene = SoundScene { rain_mmph: scenario.rain_mmph as f32, ..SoundScene::default() };
        Self { sound_scene, places: [Err(0); NEAR], advised_mps: None, tone: scenario.advice_tone, request: None }
    }

    /// Updates the scene after a tick with these controls.
    pub fn tick(&mut self, snapshot: &Snapshot, events: &[Event], controls: &Controls) {
        let ego = &snapshot.ego;
        let on_grass = ego.wheels.iter().filter(|wheel| wheel.surface == GroundSurface::Grass).count();
        self.sound_scene.speed_mps = ego.speed_mps as f32;
        self.sound_scene.engine_rpm = ego.engine_rpm;
        if let Some(weather) = snapshot.weather {
            self.sound_scene.rain_mmph = weather.rain_mmph as f32;
        }
        // The automation moves the pedal in the participant's place.
        self.sound_scene.throttle = snapshot.automation.driven.unwrap_or(*controls).sane().throttle;
        self.sound_scene.grass = on_grass as f32 / ego.wheels.len() as f32;
        for event in events {
            // A contact with a person ends the drive without a crash.
            if let EventKind::Contact { closing_mps, .. } | EventKind::ObjectContact { closing_mps, .. } = event.kind
                && !event.kind.touches_person()
            {
                self.sound_scene.contacts += 1;
                self.sound_scene.contact_mps = closing_mps as f32;
            }
            if matches!(event.kind, EventKind::Question { change: QuestionChange::Asked, .. }) {
                self.chime();
            }
        }
        self.hear_advice(snapshot.advice.map(|advice| advice.target_mps));
        self.hear_tones(snapshot);
        self.hear_cars(snapshot);
    }

    /// Counts a question, which has a tone.
    pub fn chime(&mut self) {
        self.sound_scene.questions += 1;
    }

    /// Plays the tones of a takeover request, again and again until the takeover, and those of events.
    fn hear_tones(&mut self, snapshot: &Snapshot) {
        let (automation, now) = (&snapshot.automation, snapshot.tick);
        self.request = automation.mode.asks().then(|| self.request.unwrap_or(now));
        let request = self.request.map(|first| (automation.series(), first));
        let of_events = snapshot.stimuli.iter().flat_map(|stimuli| stimuli.tones.iter().copied());
        let mut all = of_events.chain(request);
        if all.any(|(series, first)| series.begins_tone(now.0 - first.0)) {
            self.chime();
        }
    }

    fn hear_advice(&mut self, advised_mps: Option<f64>) {
        let changed = match (self.advised_mps, advised_mps) {
            (None, None) => false,
            (Some(before), Some(now)) => (before - now).abs() >= SAME_ADVICE_MPS,
            _ => true,
        };
        if changed {
            self.advised_mps = advised_mps;
            self.sound_scene.advices += u32::from(self.tone);
        }
    }

    /// Updates the nearest vehicles and persons. One heard before keeps its place, so that none jumps from ear to ear.
    fn hear_cars(&mut self, snapshot: &Snapshot) {
        let pose = snapshot.ego.pose();
        let heard = snapshot.cars.iter().filter_map(|car| {
            let way = car.pose.position - pose.position;
            let share = way.length() / SoundSource::of(car.body.kind).range_m();
            let near = || NearbyVehicle::of(car, way.dot(pose.forward()), way.dot(pose.left()));
            (share < 1.0).then(|| (share, car.id, near()))
        });
        let mut near: Vec<(f64, VehicleId, NearbyVehicle)> = heard.collect();
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
        self.sound_scene.near = self.places.map(|place| {
            let id = place.ok()?;
            near.iter().find(|(_, heard, _)| *heard == id).map(|(.., car)| *car)
        });
    }

    /// Returns the current scene; `running` while the clock runs, `horn` while the horn is pressed.
    pub fn scene(&self, running: bool, horn: bool) -> SoundScene {
        SoundScene { running, horn, ..self.sound_scene }
    }
}
