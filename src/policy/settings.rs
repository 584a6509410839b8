//! Road and step data that policies are built for. In: the road's equilibrium speed and a target speed. Out: [`PolicySettings`].

/// Road and step data that [`build`](super::build) needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolicySettings {
    /// Target speed, m/s; 0 takes [`AUTOMATIC_SHARE`] of `equilibrium_mps`.
    pub aim_mps: f64,
    /// Equilibrium speed of an evenly spaced ring of these vehicles, m/s.
    pub equilibrium_mps: f64,
    /// Length of a step, s.
    pub step_s: f64,
}

impl PolicySettings {
    /// Returns the target speed, or the automatic one if none is set, m/s.
    pub fn aim_or_automatic_mps(&self) -> f64 {
        if self.aim_mps > 0.0 { self.aim_mps } else { AUTOMATIC_SHARE * self.equilibrium_mps }
    }
}

/// Automatic target speed as a share of the equilibrium speed: on the 250 m ring 4.30 of 4.362 m/s. At 4.30 m/s two-phase and
/// FollowerStopper calm every seed; at 4.43 m/s the latter calms only 11 of 20 (docs/references.md: advice).
pub const AUTOMATIC_SHARE: f64 = 0.985;
