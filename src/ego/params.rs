//! Parameters of the ego: a mid-size saloon with a petrol engine and a six-speed automatic gearbox. In: a scenario
//! file, or nothing. Out: [`CarParams`], checked. SI units, ratios and shares without unit; engine speeds are in 1/min,
//! as in data sheets.

use super::wet_road;
use serde::{Deserialize, Serialize};

/// Error in the parameters of the ego.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum EgoError {
    /// Number outside the range that can be simulated.
    #[error("car: {name} = {value} is not allowed\n  remedy: give a number from {min} to {max}")]
    OutOfRange {
        /// Name of the number, as in a scenario file.
        name: &'static str,
        value: f64,
        min: f64,
        max: f64,
    },
    /// Table that is too short, out of order, or has a value that is not allowed.
    #[error("car: {name} must have at least {least} entries, {order}")]
    Table {
        /// Name of the table, as in a scenario file.
        name: &'static str,
        /// Smallest number of entries.
        least: usize,
        /// Description of the entries and their order.
        order: &'static str,
    },
}

/// Parameters of the whole ego. Every part has defaults, so a scenario file lists only the differences.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CarParams {
    /// Masses, axles and air
    pub body: BodyParams,
    /// Springs, dampers and anti-roll bars
    pub suspension: SuspensionParams,
    /// Grip and rolling resistance of the tyres
    pub tyres: TyreParams,
    /// Brake force, its distribution and its lag
    pub brakes: BrakeParams,
    /// Steering feel: trails and power assistance
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
    /// Distance from front axle to rear axle, m
    pub wheelbase_m: f64,
    /// Distance from the middle of the body to the front axle, m: 1.45 leaves a front overhang of 1.05 of the 5 m
    pub front_axle_m: f64,
    /// Distance from left wheel to right wheel, m
    pub track_m: f64,
    /// Rolling radius of a tyre, m (205/55 R16: 0.32)
    pub wheel_radius_m: f64,
    /// Moments of inertia about the roll, pitch and yaw axes, kg m²
    pub inertia_kgm2: [f64; 3],
    /// Drag coefficient times frontal area, m² (0.28 times 2.2 m²)
    pub drag_area_m2: f64,
    /// Density of air, kg/m³ (15 degrees Celsius at sea level)
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

/// Springs, dampers and anti-roll bars.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SuspensionParams {
    /// Natural frequency of the body on the front and on the rear springs, Hz; a slightly higher one at the rear keeps
    /// the ego from pitching after a bump
    pub ride_hz: [f64; 2],
    /// Damping ratio in compression
    pub bump_ratio: f64,
    /// Damping ratio in rebound; higher than in compression, so that the body settles in one swing
    pub rebound_ratio: f64,
    /// Largest travel of a wheel to either side of its unloaded position, m
    pub travel_m: f64,
    /// Anti-roll bars, front and rear, N per metre of difference between left and right: with the springs 4 degrees of
    /// roll at 1 g
    pub anti_roll_npm: [f64; 2],
    /// Height above the road at which the links transmit tyre forces to the body, m: 0 gives full dive and roll, the
    /// height of the centre of gravity gives none
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

/// Grip and rolling resistance of the tyres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TyreParams {
    /// Friction coefficient on dry asphalt
    pub asphalt_friction: f64,
    /// Depth of the water on asphalt, mm; 0 is dry
    pub water_mm: f64,
    /// Friction coefficient on grass
    pub grass_friction: f64,
    /// Cornering stiffness of the front tyres as a share of their load, 1/rad
    pub front_cornering: f64,
    /// Cornering stiffness of the rear tyres as a share of their load, 1/rad; higher than at the front for slight
    /// understeer: 1/14.5 - 1/18 = 0.013 rad at 1 g
    pub rear_cornering: f64,
    /// Relaxation length of the side force, m
    pub relaxation_m: f64,
    /// Longitudinal stiffness of a standing tyre as a share of its load, 1/m: an ego that stops at 1 m/s² stretches it
    /// by 0.9 mm and springs back by as much; one held against its creep stands 0.6 mm ahead
    pub tread_per_m: f64,
    /// Damping ratio of the standing tyre
    pub tread_damping: f64,
    /// Share of the friction limit that brake and drive may use; anti-lock brake and traction control keep the rest for
    /// steering
    pub slip_control: f64,
    /// Rolling resistance on asphalt, share of the load
    pub asphalt_rolling: f64,
    /// Rolling resistance on grass at walking pace, share of the load
    pub grass_rolling: f64,
    /// Growth of the rolling resistance on grass with speed, per m/s: with the grip of the front wheels the speed ends
    /// at about 28 km/h
    pub grass_rolling_per_mps: f64,
    /// Largest rolling resistance on grass, share of the load
    pub grass_rolling_max: f64,
}

