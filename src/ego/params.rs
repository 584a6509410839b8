//! The ego's parameters: a mid-size saloon with a petrol engine and a six-speed automatic gearbox. In: a scenario file, or
//! nothing. Out: [`CarParams`], checked. SI units, ratios and shares without unit; engine speeds in 1/min because every data
//! sheet has them so.

use serde::{Deserialize, Serialize};

/// Why an ego cannot be built.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum EgoError {
    /// A number of the car lies outside of what can be simulated.
    #[error("car: {name} = {value} is not allowed\n  remedy: give a number from {min} to {max}")]
    OutOfRange {
        /// Which number, as it is written in a scenario file.
        name: &'static str,
        /// What was given.
        value: f64,
        /// Smallest allowed.
        min: f64,
        /// Largest allowed.
        max: f64,
    },
    /// A table is too short or not in ascending order.
    #[error("car: {name} must have at least {least} entries, {order}")]
    Table {
        /// Which table.
        name: &'static str,
        /// Fewest entries.
        least: usize,
        /// Its order in words.
        order: &'static str,
    },
}

/// The whole car. Every part has defaults, so a scenario file names only what differs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CarParams {
    /// Masses, axles and air
    pub body: BodyParams,
    /// Springs and dampers
    pub suspension: SuspensionParams,
    /// Grip
    pub tyres: TyreParams,
    /// Brakes
    pub brakes: BrakeParams,
    /// Steering feel
    pub steering: SteeringParams,
    /// Engine and pedal map
    pub engine: EngineParams,
    /// Torque converter and gears
    pub gearbox: GearboxParams,
}

/// Masses, axles and air.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BodyParams {
    /// Mass with driver, kg
    pub mass_kg: f64,
    /// Height of the centre of gravity above the road, m
    pub cg_height_m: f64,
    /// Share of the weight on the front axle (front engine, front drive: 0.54)
    pub front_share: f64,
    /// Front axle to rear axle, m
    pub wheelbase_m: f64,
    /// Middle of the body to the front axle, m: 1.45 leaves a front overhang of 1.05 of the 5 m
    pub front_axle_m: f64,
    /// Left wheel to right wheel, m
    pub track_m: f64,
    /// Rolling radius of a tyre, m (205/55 R16: 0.32)
    pub wheel_radius_m: f64,
    /// Moments of inertia about the roll, pitch and yaw axes, kg m2
    pub inertia_kgm2: [f64; 3],
    /// Drag coefficient times frontal area, m2 (0.28 times 2.2 m2)
    pub drag_area_m2: f64,
    /// Density of air, kg/m3 (15 degrees Celsius at sea level)
    pub air_density_kgm3: f64,
}

impl Default for BodyParams {
    fn default() -> Self {
        Self {
            mass_kg: 1500.0,
            cg_height_m: 0.55,
            front_share: 0.54,
            wheelbase_m: 2.80,
            front_axle_m: 1.45,
            track_m: 1.55,
            wheel_radius_m: 0.32,
            inertia_kgm2: [550.0, 2300.0, 2600.0],
            drag_area_m2: 0.62,
            air_density_kgm3: 1.225,
        }
    }
}

/// Springs and dampers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SuspensionParams {
    /// Natural frequency of the body on the front and on the rear springs, Hz; the rear a little higher keeps the car
    /// from pitching after a bump
    pub ride_hz: [f64; 2],
    /// Damping ratio while a wheel is pushed in
    pub bump_ratio: f64,
    /// Damping ratio while a wheel comes out; higher than the bump's, so that the body settles in one swing
    pub rebound_ratio: f64,
    /// Largest way of a wheel to either side of its unloaded place, m
    pub travel_m: f64,
    /// Anti-roll bars, front and rear, N per metre of difference between left and right: with the springs 4 degrees of
    /// roll at 1 g
    pub anti_roll_npm: [f64; 2],
    /// Height above the road at which the links hand tyre forces to the body, m: 0 is all dive and roll, the height of
    /// the centre of gravity none
    pub link_height_m: f64,
}

impl Default for SuspensionParams {
    fn default() -> Self {
        Self {
            ride_hz: [1.3, 1.45],
            bump_ratio: 0.35,
            rebound_ratio: 0.55,
            travel_m: 0.30,
            anti_roll_npm: [12_000.0, 6_000.0],
            link_height_m: 0.06,
        }
    }
}

