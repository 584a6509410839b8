//! Measures of one hold of an episode, over all its vehicles. In: the speeds of the vehicles at each step. Out: a value for each of
//! [`HOLD_MEASURES`], by the definitions of evaluations, as if the hold were a drive of its own.

use crate::{
    metrics::{Measure, TrafficTotals, measure},
    sim::Snapshot,
};

/// Measures of a hold, in the order of [`HoldMeasures::values`].
pub const HOLD_MEASURES: [Measure; 10] = [
    measure("mean_speed_mps"),
    measure("space_mean_speed_mps"),
    measure("speed_sd_over_vehicles_mps"),
    measure("speed_sd_over_time_mps"),
    measure("fuel_l_100km"),
    measure("stops_per_km"),
    measure("hard_brakings_per_km"),
    measure("inflow_per_h"),
    measure("outflow_per_h"),
    measure("vehicles_present"),
];

/// Sums over the steps of a hold.
#[derive(Clone, Debug)]
pub struct HoldMeasures {
    totals: TrafficTotals,
    sum_of_means_mps: f64,
    vehicles_at_start: usize,
}

impl HoldMeasures {
    /// Starts a hold with steps of `step_s` at the present snapshot.
    pub fn begin(step_s: f64, now: &Snapshot) -> Self {
        let mut totals = TrafficTotals::new(step_s);
        totals.start(now.numbered_speeds_mps());
        Self { vehicles_at_start: totals.present(), totals, sum_of_means_mps: 0.0 }
    }

    /// Adds a step by the snapshot at its end.
    pub fn add(&mut self, now: &Snapshot) {
        self.totals.add(now.numbered_speeds_mps());
        self.sum_of_means_mps += now.mean_speed_mps;
    }

    /// Adds steps in which all vehicles stand, up to this number of steps.
    pub fn stand_until(&mut self, steps: u64) {
        (self.totals.steps()..steps).for_each(|_| self.totals.add_standing());
    }

    /// Returns the values; NaN for fuel if no vehicle has moved.
    pub fn values(&self) -> [f64; HOLD_MEASURES.len()] {
        let totals = &self.totals;
        let steps = totals.steps().max(1) as f64;
        let per_h = |vehicles: usize| vehicles as f64 * 3600.0 / (steps * totals.step_s());
        [
            self.sum_of_means_mps / steps,
            totals.space_mean_speed_mps().unwrap_or(0.0),
            totals.speed_sd_over_vehicles_mps(),
            totals.speed_sd_over_time_mps(),
            totals.fuel_l_100km().unwrap_or(f64::NAN),
            totals.per_km(totals.stops),
            totals.per_km(totals.hard_brakings),
            per_h(totals.vehicles() - self.vehicles_at_start),
            per_h(totals.vehicles() - totals.present()),
            totals.mean_present(),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        sim::VehicleSnapshot,
        traffic::{VehicleBody, VehicleId},
    };

    /// Returns all vehicles of a drive without a participant, by numbers and speeds.
    fn road(speeds: &[(u32, f64)]) -> Snapshot {
        let car = |(id, speed_mps): &(u32, f64)| VehicleSnapshot {
            id: VehicleId(*id),
            speed_mps: *speed_mps,
            body: VehicleBody::CAR,
            ..VehicleSnapshot::default()
        };
        let mean_speed_mps = speeds.iter().map(|(_, speed_mps)| speed_mps).sum::<f64>() / speeds.len().max(1) as f64;
        Snapshot { is_without_ego: true, cars: speeds.iter().map(car).collect(), mean_speed_mps, ..Snapshot::default() }
    }

    #[test]
    fn a_hold_of_two_steps_has_the_values_of_a_hand_count() {
        let mut hold = HoldMeasures::begin(0.5, &road(&[(1, 4.0)]));
        hold.add(&road(&[(1, 4.0), (2, 8.0)]));
        hold.add(&road(&[(2, 0.0)]));
        let values = hold.values();
        let of = |name: &str| values[HOLD_MEASURES.iter().position(|measure| measure.name == name).expect(name)];
        // Means of the steps: 6 and 0. 4, 8 and 0 m/s over three vehicles and steps. Deviations over vehicles: 2 and 0.
        assert_eq!(
            [of("mean_speed_mps"), of("space_mean_speed_mps"), of("speed_sd_over_vehicles_mps")],
            [3.0, 4.0, 1.0]
        );
        // Vehicle 1: 0; vehicle 2 at 8 and 0: 4.
        assert_eq!(of("speed_sd_over_time_mps"), 2.0);
        // One vehicle entered and one left within 1 s; three vehicles and steps in two steps.
        assert_eq!([of("inflow_per_h"), of("outflow_per_h"), of("vehicles_present")], [3600.0, 3600.0, 1.5]);
        // One stop and one hard braking in (4 + 8) m/s times 0.5 s = 6 m.
        assert!(
            (of("stops_per_km") - 1000.0 / 6.0).abs() < 1e-9
                && (of("hard_brakings_per_km") - 1000.0 / 6.0).abs() < 1e-9
        );
    }

    #[test]
    fn after_a_crash_all_stand_for_the_rest_of_the_hold() {
        let mut hold = HoldMeasures::begin(0.5, &road(&[(1, 4.0)]));
        hold.add(&road(&[(1, 4.0)]));
        hold.stand_until(4);
        let values = hold.values();
        assert_eq!([values[0], values[1]], [1.0, 1.0]);
    }
}
