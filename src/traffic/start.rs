//! Initial layouts on a closed route, and checks of a setup before an engine starts. In: number of vehicles, length of the route, gap at a
//! standstill, speed. Out: [`InitialVehicle`]s, or the fault and the allowed values. Metres, m/s.

use super::{FixedSetup, FollowingModel, InitialVehicle, TrafficDrivers, TrafficError, crossings::overlapping};
use crate::{idm::IdmParams, space::CAR_LENGTH_M};

/// Share of the route that [`bunched`] leaves empty: 50 m of the 250 m ring (docs/references.md: ring).
const HOLE_SHARE: f64 = 0.2;

/// Returns `n` vehicles evenly spaced over `length_m`, the ego at 0, all at `speed_mps`; `s0_m` is the model's gap at a standstill.
///
/// # Errors
/// [`TrafficError::Setup`] if there are fewer than 2 vehicles or more than fit.
pub fn even(n: usize, length_m: f64, s0_m: f64, speed_mps: f64) -> Result<Vec<InitialVehicle>, TrafficError> {
    check_count(n, length_m, s0_m)?;
    let spacing_m = length_m / n as f64;
    Ok((0..n).map(|i| InitialVehicle { s_m: i as f64 * spacing_m, speed_mps }).collect())
}

/// Returns `n` vehicles close together with one hole of a fifth of the route, half-way round from the ego: a wave forms within 75 s
/// (docs/references.md: ring). With many vehicles the hole is smaller, so that no gap is below `s0_m`.
///
/// # Errors
/// As [`even`].
pub fn bunched(n: usize, length_m: f64, s0_m: f64, speed_mps: f64) -> Result<Vec<InitialVehicle>, TrafficError> {
    check_count(n, length_m, s0_m)?;
    let spacing_m = bunch_spacing_m(n, length_m, s0_m);
    let hole_m = length_m - spacing_m * n as f64;
    let place = |i: usize| i as f64 * spacing_m + if i > n / 2 { hole_m } else { 0.0 };
    Ok((0..n).map(|i| InitialVehicle { s_m: place(i), speed_mps }).collect())
}

/// Returns the spacing of the vehicles in a bunch, front to front, metres. The rest of `length_m` is the hole.
pub fn bunch_spacing_m(n: usize, length_m: f64, s0_m: f64) -> f64 {
    (length_m * (1.0 - HOLE_SHARE) / n as f64).max(CAR_LENGTH_M + s0_m)
}

fn check_count(n: usize, length_m: f64, s0_m: f64) -> Result<(), TrafficError> {
    let most = (length_m / (CAR_LENGTH_M + s0_m)).floor();
    if n < 2 {
        let cars = if n == 1 { "1 vehicle is" } else { "0 vehicles are" };
        return Err(TrafficError::Setup(format!(
            "{cars} too few; allowed: 2 to {most}, the ego and at least one other vehicle"
        )));
    }
    if n as f64 > most {
        return Err(TrafficError::Setup(format!(
            "{n} vehicles do not fit on {length_m:.0} m: at most {most}\n  remedy: choose fewer vehicles, or a map \
             with a longer route"
        )));
    }
    Ok(())
}

/// Checks the parameters of a model that no file's limits have bounded.
fn check_idm(idm: &IdmParams) -> Result<(), TrafficError> {
    let positive = [("v0", idm.v0), ("T", idm.t), ("a", idm.a), ("b", idm.b), ("delta", idm.delta), ("s0", idm.s0)];
    for (name, value) in positive {
        if !(value.is_finite() && value > 0.0) {
            return Err(TrafficError::Setup(format!("IDM parameter {name} is {value}; allowed: above 0")));
        }
    }
    if !(idm.noise.is_finite() && idm.noise >= 0.0) {
        return Err(TrafficError::Setup(format!("IDM parameter noise is {}; allowed: 0 or more", idm.noise)));
    }
    Ok(())
}

impl FixedSetup {
    /// Checks that no other vehicle has a model that only SUMO has.
    pub(super) fn check_has_one_model(&self) -> Result<(), TrafficError> {
        match self.mixture.model {
            FollowingModel::Idm => Ok(()),
            model => Err(TrafficError::NoSuchModel(model)),
        }
    }