/// Grip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TyreParams {
    /// Friction coefficient on dry asphalt
    pub asphalt_friction: f64,
    /// Friction coefficient on grass
    pub grass_friction: f64,
    /// Cornering stiffness of the front tyres as a share of their load, 1/rad
    pub front_cornering: f64,
    /// The same of the rear tyres; stiffer than the front, so that the car understeers a little: 1/14.5 - 1/18 =
    /// 0.013 rad at 1 g
    pub rear_cornering: f64,
    /// Way a tyre rolls until its side force has followed the slip, m
    pub relaxation_m: f64,
    /// Stiffness of a standing tyre along the road as a share of its load, 1/m: a car that stops at 1 m/s2 is stretched
    /// by 0.9 mm and comes back by as much; one that holds against its creep stands 0.6 mm ahead
    pub tread_per_m: f64,
    /// Damping ratio of the standing tyre
    pub tread_damping: f64,
    /// Share of the friction limit that brake and drive may take; the anti-lock brake and the traction control keep
    /// the rest for steering
    pub slip_control: f64,
    /// Rolling resistance on asphalt, share of the load
    pub asphalt_rolling: f64,
    /// Rolling resistance on grass at walking pace, share of the load
    pub grass_rolling: f64,
    /// Its growth with speed, per m/s: with the grip of the front wheels this ends at about 28 km/h
    pub grass_rolling_per_mps: f64,
    /// Its upper end
    pub grass_rolling_max: f64,
}

impl Default for TyreParams {
    fn default() -> Self {
        Self {
            asphalt_friction: 0.98,
            grass_friction: 0.35,
            front_cornering: 14.5,
            rear_cornering: 18.0,
            relaxation_m: 0.45,
            tread_per_m: 120.0,
            tread_damping: 0.9,
            slip_control: 0.95,
            asphalt_rolling: 0.012,
            grass_rolling: 0.08,
            grass_rolling_per_mps: 0.0125,
            grass_rolling_max: 0.25,
        }
    }
}

/// Brakes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BrakeParams {
    /// Braking force at a floored pedal as a share of the weight; above the grip, so that the tyres decide
    pub full_share: f64,
    /// Share of it at the front axle
    pub front_share: f64,
    /// Exponent of the pedal: above 1 the first half of the pedal is the gentle half
    pub pedal_exponent: f64,
    /// Time constant of the hydraulics, s
    pub lag_s: f64,
    /// Pedal from which the lamps are lit
    pub lamp_pedal: f64,
}

impl Default for BrakeParams {
    fn default() -> Self {
        Self { full_share: 1.15, front_share: 0.66, pedal_exponent: 1.4, lag_s: 0.06, lamp_pedal: 0.02 }
    }
}

/// Steering feel. Ratio and lock are [`STEERING_RATIO`](crate::controls::STEERING_RATIO) and [`STEERING_LOCK_RAD`](crate::controls::STEERING_LOCK_RAD).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SteeringParams {
    /// Pneumatic trail of an unsaturated front tyre, m; it vanishes as the tyre starts to slide
    pub pneumatic_trail_m: f64,
    /// Trail of the steering axis, m
    pub caster_trail_m: f64,
    /// Share of the torque that power assistance leaves to the driver
    pub feel_share: f64,
}

impl Default for SteeringParams {
    fn default() -> Self {
        Self { pneumatic_trail_m: 0.035, caster_trail_m: 0.015, feel_share: 0.30 }
    }
}

/// Engine and pedal map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EngineParams {
    /// Full-throttle torque: pairs of engine speed in 1/min and torque in N m, ascending
    pub torque_curve: Vec<(f64, f64)>,
    /// Idle speed, 1/min
    pub idle_rpm: f64,
    /// Speed at which fuel is cut, 1/min
    pub limit_rpm: f64,
    /// Moment of inertia with the converter's pump, kg m2
    pub inertia_kgm2: f64,
    /// Friction at standstill, N m
    pub drag_nm: f64,
    /// Growth of the friction, N m per rad/s
    pub drag_nms: f64,
    /// Share of the full torque per pedal at the top of the pedal; the rest grows with its square, so that the first
    /// third of the pedal is for walking pace
    pub pedal_linear: f64,
    /// Pedal at which the engine just carries its own friction
    pub pedal_neutral: f64,
    /// Power at a floored pedal, W; a pedal p may take p squared of it, so that a steady pedal means a steady speed
    pub pedal_power_w: f64,
}

impl Default for EngineParams {
    fn default() -> Self {
        Self {
            torque_curve: vec![
                (0.0, 110.0),
                (1000.0, 160.0),
                (1500.0, 200.0),
                (2000.0, 215.0),
                (4500.0, 215.0),
                (5500.0, 185.0),
                (6500.0, 140.0),
            ],
            idle_rpm: 650.0,
            limit_rpm: 6400.0,
            inertia_kgm2: 0.20,
            drag_nm: 14.0,
            drag_nms: 0.03,
            pedal_linear: 0.5,
            pedal_neutral: 0.1,
            pedal_power_w: 110_000.0,
        }
    }
}

