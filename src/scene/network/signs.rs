//! Road signs beside the ends and starts of streets: stop, yield, zebra crossing, priority, speed limit, exits of motorways. In: right of way,
//! speed limits and connections of the network. Out: one mesh of plates and poles. Signs and their sizes are German (`docs/references.md: roads`).

use super::{
    paint::{StopLine, stop_line, yields_to_walkers_alone},
    sign_plates::{is_large, plate, size_m},
    signals::{BESIDE_M, direction, pole},
};
use crate::{
    map::network::{Connection, EdgeId, JunctionId, LaneId, LanePosition, LinkState, Network},
    roadside::road_surfaces::RoadSurfaces,
    scene::Mesh,
    units::MPS_PER_KMH,
};
use glam::{Quat, Vec3};
use std::collections::{BTreeMap, BTreeSet};

/// Height of a sign's lower edge above the road, metres.
const LOWER_EDGE_M: f32 = 2.0;
/// Distance of stop, yield and priority signs from the end of the lane, metres.
const BEFORE_END_M: f64 = 1.0;
/// Distance of speed-limit signs from the start of the lane, metres: where the limit changes, and where vehicles enter the network, whose
/// drivers would not see a sign at the start.
const AFTER_CHANGE_M: f64 = 6.0;
const AFTER_ENTRY_M: f64 = 40.0;
/// Length of the shortest street with a speed-limit sign, metres.
const SHORTEST_M: f64 = 20.0;
/// Minimum distance between a sign's pole and any asphalt, metres. Signs nearer to it are left out.
const FREE_M: f32 = 0.4;
/// Signs state limits in tens of km/h. A road whose limit differs by more than this has none, km/h.
const ROUNDED_KMH: f64 = 0.6;
/// Speed limit above which junctions have no priority signs, m/s: 100 km/h. Such roads are motorways.
pub(super) const MOTORWAY_MPS: f64 = 28.0;
/// Length of the longest street that is taken for the lane of an exit, and length of that lane beside a longer street, metres.
const LONGEST_EXIT_LANE_M: f64 = 600.0;
const EXIT_LANE_M: f64 = 250.0;

/// Kind of a sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum SignKind {
    /// Sign 206: stop and yield.
    Stop,
    /// Sign 205: yield.
    Yield,
    /// Sign 350: zebra crossing.
    Zebra,
    /// Sign 301: priority at the next junction.
    Priority,
    /// Sign 274: speed limit, km/h.
    SpeedLimit(u32),
    /// Sign 333 without its word: exit.
    Exit,
    /// Sign 450: so many hundred metres to the lane of an exit, 1 to 3.
    ExitAhead(u32),
}

/// Sign beside a lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sign {
    pub kind: SignKind,
    /// Outermost lane of the street.
    pub lane: LaneId,
    /// Foot of the pole, world axes, metres.
    pub foot: Vec3,
    /// Direction in which the sign faces, towards those who drive there, a unit vector.
    pub facing: Vec3,
}

/// Returns all signs of a network.
pub(super) fn placed(net: &Network, surfaces: &RoadSurfaces) -> Vec<Sign> {
    let before = limits_before(net);
    let yielding = yielding_junctions(net);
    let mut signs = Vec::new();
    for edge in net.edge_ids() {
        let driven = || net.edge(edge).lanes().filter(|lane| net.is_driven(*lane));
        let Some(outermost) = driven().next() else { continue };
        let length_m = net.lane(outermost).line.drawn_m();
        let mut add = |kind: SignKind, row: f64| signs.extend(sign(net, kind, outermost, row, surfaces));
        // Where several lanes have different rules, the strictest holds for the sign.
        let rules: Vec<SignKind> = driven().filter_map(|lane| rule(net, lane, &yielding)).collect();
        let order = [SignKind::Stop, SignKind::Yield, SignKind::Zebra, SignKind::Priority];
        if let Some(strictest) = order.into_iter().find(|kind| rules.contains(kind)) {
            add(strictest, length_m - BEFORE_END_M);
        }
        let limit = limit_kmh(net, edge);
        let before = before.get(&edge);
        let changes = before.is_none_or(|before| before.iter().any(|before| Some(*before) != limit));
        if let (Some(limit), true, true) = (limit, changes, length_m >= SHORTEST_M) {
            let row = if before.is_some() { AFTER_CHANGE_M } else { AFTER_ENTRY_M.min(length_m / 2.0) };
            add(SignKind::SpeedLimit(limit), row);
        }
        if let Some(onto) = exit(net, edge) {
            signs.extend(exit_signs(net, outermost, onto, surfaces));
        }
    }
    signs
}

