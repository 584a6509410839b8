//! Tyre model. In: load, sliding speed of the contact patch, drive and brake force. Out: the force of the road in the
//! wheel's frame (x along the wheel, y to its left). N, m, m/s.
//!
//! A tyre is a bristle between rim and road. Its lateral behaviour is Pacejka's single-contact-point model (*Tire and
//! Vehicle Dynamics*, ch. 7): the bristle is deflected by sliding and released by rolling, `du/dt = -v_y - |v_x| u /
//! relaxation`, and its force follows the brush model. The longitudinal behaviour is friction of the brake: the force
//! needed to hold, up to the brake's force. At a standstill both are springs, so a parked vehicle stays where it is. At
//! speed the lateral deflection corresponds to a slip angle, and the longitudinal force is constant.

/// Inputs of the tyre model in one sub-step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ContactPatch {
    pub load_n: f32,
    /// Load at rest, N; determines the stiffness of the standing tyre.
    pub rest_load_n: f32,
    /// Longitudinal velocity of the contact patch over the road, wheel frame, m/s.
    pub vx_mps: f32,
    /// Lateral velocity of the contact patch, positive to the left, m/s.
    pub vy_mps: f32,
    /// Force of the engine at the rim, N.
    pub drive_n: f32,
    /// Largest force of the brake, N.
    pub brake_n: f32,
    /// Rolling resistance against the motion, N.
    pub rolling_n: f32,
    /// Friction coefficient of tyre and ground.
    pub friction: f32,
    /// Cornering stiffness per load, 1/rad.
    pub cornering: f32,
}

/// Parameters of a tyre that do not depend on wheel or ground, see [`super::TyreParams`].
#[derive(Clone, Copy, Debug)]
pub(super) struct TreadParams {
    pub relaxation_m: f32,
    pub per_m: f32,
    pub damping: f32,
    pub slip_control: f32,
}

/// Force of the road on a tyre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct TyreForce {
    /// Longitudinal force, N, positive forwards.
    pub x_n: f32,
    /// Lateral force, N, positive to the left.
    pub y_n: f32,
    /// Lateral saturation: 0 for full adhesion, 1 for sliding sideways.
    pub saturation: f32,
}

/// Deflection of the bristle between rim and road.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BristleState {
    ux_m: f32,
    uy_m: f32,
}

/// Speed above which rolling alone damps the tyre, m/s; below it the tread's own damping is added.
const LOW_SPEED_MPS: f32 = 2.5;
const GRAVITY: f32 = 9.81;

impl BristleState {
    /// Advances the bristle by `dt` seconds and returns the force.
    pub fn step(&mut self, tread: &TreadParams, patch: &ContactPatch, dt: f32) -> TyreForce {
        let limit_n = patch.friction * patch.load_n;
        if limit_n <= 0.0 {
            *self = Self::default();
            return TyreForce::default();
        }
        // A wheel carries rest_load / g; the damping ratio refers to this mass on the bristle.
        let mass_kg = patch.rest_load_n / GRAVITY;
        let held_n = limit_n * tread.slip_control;

        let stiffness = tread.per_m * patch.rest_load_n;
        let cap_n = patch.brake_n.min(held_n) + patch.rolling_n;
        let damping = 2.0 * tread.damping * (stiffness * mass_kg).sqrt();
        self.ux_m = (self.ux_m - patch.vx_mps * dt).clamp(-cap_n / stiffness, cap_n / stiffness);
        let hold_n = (stiffness * self.ux_m - damping * patch.vx_mps).clamp(-cap_n, cap_n);
        let room_n = held_n + patch.rolling_n;
        let x_n = (patch.drive_n.clamp(-held_n, held_n) + hold_n).clamp(-room_n, room_n);

        let cornering = patch.cornering * patch.load_n;
        let stiffness = cornering / tread.relaxation_m;
        // Full sliding at three times the linear limit (brush model).
        let end_m = 3.0 * limit_n / stiffness;
        let let_go = 1.0 + patch.vx_mps.abs() * dt / tread.relaxation_m;
        self.uy_m = ((self.uy_m - patch.vy_mps * dt) / let_go).clamp(-end_m, end_m);
        let slow = (1.0 - patch.vx_mps.abs() / LOW_SPEED_MPS).max(0.0);
        let damping = 2.0 * tread.damping * (stiffness * mass_kg).sqrt() * slow * slow;
        let s = self.uy_m.abs() / end_m;
        let brush_n = limit_n * 3.0 * s * (1.0 - s + s * s / 3.0);
        let y_n = (brush_n.copysign(self.uy_m) - damping * patch.vy_mps).clamp(-limit_n, limit_n);

        // Friction circle. Rolling resistance is a deformation of the ground and does not reduce the grip.
        let scale = (limit_n / x_n.abs().min(held_n).hypot(y_n).max(1.0)).min(1.0);
        TyreForce { x_n: x_n * scale, y_n: y_n * scale, saturation: s }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TREAD: TreadParams = TreadParams { relaxation_m: 0.45, per_m: 50.0, damping: 0.9, slip_control: 0.95 };

    fn patch() -> ContactPatch {
        ContactPatch { load_n: 4000.0, rest_load_n: 4000.0, friction: 1.0, cornering: 15.0, ..ContactPatch::default() }
    }

    fn settled(patch: &ContactPatch) -> TyreForce {
        let mut tyre = BristleState::default();
        (0..4000).map(|_| tyre.step(&TREAD, patch, 0.0025)).last().unwrap()
    }

    #[test]
    fn small_slip_angles_give_cornering_stiffness_times_angle() {
        for angle in [-0.01f32, 0.002, 0.01] {
            let grip = settled(&ContactPatch { vx_mps: 10.0, vy_mps: -10.0 * angle, ..patch() });
            let linear = 60_000.0 * angle;
            assert!((grip.y_n / linear - 1.0).abs() < 0.06, "{angle} {grip:?}");
        }
    }

    #[test]
    fn the_force_stays_within_the_friction_circle() {
        for i in 0..200 {
            let f = i as f32;
            let patch = ContactPatch {
                vx_mps: (f * 0.7).sin() * 20.0,
                vy_mps: (f * 1.3).sin() * 10.0,
                drive_n: (f * 0.31).sin() * 9000.0,
                brake_n: (f * 0.11).sin().max(0.0) * 9000.0,
                ..patch()
            };
            let grip = settled(&patch);
            assert!(grip.x_n.hypot(grip.y_n) <= 4000.1, "{patch:?} {grip:?}");
        }
    }

    #[test]
    fn a_braked_wheel_holds_up_to_the_brake_force_and_slides_beyond() {
        let mut tyre = BristleState::default();
        let hold = ContactPatch { brake_n: 1000.0, ..patch() };
        // Pulled back by 1 mm: the spring force is 200 N.
        let grip = tyre.step(&TREAD, &ContactPatch { vx_mps: -0.001 / 0.0025, ..hold }, 0.0025);
        assert!(grip.x_n > 200.0);
        assert!((tyre.step(&TREAD, &hold, 0.0025).x_n - 200.0).abs() < 1.0);
        let grip = settled(&ContactPatch { vx_mps: 10.0, ..hold });
        assert!((grip.x_n + 1000.0).abs() < 1.0, "{grip:?}");
    }
}