/// Torque converter and gears.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GearboxParams {
    /// Ratios of the forward gears, first gear first
    pub ratios: Vec<f64>,
    /// Ratio of the reverse gear
    pub reverse_ratio: f64,
    /// Ratio of the final drive
    pub final_drive: f64,
    /// Share of the power that reaches the wheels
    pub efficiency: f64,
    /// True: in gear and without a pedal the car creeps at walking pace
    pub creep: bool,
    /// Torque that the pump of the converter takes at a standing turbine, N m per (rad/s)2
    pub pump_nms2: f64,
    /// Torque ratio of the converter at a standing turbine
    pub stall_ratio: f64,
    /// Engine speed for the next gear up at a light and at a floored pedal, 1/min
    pub up_rpm: [f64; 2],
    /// Engine speed for the next gear down at a light and at a floored pedal, 1/min; far enough below the other that
    /// the gear after a change is not changed back
    pub down_rpm: [f64; 2],
    /// Duration of a change of gear, s
    pub shift_s: f64,
    /// Shortest time between two changes, s
    pub dwell_s: f64,
    /// Speed below which the selector may change between forwards and backwards, m/s
    pub selector_speed_mps: f64,
}

impl Default for GearboxParams {
    fn default() -> Self {
        Self {
            ratios: vec![4.0, 2.33, 1.5, 1.1, 0.83, 0.68],
            reverse_ratio: 3.7,
            final_drive: 3.0,
            efficiency: 0.92,
            creep: true,
            pump_nms2: 0.0036,
            stall_ratio: 1.8,
            up_rpm: [1400.0, 6000.0],
            down_rpm: [700.0, 2400.0],
            shift_s: 0.5,
            dwell_s: 1.2,
            selector_speed_mps: 1.0,
        }
    }
}