/// Returns the first lane of the road on which one leaves a motorway at the end of a street.
fn exit(net: &Network, edge: EdgeId) -> Option<LaneId> {
    let lanes: Vec<LaneId> = net.edge(edge).lanes().filter(|lane| net.is_driven(*lane)).collect();
    let onto = |lane: LaneId| net.connections_from(lane).iter().map(|way| way.to).next();
    let ([leaving, .., staying], true) = (&lanes[..], net.lane(lanes.first().copied()?).speed_limit_mps > MOTORWAY_MPS)
    else {
        return None;
    };
    let [leaving, staying] = [onto(*leaving)?, onto(*staying)?];
    let is_slower = net.lane(leaving).speed_limit_mps < net.lane(staying).speed_limit_mps;
    (net.lane(leaving).edge != net.lane(staying).edge && is_slower).then_some(leaving)
}

/// Returns the signs of an exit from a street's outermost lane: three beacons before the lane for the exit, and a sign where the roads part.
fn exit_signs(net: &Network, outermost: LaneId, onto: LaneId, surfaces: &RoadSurfaces) -> Vec<Sign> {
    let mut signs = Vec::new();
    let length_m = |lane: LaneId| net.lane(lane).line.drawn_m();
    // A short street is the part with the lane for the exit.
    let street = net.lane(outermost).edge;
    let leads_here = |way: &&Connection| net.lane(way.to).edge == street && net.is_driven(way.from);
    let before = net.connections().iter().find(leads_here).map(|way| way.from);
    let (street, start_m) = match before {
        Some(from) if length_m(outermost) < LONGEST_EXIT_LANE_M => {
            let driven = net.edge_of(from).lanes().find(|lane| net.is_driven(*lane));
            let from = driven.unwrap_or(from);
            (from, length_m(from))
        }
        _ => (outermost, length_m(outermost) - EXIT_LANE_M),
    };
    for hundreds in 1..=3 {
        let row = start_m - 100.0 * f64::from(hundreds);
        if row > 0.0 {
            signs.extend(sign(net, SignKind::ExitAhead(hundreds), street, row, surfaces));
        }
    }
    // Of an exit with several lanes, the one beside the motorway.
    let onto = net.edge_of(onto).lanes().rfind(|lane| net.is_driven(*lane)).unwrap_or(onto);
    let rows = (1..40).map(|k| 2.0 * f64::from(k)).take_while(|row| *row < length_m(onto));
    signs.extend(rows.filter_map(|row| sign(net, SignKind::Exit, onto, row, surfaces)).next());
    signs
}

/// Returns the mesh of all signs of a network.
pub(in crate::scene) fn signs(net: &Network, surfaces: &RoadSurfaces) -> Mesh {
    // Welding corners takes most of the time, so it is done once for equal signs.
    let mut models: BTreeMap<(SignKind, bool), Mesh> = BTreeMap::new();
    let mut mesh = Mesh::default();
    for sign in placed(net, surfaces) {
        let is_large = is_large(sign.kind, net.lane(sign.lane).speed_limit_mps);
        let model = models.entry((sign.kind, is_large)).or_insert_with(|| model(sign.kind, is_large));
        mesh.append_placed(model, Quat::from_rotation_z(sign.facing.y.atan2(sign.facing.x)), sign.foot);
    }
    mesh
}

/// Returns a sign with its pole. It stands at the origin and faces along +x.
fn model(kind: SignKind, is_large: bool) -> Mesh {
    let (plate, half_height_m) = plate(kind, size_m(kind, is_large));
    let mut triangles = plate.moved(|p| p + Vec3::Z * (LOWER_EDGE_M + half_height_m));
    pole(&mut triangles, Vec3::NEG_X * 0.08, LOWER_EDGE_M + 2.0 * half_height_m);
    triangles.into_mesh(0.3)
}

