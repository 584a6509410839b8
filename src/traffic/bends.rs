//! Speed limits in bends. In: the route and the lateral acceleration that drivers find comfortable. Out: the highest speed at every
//! position, with gentle braking before bends. One rule for both engines. Metres, m/s, m/s2.

use crate::map::Route;

/// Length over which the curvature of a bend is measured, metres: two vehicle lengths.
const SPAN_M: f64 = 10.0;
/// Maximum distance between two positions of the table, metres.
const STEP_M: f64 = 1.0;
/// Deceleration before a bend, m/s2: gentler than the model's comfortable one, so that the model can follow it.
const BRAKING_MPS2: f64 = 1.0;
/// Upper limit of the table, m/s: no model drives faster.
const UNBOUNDED_MPS: f64 = 100.0;

/// Highest speed at every position of a route.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BendSpeeds {
    step_m: f64,
    cap_mps: Vec<f64>,
}

impl BendSpeeds {
    /// Computes the speeds of a route for a lateral acceleration, m/s2; `None` if no acceleration is given.
    pub fn of(route: &Route, lateral_mps2: Option<f64>) -> Option<Self> {
        let lateral_mps2 = lateral_mps2?;
        let n = (route.length_m() / STEP_M).ceil().max(1.0) as usize;
        let step_m = route.length_m() / n as f64;
        let cap = |i: usize| {
            let bend = route.curvature_at(i as f64 * step_m, SPAN_M).abs();
            (lateral_mps2 / bend.max(1e-9)).sqrt().min(UNBOUNDED_MPS)
        };
        let mut cap_mps: Vec<f64> = (0..n).map(cap).collect();
        // Backwards and twice round: the end of the route lies before its first position.
        for i in (0..2 * n).rev() {
            let ahead_mps = cap_mps[(i + 1) % n];
            let here = &mut cap_mps[i % n];
            *here = here.min((ahead_mps * ahead_mps + 2.0 * BRAKING_MPS2 * step_m).sqrt());
        }
        Some(Self { step_m, cap_mps })
    }

    /// Returns the highest speed at a position of the route, m/s.
    pub fn at(&self, s_m: f64) -> f64 {
        let n = self.cap_mps.len();
        let i = (s_m.max(0.0) / self.step_m) as usize % n;
        self.cap_mps[i].min(self.cap_mps[(i + 1) % n])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::RoadMap;

    #[test]
    fn bend_speed_is_constant_on_a_ring_and_drops_before_a_bend_of_a_road() {
        let ring = RoadMap::load("ring-250").unwrap().route;
        assert_eq!(BendSpeeds::of(&ring, None), None);
        let speeds = BendSpeeds::of(&ring, Some(3.0)).unwrap();
        // The radius is 39.79 m: the square root of 3 times that is 10.93 m/s.
        assert!((0..250).all(|s| (speeds.at(f64::from(s)) - 10.93).abs() < 0.02), "{}", speeds.at(0.0));
        let practice = RoadMap::load("practice").unwrap().route;
        let speeds = BendSpeeds::of(&practice, Some(3.0)).unwrap();
        let metres = || (0..practice.length_m() as u32).map(f64::from);
        let slowest = metres().map(|s| speeds.at(s)).fold(f64::INFINITY, f64::min);
        // The tightest bend has a radius of 25 m: 8.66 m/s.
        assert!((slowest - 8.66).abs() < 0.1, "{slowest}");
        for s in metres() {
            let (here, next) = (speeds.at(s), speeds.at(s + 1.0));
            assert!(here * here - next * next <= 2.0 * BRAKING_MPS2 * 1.05 + 1e-9, "{s}: {here} {next}");
            // Between two positions of the table the bend may be slightly sharper.
            assert!(here * here * practice.curvature_at(s, SPAN_M).abs() <= 3.0 * 1.01, "{s}: {here}");
        }
    }
}