impl CarParams {
    /// Checks every number.
    ///
    /// # Errors
    /// Names the first number that is not finite or lies outside of what the model can simulate.
    pub fn check(&self) -> Result<(), EgoError> {
        let (body, susp, tyre, gears) = (&self.body, &self.suspension, &self.tyres, &self.gearbox);
        let (brake, engine) = (&self.brakes, &self.engine);
        let ranges = [
            ("body.mass_kg", body.mass_kg, 300.0, 10_000.0),
            ("body.cg_height_m", body.cg_height_m, 0.1, 1.5),
            ("body.front_share", body.front_share, 0.2, 0.8),
            ("body.wheelbase_m", body.wheelbase_m, 1.5, 4.5),
            ("body.front_axle_m", body.front_axle_m, 0.5, 2.5),
            ("body.track_m", body.track_m, 1.0, 2.2),
            ("body.wheel_radius_m", body.wheel_radius_m, 0.15, 0.6),
            ("body.inertia_kgm2[0]", body.inertia_kgm2[0], 50.0, 50_000.0),
            ("body.inertia_kgm2[1]", body.inertia_kgm2[1], 100.0, 50_000.0),
            ("body.inertia_kgm2[2]", body.inertia_kgm2[2], 100.0, 50_000.0),
            ("body.drag_area_m2", body.drag_area_m2, 0.0, 5.0),
            ("body.air_density_kgm3", body.air_density_kgm3, 0.0, 2.0),
            ("suspension.ride_hz[0]", susp.ride_hz[0], 0.8, 3.0),
            ("suspension.ride_hz[1]", susp.ride_hz[1], 0.8, 3.0),
            ("suspension.bump_ratio", susp.bump_ratio, 0.0, 2.0),
            ("suspension.rebound_ratio", susp.rebound_ratio, 0.0, 2.0),
            ("suspension.travel_m", susp.travel_m, 0.05, 0.5),
            ("suspension.anti_roll_npm[0]", susp.anti_roll_npm[0], 0.0, 100_000.0),
            ("suspension.anti_roll_npm[1]", susp.anti_roll_npm[1], 0.0, 100_000.0),
            ("suspension.link_height_m", susp.link_height_m, 0.0, body.cg_height_m),
            ("tyres.asphalt_friction", tyre.asphalt_friction, 0.05, 1.5),
            ("tyres.grass_friction", tyre.grass_friction, 0.05, 1.5),
            ("tyres.front_cornering", tyre.front_cornering, 2.0, 60.0),
            ("tyres.rear_cornering", tyre.rear_cornering, 2.0, 60.0),
            ("tyres.relaxation_m", tyre.relaxation_m, 0.1, 2.0),
            ("tyres.tread_per_m", tyre.tread_per_m, 5.0, 200.0),
            ("tyres.tread_damping", tyre.tread_damping, 0.0, 1.5),
            ("tyres.slip_control", tyre.slip_control, 0.3, 1.0),
            ("tyres.asphalt_rolling", tyre.asphalt_rolling, 0.0, 0.1),
            ("tyres.grass_rolling", tyre.grass_rolling, 0.0, 0.5),
            ("tyres.grass_rolling_per_mps", tyre.grass_rolling_per_mps, 0.0, 0.1),
            ("tyres.grass_rolling_max", tyre.grass_rolling_max, 0.0, 0.5),
            ("brakes.full_share", brake.full_share, 0.2, 2.0),
            ("brakes.front_share", brake.front_share, 0.3, 1.0),
            ("brakes.pedal_exponent", brake.pedal_exponent, 0.5, 3.0),
            ("brakes.lag_s", brake.lag_s, 0.0, 1.0),
            ("brakes.lamp_pedal", brake.lamp_pedal, 0.0, 1.0),
            ("steering.pneumatic_trail_m", self.steering.pneumatic_trail_m, 0.0, 0.1),
            ("steering.caster_trail_m", self.steering.caster_trail_m, 0.0, 0.1),
            ("steering.feel_share", self.steering.feel_share, 0.0, 1.0),
            ("engine.idle_rpm", engine.idle_rpm, 300.0, 2000.0),
            ("engine.limit_rpm", engine.limit_rpm, 2000.0, 20_000.0),
            ("engine.inertia_kgm2", engine.inertia_kgm2, 0.05, 2.0),
            ("engine.drag_nm", engine.drag_nm, 0.0, 100.0),
            ("engine.drag_nms", engine.drag_nms, 0.0, 0.5),
            ("engine.pedal_linear", engine.pedal_linear, 0.0, 1.0),
            ("engine.pedal_neutral", engine.pedal_neutral, 0.01, 0.5),
            ("engine.pedal_power_w", engine.pedal_power_w, 10_000.0, 1_000_000.0),
            ("gearbox.reverse_ratio", gears.reverse_ratio, 0.5, 10.0),
            ("gearbox.final_drive", gears.final_drive, 0.5, 10.0),
            ("gearbox.efficiency", gears.efficiency, 0.3, 1.0),
            ("gearbox.pump_nms2", gears.pump_nms2, 0.0005, 0.02),
            ("gearbox.stall_ratio", gears.stall_ratio, 1.0, 3.0),
            ("gearbox.up_rpm[0]", gears.up_rpm[0], engine.idle_rpm, gears.up_rpm[1]),
            ("gearbox.up_rpm[1]", gears.up_rpm[1], engine.idle_rpm, engine.limit_rpm),
            ("gearbox.down_rpm[0]", gears.down_rpm[0], 300.0, gears.up_rpm[0]),
            ("gearbox.down_rpm[1]", gears.down_rpm[1], 300.0, gears.up_rpm[1]),
            ("gearbox.shift_s", gears.shift_s, 0.02, 2.0),
            ("gearbox.dwell_s", gears.dwell_s, 0.0, 10.0),
            ("gearbox.selector_speed_mps", gears.selector_speed_mps, 0.01, 10.0),
        ];
        for (name, value, min, max) in ranges {
            if !(min..=max).contains(&value) {
                return Err(EgoError::OutOfRange { name, value, min, max });
            }
        }
        let curve = &engine.torque_curve;
        let sane = curve.iter().all(|(rpm, nm)| (0.0..=20_000.0).contains(rpm) && (0.0..=2000.0).contains(nm));
        if curve.len() < 2 || !sane || !curve.windows(2).all(|w| w[0].0 < w[1].0) {
            let order = "pairs of 1/min (0 to 20000, ascending) and N m (0 to 2000)";
            return Err(EgoError::Table { name: "engine.torque_curve", least: 2, order });
        }
        let sane = gears.ratios.iter().all(|ratio| (0.1..=10.0).contains(ratio));
        if gears.ratios.is_empty() || !sane || !gears.ratios.windows(2).all(|w| w[0] > w[1]) {
            let order = "ratios from 10 to 0.1, first gear first, descending";
            return Err(EgoError::Table { name: "gearbox.ratios", least: 1, order });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_car_is_allowed_and_a_broken_one_is_named() {
        let mut car = CarParams::default();
        assert_eq!(car.check(), Ok(()));
        car.tyres.asphalt_friction = f64::NAN;
        let message = car.check().unwrap_err().to_string();
        assert!(message.contains("tyres.asphalt_friction = NaN") && message.contains("0.05 to 1.5"), "{message}");
        car = CarParams::default();
        car.gearbox.ratios = vec![1.0, 2.0];
        assert!(car.check().unwrap_err().to_string().contains("gearbox.ratios"));
    }

    #[test]
    fn a_file_names_only_what_differs() {
        let car: CarParams = toml::from_str("[gearbox]\ncreep = false\n").unwrap();
        assert!(!car.gearbox.creep);
        assert_eq!(car.body, BodyParams::default());
        assert!(toml::from_str::<CarParams>("[gearbox]\ncrepe = false\n").is_err());
    }
}