/// Returns the sign of right of way at the end of a lane; `None` at signals, and where no road goes before the others.
fn rule(net: &Network, lane: LaneId, yielding: &BTreeSet<JunctionId>) -> Option<SignKind> {
    let ways = || net.connections_from(lane).iter().filter(|way| !way.is_turnaround());
    if ways().any(|way| way.signal.is_some()) {
        return None;
    }
    match stop_line(net, lane) {
        Some(StopLine::Solid) => return Some(SignKind::Stop),
        Some(StopLine::Broken) => return Some(SignKind::Yield),
        None if yields_to_walkers_alone(net, lane) => return Some(SignKind::Zebra),
        None => {}
    }
    let goes_first = yielding.contains(&net.junction_after(lane)?)
        && ways().any(|way| way.state == LinkState::Major)
        && ways().all(|way| matches!(way.state, LinkState::Major | LinkState::Minor));
    let is_motorway = net.lane(lane).speed_limit_mps > MOTORWAY_MPS;
    // Those within a roundabout know that they go first.
    let goes_round = || net.roundabouts().iter().any(|roundabout| roundabout.edges.contains(&net.lane(lane).edge));
    (goes_first && !is_motorway && !goes_round()).then_some(SignKind::Priority)
}

/// Returns the junctions at which all who come from some lane yield or stop.
fn yielding_junctions(net: &Network) -> BTreeSet<JunctionId> {
    let lanes = net.lane_ids().filter(|lane| net.is_driven(*lane) && stop_line(net, *lane).is_some());
    lanes.filter_map(|lane| net.junction_after(lane)).collect()
}

/// Returns the speed limit of a street as signs state it, km/h; `None` if it is not a multiple of ten.
fn limit_kmh(net: &Network, edge: EdgeId) -> Option<u32> {
    let lane = net.edge(edge).lanes().find(|lane| net.is_driven(*lane) && net.lane(*lane).admits_cars())?;
    let limit_kmh = net.lane(lane).speed_limit_mps / MPS_PER_KMH;
    let tens = (limit_kmh / 10.0).round() * 10.0;
    ((limit_kmh - tens).abs() < ROUNDED_KMH && tens > 0.0).then_some(tens as u32)
}

/// Returns the limits of the streets from which cars come into each street, km/h; 0 for a limit that no sign states. Streets where vehicles
/// enter the network are left out.
fn limits_before(net: &Network) -> BTreeMap<EdgeId, BTreeSet<u32>> {
    let mut before: BTreeMap<EdgeId, BTreeSet<u32>> = BTreeMap::new();
    for lane in net.lane_ids().filter(|lane| net.is_driven(*lane)) {
        let limit = limit_kmh(net, net.lane(lane).edge).unwrap_or(0);
        for way in net.connections_from(lane).iter().filter(|way| !way.is_turnaround()) {
            before.entry(net.lane(way.to).edge).or_default().insert(limit);
        }
    }
    before
}