    /// Checks that an engine can simulate this setup.
    ///
    /// # Errors
    /// [`TrafficError::NotFinite`], [`TrafficError::Setup`] or [`TrafficError::CarsOverlap`], with the value at fault.
    pub fn check(&self) -> Result<(), TrafficError> {
        check_count(self.cars.len(), self.map.route.length_m(), 0.0)?;
        self.check_numbers()?;
        for (car, start) in self.cars.iter().enumerate() {
            let next = (car + 1) % self.cars.len();
            let headway_m = self.map.route.ahead(start.s_m, self.cars[next].s_m);
            if headway_m < CAR_LENGTH_M {
                return Err(TrafficError::Setup(format!(
                    "vehicle {car} at {:.2} m and vehicle {next} ahead at {:.2} m overlap: vehicles are {CAR_LENGTH_M} \
                     m long",
                    start.s_m, self.cars[next].s_m
                )));
            }
        }
        self.check_poses()
    }

    /// Checks that the native engine can simulate this setup on an open route, where vehicles may start in any order.
    ///
    /// # Errors
    /// As [`FixedSetup::check`].
    pub(super) fn check_on_lane(&self) -> Result<(), TrafficError> {
        self.check_numbers()?;
        self.check_poses()
    }

    /// Checks the models, the step, and each vehicle's numbers.
    fn check_numbers(&self) -> Result<(), TrafficError> {
        if let TrafficDrivers::Alike(idm) = &self.drivers {
            check_idm(idm)?;
        }
        let milliseconds = self.step_s * 1000.0;
        // SUMO counts time in whole milliseconds.
        if !(0.5..=1000.5).contains(&milliseconds) || (milliseconds - milliseconds.round()).abs() > 1e-6 {
            return Err(TrafficError::Setup(format!(
                "the step is {} s; allowed: a whole number of milliseconds, up to 1 s",
                self.step_s
            )));
        }
        for (car, start) in (0..).zip(&self.cars) {
            for (what, value) in [("starting position", start.s_m), ("starting speed", start.speed_mps)] {
                if !value.is_finite() {
                    return Err(TrafficError::NotFinite { what, car, value });
                }
            }
            if start.speed_mps < 0.0 {
                return Err(TrafficError::Setup(format!(
                    "vehicle {car} starts at {} m/s; allowed: 0 or more",
                    start.speed_mps
                )));
            }
        }
        Ok(())
    }

    /// Checks that no two vehicles overlap.
    fn check_poses(&self) -> Result<(), TrafficError> {
        let route = &self.map.route;
        let poses: Vec<_> = self.cars.iter().map(|car| route.pose_of_front(car.s_m, CAR_LENGTH_M)).collect();
        if let Some((a, b)) = overlapping(&poses) {
            let at = poses[b].position;
            return Err(TrafficError::CarsOverlap { a, b, x_m: at.x, y_m: at.y });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bunch_on_the_250_m_ring_leaves_a_hole_of_50_m() {
        let cars = bunched(22, 250.0, 2.0, 0.0).unwrap();
        let steps: Vec<f64> = cars.windows(2).map(|pair| pair[1].s_m - pair[0].s_m).collect();
        assert_eq!(steps.iter().filter(|step| (**step - 9.0909).abs() < 1e-4).count(), 20);
        assert_eq!(steps.iter().filter(|step| (**step - 59.0909).abs() < 1e-4).count(), 1);
        assert!(250.0 - cars[21].s_m > 9.09);
    }

    #[test]
    fn a_full_bunch_shrinks_the_hole_and_not_the_gaps() {
        for cars in [bunched(35, 250.0, 2.0, 0.0).unwrap(), even(35, 250.0, 2.0, 0.0).unwrap()] {
            let close = cars.windows(2).map(|pair| pair[1].s_m - pair[0].s_m).fold(f64::INFINITY, f64::min);
            assert!(close > 7.0 - 1e-9, "{close}");
            assert!(cars[34].s_m <= 243.0 + 1e-9);
        }
    }

    #[test]
    fn impossible_numbers_of_cars_are_refused_with_what_is_allowed() {
        let message = |n| even(n, 250.0, 2.0, 0.0).unwrap_err().to_string();
        assert_eq!(
            message(1000),
            "1000 vehicles do not fit on 250 m: at most 35\n  remedy: choose fewer vehicles, or a map with a longer \
             route"
        );
        assert_eq!(
            message(36),
            "36 vehicles do not fit on 250 m: at most 35\n  remedy: choose fewer vehicles, or a map with a longer route"
        );
        assert!(message(0).contains("2 to 35"), "{}", message(0));
        assert!(message(1).starts_with("1 vehicle is too few"), "{}", message(1));
    }
}