impl Default for TyreParams {
    fn default() -> Self {
        Self {
            asphalt_friction: 0.98,
            water_mm: 0.0,
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

impl TyreParams {
    /// Returns the friction coefficient on asphalt at a speed; water makes it less, the more the faster.
    pub(super) fn asphalt_friction_at(&self, speed_mps: f64) -> f64 {
        self.asphalt_friction * wet_road::share_of_dry(self.water_mm, speed_mps)
    }
}

/// Brake force, its distribution and its lag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BrakeParams {
    /// Braking force at a floored pedal as a share of the weight; above the grip, so that the tyres set the limit
    pub full_share: f64,
    /// Share of the braking force at the front axle
    pub front_share: f64,
    /// Exponent from pedal to braking force; above 1 the first half of the pedal is gentle
    pub pedal_exponent: f64,
    /// Time constant of the hydraulics, s
    pub lag_s: f64,
    /// Brake pedal from which the brake lamps are lit
    pub lamp_pedal: f64,
}

impl Default for BrakeParams {
    fn default() -> Self {
        Self { full_share: 1.15, front_share: 0.66, pedal_exponent: 1.4, lag_s: 0.06, lamp_pedal: 0.02 }
    }
}

/// Steering feel. Ratio and lock are [`STEERING_RATIO`](crate::controls::STEERING_RATIO) and
/// [`STEERING_LOCK_RAD`](crate::controls::STEERING_LOCK_RAD).
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
    /// Moment of inertia, including the converter's pump, kg m²
    pub inertia_kgm2: f64,
    /// Friction at standstill, N m
    pub drag_nm: f64,
    /// Growth of the friction, N m per rad/s
    pub drag_nms: f64,
    /// Share of the full torque per pedal at a light pedal; the rest grows with the pedal's square, so that the first
    /// third of the pedal suits walking pace
    pub pedal_linear: f64,
    /// Pedal at which the engine just overcomes its own friction
    pub pedal_neutral: f64,
    /// Power at a floored pedal, W; a pedal p may use p² of it, so that a steady pedal means a steady speed
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
    /// Creep at walking pace in gear without a pedal
    pub creep: bool,
    /// Torque of the converter's pump at a standing turbine, N m per (rad/s)²
    pub pump_nms2: f64,
    /// Torque ratio of the converter at a standing turbine
    pub stall_ratio: f64,
    /// Engine speed for an upshift at a light and at a floored pedal, 1/min
    pub up_rpm: [f64; 2],
    /// Engine speed for a downshift at a light and at a floored pedal, 1/min; far enough below that for an upshift that
    /// a change is not reversed
    pub down_rpm: [f64; 2],
    /// Duration of a gear change, s
    pub shift_s: f64,
    /// Shortest time between two gear changes, s
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
    /// The first number that is not finite or lies outside the range that can be simulated, or an invalid table.
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
            ("tyres.water_mm", tyre.water_mm, 0.0, 2.0),
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
    fn the_default_ego_is_valid_and_an_invalid_number_is_named() {
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
    fn a_file_lists_only_the_differences_from_the_defaults() {
        let car: CarParams = toml::from_str("[gearbox]\ncreep = false\n").unwrap();
        assert!(!car.gearbox.creep);
        assert_eq!(car.body, BodyParams::default());
        assert!(toml::from_str::<CarParams>("[gearbox]\ncrepe = false\n").is_err());
    }
}
