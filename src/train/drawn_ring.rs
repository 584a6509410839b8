//! Random rings for training and evaluation. In: a configuration and the random numbers of an episode. Out: the layout and the models of
//! a ring's vehicles.

use super::{
    config::{RingConfig, TrainConfig},
    ring::RingStart,
    simd::LANES,
};
use crate::{
    idm::IdmParams,
    rng::{self, Stream},
    space::CAR_LENGTH_M,
    traffic::{CarFollowing, TrafficDriver, TrafficDrivers},
};

/// Length of a truck, m, and its acceleration as a share of a car's: 7.1 m, and 1.3 of 2.6 m/s² (docs/references.md: trucks).
pub const TRUCK_LENGTH_M: f64 = 7.1;
const TRUCK_ACCEL_SHARE: f64 = 0.5;

/// Returns the model and the equilibrium gap, m, of ring `ring` in [`super::evaluate()`] with the same arguments.
pub fn drawn_ring(config: &TrainConfig, stream: &str, ring: usize) -> (CarFollowing, f64) {
    let mut stream = episode_stream(config.seed, stream, ring as u64);
    let config = config.of_block(ring / LANES);
    let drawn = draw_ring(&config, &config.ring.traffic_drivers()[0], &mut stream);
    (drawn.start.driver.model, drawn.even_gap_m)
}

/// Returns the random stream of one episode.
pub fn episode_stream(seed: u64, stream: &str, number: u64) -> Stream {
    rng::stream(seed, &format!("{stream}/episode/{number}"))
}

/// A ring drawn at random.
pub struct DrawnRing {
    /// Gaps and models of the vehicles.
    pub start: RingStart,
    /// Length of the ring, m.
    pub length_m: f64,
    /// Gap of each vehicle at equilibrium, m.
    pub even_gap_m: f64,
}

impl RingConfig {
    /// Returns the names of the populations of drivers.
    pub fn populations(&self) -> impl Iterator<Item = &str> {
        self.traffic_drivers.split(',').map(str::trim)
    }

    /// Returns the share of advised vehicles as the file of a policy states it: 0 for one vehicle.
    pub fn advised_share(&self) -> f64 {
        let share = self.advised.share_of(self.vehicles_max);
        if self.advised.of(self.vehicles_max) == 1 { 0.0 } else { share }
    }

    /// Returns the slots of the advised vehicles, counted backwards from the ego, the ego first; evenly spread as in drives.
    pub fn advised_slots(&self) -> impl Iterator<Item = usize> {
        std::iter::once(0).chain(self.advised.others(self.vehicles_max).map(|slot| slot as usize))
    }

    /// Returns the drivers of the other vehicles, one population for each block of rings in turn.
    ///
    /// # Panics
    /// Panics if a population cannot be loaded; a checked configuration has those that can.
    pub fn traffic_drivers(&self) -> Vec<TrafficDrivers> {
        let named = |name| TrafficDrivers::named(name, self.idm).expect("the population of a checked configuration");
        self.populations().map(named).collect()
    }
}

/// Draws a ring from the configuration, and its drivers from these.
pub fn draw_ring(config: &TrainConfig, drivers: &TrafficDrivers, stream: &mut Stream) -> DrawnRing {
    let rings = &config.ring;
    let span = (rings.vehicles_max - rings.vehicles_min + 1) as usize;
    let cars = rings.vehicles_min as usize + stream.index(span);
    let drawn_m = stream.uniform(rings.circumference_min_m, rings.circumference_max_m);
    // Nothing can be learned on a ring where the policy withholds advice.
    let length_m = drawn_m.max(cars as f64 * rings.least_spacing_m);
    let idm = vary(&rings.idm, rings.idm_spread, stream);
    let layout = if stream.uniform(0.0, 1.0) < rings.bunched_share { RingStart::bunched } else { RingStart::even };
    let seed = (stream.uniform(0.0, 1.0) * 9.0e15) as u64;
    let (own_drivers, trucks) = match drivers {
        TrafficDrivers::Alike(_) => draw_cars(rings, &idm, cars, stream),
        TrafficDrivers::People(_) => (drivers.drivers(seed, cars), 0),
    };
    // The layouts assume cars only, so the extra length of trucks is subtracted from the road.
    let room_m = length_m - trucks as f64 * (TRUCK_LENGTH_M - CAR_LENGTH_M);
    let even_gap_m = room_m / cars as f64 - CAR_LENGTH_M;
    let start = RingStart { own_drivers, ..layout(cars, room_m, idm, seed) };
    let driver = if drivers.are_alike() { start.driver } else { drivers.typical() };
    DrawnRing { start: RingStart { driver, ..start }, length_m, even_gap_m }
}

/// Draws the model of each vehicle, the ego first, and counts the trucks. Advised vehicles are cars with the ring's own model. The list is
/// empty if vehicles do not differ.
fn draw_cars(rings: &RingConfig, idm: &IdmParams, cars: usize, stream: &mut Stream) -> (Vec<TrafficDriver>, usize) {
    if rings.car_spread == 0.0 && rings.truck_share == 0.0 {
        return (Vec::new(), 0);
    }
    let (mut own_drivers, mut trucks) = (vec![TrafficDriver::of_ring_study(*idm)], 0);
    for slot in 1..cars {
        let mut own = vary(idm, rings.car_spread, stream);
        let is_truck = stream.uniform(0.0, 1.0) < rings.truck_share;
        if rings.advised_slots().any(|advised| advised == slot) {
            own = *idm;
        } else if is_truck {
            own.a *= TRUCK_ACCEL_SHARE;
            trucks += 1;
        }
        own_drivers.push(TrafficDriver::of_ring_study(own));
    }
    (own_drivers, trucks)
}

/// Draws a model whose parameters deviate by at most the share `spread` in either direction.
fn vary(idm: &IdmParams, spread: f64, stream: &mut Stream) -> IdmParams {
    let mut vary = |x: f64| x * (1.0 + spread * stream.uniform(-1.0, 1.0));
    IdmParams {
        v0: vary(idm.v0),
        t: vary(idm.t),
        a: vary(idm.a),
        b: vary(idm.b),
        s0: vary(idm.s0),
        noise: vary(idm.noise),
        delta: idm.delta,
    }
}
