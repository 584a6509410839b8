//! Comparison of a network with SUMO's own reading of its file. In: a network as codrive has read it. Out: how many lanes and connections
//! are equal, or the first difference. Metres, m/s.

use super::{
    home,
    inputs::Inputs,
    network_check::{self, Trial},
    number, options,
    shim::Shim,
    shim_data::Reading,
};
use crate::{
    map::network::{LaneId, Network, VehicleClasses},
    traffic::TrafficError,
};
use std::{collections::BTreeSet, fmt, path::Path};

/// Largest difference of two lengths, metres, or of two speeds, m/s, that count as equal: files have two decimals.
const EQUAL: f64 = 0.01;
/// Duration of a step of the simulation that reads the network, seconds.
const STEP_S: f64 = 0.1;

/// Result of a comparison without a difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EqualReading {
    pub lanes: usize,
    pub connections: usize,
}

impl fmt::Display for EqualReading {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} lanes, {} connections equal", self.lanes, self.connections)
    }
}

/// A connection by the names of the lane beyond the junction and of the internal lane, and by its direction.
type Link = (String, String, String);

/// Compares the lanes of a network (length, speed limit, permissions) and their connections with SUMO's reading of the file.
///
/// # Errors
/// SUMO is absent, in use, or cannot read the file; or the first difference.
pub fn compare_with_sumo(network: &Network, net_file: &Path) -> Result<EqualReading, TrafficError> {
    let home = home()?;
    let inputs = Inputs::of_network(network, net_file)?;
    // SUMO breaks down on some networks, and would end this process.
    network_check::check(&home, &Trial::of_network(inputs.net()), &Trial::of_network(net_file))?;
    let mut shim = Shim::open(&home)?;
    shim.start(&options::options(&inputs.net().display().to_string(), STEP_S, None, 1))?;
    number(&mut shim, network, Reading { first_number: 0, is_fixed: 1, lateral: 0 })?;
    let differs = |what: String| {
        TrafficError::Setup(format!("{}: codrive and SUMO read this network differently: {what}", net_file.display()))
    };
    let of_sumo = shim.lane_count()?;
    let lanes = network.lanes().len();
    if of_sumo != lanes {
        return Err(differs(format!("it has {lanes} lanes, SUMO finds {of_sumo}")));
    }
    for lane in network.lane_ids() {
        let ((length_m, limit_mps), text) = (shim.lane(lane)?, shim.lane_text(lane)?);
        if let Some(what) = difference(network, lane, &LaneOfSumo { length_m, limit_mps, text }) {
            return Err(differs(format!("lane {}: {what}", network.lane(lane).id)));
        }
    }
    Ok(EqualReading { lanes, connections: network.connections().len() })
}

/// A lane as SUMO has read it.
struct LaneOfSumo {
    length_m: f64,
    limit_mps: f64,
    /// Classes and connections, as [`Shim::lane_text`] gives them.
    text: String,
}

/// Returns the first difference of a lane.
fn difference(network: &Network, id: LaneId, of_sumo: &LaneOfSumo) -> Option<String> {
    let lane = network.lane(id);
    let LaneOfSumo { length_m, limit_mps, text } = of_sumo;
    for (what, own, of_sumo) in
        [("length, m", lane.length_m, *length_m), ("speed limit, m/s", lane.speed_limit_mps, *limit_mps)]
    {
        if (own - of_sumo).abs() > EQUAL {
            return Some(format!("{what}: {own}, SUMO has {of_sumo}"));
        }
    }
    let mut lines = text.lines();
    let of_sumo = VehicleClasses::ALL.without(VehicleClasses::parse(lines.next().unwrap_or_default()));
    if lane.permissions != of_sumo {
        return Some(format!("permissions: {}, SUMO has {}", lane.permissions.list(), of_sumo.list()));
    }
    let link = |line: &str| {
        let mut words = line.split('\t').map(str::to_owned);
        let mut word = || words.next().unwrap_or_default();
        (word(), word(), word())
    };
    let of_sumo: BTreeSet<Link> = lines.map(link).collect();
    let name = |lane: LaneId| network.lane(lane).id.clone();
    let own = network.connections_from(id).iter();
    let own: BTreeSet<Link> =
        own.map(|way| (name(way.to), way.via.map(name).unwrap_or_default(), way.direction.name().to_owned())).collect();
    let only = |these: &BTreeSet<Link>, others: &BTreeSet<Link>| {
        these
            .difference(others)
            .next()
            .map(|(to, via, direction)| format!("to {to} via \"{via}\", direction {direction}"))
    };
    match (only(&own, &of_sumo), only(&of_sumo, &own)) {
        (Some(own), _) => Some(format!("the connection {own} is not SUMO's")),
        (None, Some(missing)) => Some(format!("SUMO has a connection {missing}")),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_difference_of_a_lane_is_named_with_both_values() {
        let file = Path::new(env!("CODRIVE_ROOT")).join("tests/data/networks/crossing.net.xml");
        let network = Network::load(&file.to_string_lossy()).expect("it can be read");
        let way = network.connections().iter().find(|way| way.via.is_some()).expect("a way across");
        let (id, lane) = (way.from, network.lane(way.from));
        let name = |lane: LaneId| network.lane(lane).id.clone();
        let link = |turn: &str, way: &crate::map::network::Connection| {
            format!("\n{}\t{}\t{turn}", name(way.to), way.via.map(name).unwrap_or_default())
        };
        let links = |turn: &dyn Fn(&'static str) -> &'static str| -> String {
            network.connections_from(id).iter().map(|way| link(turn(way.direction.name()), way)).collect()
        };
        let classes = VehicleClasses::ALL.without(lane.permissions).names().collect::<Vec<_>>().join(" ");
        let of = |length_m: f64, limit_mps: f64, text: String| {
            difference(&network, id, &LaneOfSumo { length_m, limit_mps, text })
        };
        let (length_m, limit_mps) = (lane.length_m, lane.speed_limit_mps);
        let same = classes.clone() + &links(&|turn| turn);
        assert_eq!(of(length_m, limit_mps, same.clone()), None);
        assert!(of(length_m + 1.0, limit_mps, same.clone()).is_some_and(|what| what.starts_with("length, m: ")));
        assert!(of(length_m, 7.5, same).is_some_and(|what| what.ends_with("SUMO has 7.5")));
        let closed = "passenger bus".to_owned() + &links(&|turn| turn);
        assert!(of(length_m, limit_mps, closed).is_some_and(|what| what.starts_with("permissions: ")));
        let turned = classes.clone() + &links(&|_| "t");
        assert!(of(length_m, limit_mps, turned).is_some_and(|what| what.contains("is not SUMO's")));
        let more = classes + &links(&|turn| turn) + "\nelsewhere_0\t\ts";
        assert!(
            of(length_m, limit_mps, more).is_some_and(|what| what.contains("SUMO has a connection to elsewhere_0"))
        );
    }
}
