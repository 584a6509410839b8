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
        if let Some(what) = difference(network, lane, &shim)? {
            return Err(differs(format!("lane {}: {what}", network.lane(lane).id)));
        }
    }
    Ok(EqualReading { lanes, connections: network.connections().len() })
}

/// Returns the first difference of a lane.
fn difference(network: &Network, id: LaneId, shim: &Shim) -> Result<Option<String>, TrafficError> {
    let lane = network.lane(id);
    let (length_m, limit_mps) = shim.lane(id)?;
    for (what, own, of_sumo) in
        [("length, m", lane.length_m, length_m), ("speed limit, m/s", lane.speed_limit_mps, limit_mps)]
    {
        if (own - of_sumo).abs() > EQUAL {
            return Ok(Some(format!("{what}: {own}, SUMO has {of_sumo}")));
        }
    }
    let text = shim.lane_text(id)?;
    let mut lines = text.lines();
    let of_sumo = VehicleClasses::ALL.without(VehicleClasses::parse(lines.next().unwrap_or_default()));
    if lane.permissions != of_sumo {
        return Ok(Some(format!("permissions: {}, SUMO has {}", lane.permissions.list(), of_sumo.list())));
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
    Ok(match (only(&own, &of_sumo), only(&of_sumo, &own)) {
        (Some(own), _) => Some(format!("the connection {own} is not SUMO's")),
        (None, Some(missing)) => Some(format!("SUMO has a connection {missing}")),
        (None, None) => None,
    })
}