/// Returns a sign beside a street's outermost lane, on the right, or on the left with left-hand traffic; that of an exit stands on the other
/// side, between the roads. `None` if there is no free place.
fn sign(net: &Network, kind: SignKind, lane: LaneId, row: f64, surfaces: &RoadSurfaces) -> Option<Sign> {
    let of = net.lane(lane);
    let side = if net.is_left_hand() != (kind == SignKind::Exit) { 1.0 } else { -1.0 };
    let s_m = row.max(0.0) / of.line.drawn_m().max(0.01) * of.length_m;
    let beside = LanePosition { lane, s_m, offset_m: side * (of.half_width_m() + BESIDE_M) };
    let foot = net.pose(beside);
    let position = foot.position.as_vec3();
    let has_pavement = net.edge_of(lane).lanes().any(|lane| net.lane(lane).is_footway());
    let is_free = has_pavement || surfaces.border_m(position.truncate()) > FREE_M;
    is_free.then_some(Sign { kind, lane, foot: position, facing: -direction(&foot) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{map::RoadMap, scene::mesh::tests::check, space::Pose3};

    fn network(name: &str) -> Network {
        Network::load(&format!("tests/data/networks/{name}.net.xml")).expect("a network of the tests")
    }

    #[test]
    fn signs_say_who_goes_first_and_where_limits_change() {
        use SignKind::{Exit, ExitAhead, Priority, SpeedLimit, Stop, Yield, Zebra};
        // Counted by hand from the right of way (`state`) and the speeds in the files.
        let counts: [(&str, &[(SignKind, usize)]); 5] = [
            ("crossing", &[(Priority, 2), (Yield, 2), (SpeedLimit(50), 4)]),
            ("allway", &[(Stop, 4), (SpeedLimit(50), 4)]),
            ("roundabout", &[(Yield, 4), (SpeedLimit(50), 4)]),
            ("zebra", &[(Zebra, 2), (SpeedLimit(50), 2)]),
            // Both ways onto the motorway, the motorway after the entry, and the exit, with 292 m of road before its lane.
            ("ramps", &[(SpeedLimit(120), 2), (SpeedLimit(80), 2), (ExitAhead(1), 1), (ExitAhead(2), 1), (Exit, 1)]),
        ];
        for (name, counts) in counts {
            let net = network(name);
            let signs = placed(&net, &RoadSurfaces::of(&net));
            for (kind, count) in counts {
                assert_eq!(signs.iter().filter(|sign| sign.kind == *kind).count(), *count, "{name}: {kind:?}");
            }
            assert_eq!(signs.len(), counts.iter().map(|(_, count)| count).sum::<usize>(), "{name}: {signs:?}");
        }
        // Signals rule there, no vehicle enters the network, and 13.9 m/s is the limit everywhere.
        let net = network("grid-signals");
        assert!(placed(&net, &RoadSurfaces::of(&net)).is_empty());
    }

    #[test]
    fn an_exit_has_three_beacons_and_a_sign_where_the_roads_part() {
        let net = RoadMap::load("motorway").expect("a shipped map").network;
        let signs = placed(&net, &RoadSurfaces::of(&net));
        let away_m = |sign: &Sign| {
            let line = &net.lane(sign.lane).line;
            line.pose(line.drawn_m(), 0.0).position.as_vec3().distance(sign.foot)
        };
        for hundreds in 1..=3 {
            let beacons: Vec<&Sign> = signs.iter().filter(|sign| sign.kind == SignKind::ExitAhead(hundreds)).collect();
            let [beacon] = beacons[..] else { panic!("{hundreds}: {signs:?}") };
            assert!(net.lane(beacon.lane).id.starts_with("middle"), "{beacon:?}");
            // The last 500 m before the lane of the exit are straight; beacons stand 3 m beside it, and lanes in a bend are longer or shorter
            // than their road.
            assert!((away_m(beacon) - 100.0 * hundreds as f32).abs() < 3.0, "{beacon:?}: {} m", away_m(beacon));
        }
        let shown: Vec<&Sign> = signs.iter().filter(|sign| sign.kind == SignKind::Exit).collect();
        let [shown] = shown[..] else { panic!("{signs:?}") };
        // Between the exit, to its right, and the motorway, to its left, in the first 90 m.
        let beside_m = |lane: &str| {
            let lane = net.lane_ids().find(|id| &*net.lane(*id).id == lane).expect("a lane");
            let poses = (0..90).map(|s_m| net.lane(lane).line.pose(f64::from(s_m), 0.0));
            let off_m = |pose: &Pose3| pose.position.as_vec3().distance(shown.foot);
            let nearest = poses.min_by(|a, b| off_m(a).total_cmp(&off_m(b))).expect("poses");
            direction(&nearest).truncate().perp_dot((shown.foot - nearest.position.as_vec3()).truncate())
        };
        assert!(beside_m("off_0") > 2.0 && beside_m("north_0") < -2.0, "{shown:?}");
    }

    #[test]
    fn signs_stand_beside_the_road_and_face_those_who_come() {
        for name in ["crossing", "town", "town-left", "random-3", "hill", "ramps"] {
            let net = network(name);
            let surfaces = RoadSurfaces::of(&net);
            let signs = placed(&net, &surfaces);
            assert!(!signs.is_empty(), "{name}");
            for sign in signs {
                let lane = net.lane(sign.lane);
                let poses = (0..=(lane.length_m * 4.0) as u32).map(|k| lane.line.pose(f64::from(k) / 4.0, 0.0));
                let off_m = |pose: &Pose3| pose.position.as_vec3().distance(sign.foot);
                let beside = poses.min_by(|a, b| off_m(a).total_cmp(&off_m(b))).expect("a lane has poses");
                // On the right of the lane, or on the left with left-hand traffic.
                let ahead = direction(&beside).truncate();
                let left_m = ahead.perp_dot((sign.foot - beside.position.as_vec3()).truncate());
                let is_exit = sign.kind == SignKind::Exit;
                assert!((left_m > 0.0) == (net.is_left_hand() != is_exit), "{name}: {sign:?} {left_m}");
                assert!(left_m.abs() > lane.half_width_m() as f32 + 0.5, "{name}: {sign:?} {left_m}");
                assert!(sign.facing.truncate().dot(ahead) < -0.99, "{name}: {sign:?}");
            }
            check(&super::signs(&net, &surfaces), name);
        }
    }
}
