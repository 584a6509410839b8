//! Speed limits as signs state them: in tens of km/h, or in mph in networks whose limits are multiples of 5 mph. In: the limits of a network's
//! streets. Out: the sign at the start of a street.

use super::sign_kind::SignKind;
use crate::{
    map::network::{EdgeId, Network},
    units::{MPS_PER_KMH, MPS_PER_MPH},
};
use std::collections::{BTreeMap, BTreeSet};

/// Unit of limits, with the step between limits that signs state and the largest difference of a network's limit from one, in that unit. A road
/// whose limit differs by more has no sign: a rounded one would be wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LimitUnit {
    mps: f64,
    step: f64,
    tolerance: f64,
}

const KMH: LimitUnit = LimitUnit { mps: MPS_PER_KMH, step: 10.0, tolerance: 0.6 };
const MPH: LimitUnit = LimitUnit { mps: MPS_PER_MPH, step: 5.0, tolerance: 0.3 };

impl LimitUnit {
    /// Returns a limit as a sign states it in this unit; `None` if it is not a multiple of the step.
    fn stated(self, limit_mps: f64) -> Option<u32> {
        let limit = limit_mps / self.mps;
        let stated = (limit / self.step).round() * self.step;
        ((limit - stated).abs() < self.tolerance && stated > 0.0).then_some(stated as u32)
    }
}

/// Speed limits of all streets of a network as signs state them.
pub(super) struct SpeedLimits {
    unit: LimitUnit,
    /// Limits before each street. Streets where vehicles enter the network are left out.
    before: BTreeMap<EdgeId, LimitsBefore>,
}

/// Limits of the streets from which cars come into a street.
#[derive(Default)]
struct LimitsBefore {
    /// Limits as signs state them; 0 for one that no sign states.
    stated: BTreeSet<u32>,
    fastest_mps: f64,
}

impl SpeedLimits {
    /// Finds the unit of a network's limits, and the limits before each street.
    pub fn of(net: &Network) -> Self {
        // Some limits are multiples in both units, such as 50 mph and 80 km/h: the others decide, by the length of their streets.
        let lengths_m = |unit: LimitUnit, other: LimitUnit| -> f64 {
            let streets = net.edge_ids().filter_map(|edge| Some((edge, limit_mps(net, edge)?)));
            let of_unit = streets.filter(|(_, mps)| unit.stated(*mps).is_some() && other.stated(*mps).is_none());
            of_unit.filter_map(|(edge, _)| net.edge(edge).lanes().map(|lane| net.lane(lane).length_m).next()).sum()
        };
        let unit = if lengths_m(MPH, KMH) > lengths_m(KMH, MPH) { MPH } else { KMH };
        let mut limits = Self { unit, before: BTreeMap::new() };
        for lane in net.lane_ids().filter(|lane| net.is_driven(*lane)) {
            let limit = limits.stated(net, net.lane(lane).edge).unwrap_or(0);
            for way in net.connections_from(lane).iter().filter(|way| !way.is_turnaround()) {
                let before = limits.before.entry(net.lane(way.to).edge).or_default();
                before.stated.insert(limit);
                before.fastest_mps = before.fastest_mps.max(net.lane(lane).speed_limit_mps);
            }
        }
        limits
    }

    /// Checks whether vehicles enter the network on a street.
    pub fn is_entry(&self, edge: EdgeId) -> bool {
        !self.before.contains_key(&edge)
    }

    /// Checks whether cars come into a street from one with a limit above this one, m/s.
    pub fn follows_faster(&self, edge: EdgeId, limit_mps: f64) -> bool {
        self.before.get(&edge).is_some_and(|before| before.fastest_mps > limit_mps)
    }

    /// Returns the sign at the start of a street whose limit differs from that of a street before it, or where vehicles enter the network.
    pub fn sign_at_start(&self, net: &Network, edge: EdgeId) -> Option<SignKind<'static>> {
        let limit = self.stated(net, edge)?;
        let changes = self.before.get(&edge).is_none_or(|before| before.stated.iter().any(|before| *before != limit));
        changes.then_some(SignKind::SpeedLimit(limit))
    }

    /// Returns the limit of a street as signs state it; `None` if none does.
    fn stated(&self, net: &Network, edge: EdgeId) -> Option<u32> {
        self.unit.stated(limit_mps(net, edge)?)
    }
}

/// Returns the speed limit of a street for cars, m/s.
fn limit_mps(net: &Network, edge: EdgeId) -> Option<f64> {
    let for_cars = |lane: &_| net.is_driven(*lane) && net.lane(*lane).admits_cars();
    net.edge(edge).lanes().find(for_cars).map(|lane| net.lane(lane).speed_limit_mps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn limits_are_stated_in_the_unit_whose_multiples_they_are() {
        // A mile is 1609.344 m: 20, 30 and 70 mph in m/s, as OpenStreetMap's importer rounds them; 50 mph is near 80 km/h.
        let mph = [(8.94, 20), (13.41, 30), (31.29, 70), (22.35, 50)];
        assert!(mph.iter().all(|(mps, limit)| MPH.stated(*mps) == Some(*limit)));
        assert_eq!(mph.map(|(mps, _)| KMH.stated(mps)), [None, None, None, Some(80)]);
        let kmh = [(8.33, 30), (13.89, 50), (33.33, 120)];
        assert!(kmh.iter().all(|(mps, limit)| KMH.stated(*mps) == Some(*limit)));
        assert_eq!(kmh.map(|(mps, _)| MPH.stated(mps)), [None, None, None]);
    }

    #[test]
    fn a_network_of_miles_has_signs_in_miles_alone() {
        let text = std::fs::read_to_string("tests/data/networks/crossing.net.xml").expect("a network of the tests");
        let signs_with = |limit: &str| {
            // All limits of the file are 13.89 m/s.
            let net = Network::read(
                Path::new("miles.net.xml"),
                &text.replace("speed=\"13.89\"", &format!("speed=\"{limit}\"")),
            );
            let net = net.expect("a network");
            let limits = SpeedLimits::of(&net);
            net.edge_ids().filter_map(|edge| limits.sign_at_start(&net, edge)).collect::<BTreeSet<_>>()
        };
        assert_eq!(signs_with("13.41"), BTreeSet::from([SignKind::SpeedLimit(30)]));
        assert_eq!(signs_with("13.89"), BTreeSet::from([SignKind::SpeedLimit(50)]));
        // 32.5 km/h, 20.2 mph; no sign shows 12 m/s, which is 43.2 km/h or 26.8 mph.
        assert_eq!(signs_with("9.03"), BTreeSet::from([SignKind::SpeedLimit(20)]));
        assert_eq!(signs_with("12.0"), BTreeSet::new());
    }
}
