//! Road signs beside the ends and starts of streets: stop, yield, roundabout, zebra crossing, priority, speed limit, names of streets and
//! places, exits of motorways. In: right of way, speed limits, names and connections of the network. Out: one mesh of plates and poles.
//! `sign_kind` lists the signs, `speed_limits` says which limits they state, `name_signs` where names stand, `stated_signs` which signs the map
//! itself states, `sign_plates` how plates look.
//! Signs and their sizes are German (`docs/references.md: roads`).

use super::{
    name_signs,
    paint::{StopLine, stop_line, yields_to_walkers_alone},
    sign_kind::{MOTORWAY_MPS, Plates, Sign, SignKind, SignedRoads},
    sign_plates::{PlateSize, is_large, plate, size_m},
    signals::pole,
    speed_limits::SpeedLimits,
    stated_signs,
};
use crate::{
    map::{
        network::{Connection, EdgeId, JunctionId, LaneId, LanePosition, LinkState, Network},
        surroundings::BESIDE_M,
    },
    roadside::signal_places::direction,
    scene::{Mesh, mesh::TriangleList},
};
use glam::{Quat, Vec3};
use std::{
    collections::{BTreeMap, BTreeSet},
    f32::consts::PI,
};

/// Height of a sign's lower edge above the road, metres; that of signs with the names of streets, which walkers pass under.
const LOWER_EDGE_M: f32 = 2.0;
const STREET_NAME_EDGE_M: f32 = 2.4;
/// Distance between two plates on a pole, metres.
const BETWEEN_PLATES_M: f32 = 0.04;
/// Half the width of plates that stand on one pole; wider ones stand on two, and further from the road, metres.
const ONE_POLE_M: f32 = 0.6;
/// Distance of stop, yield and priority signs from the end of the lane, metres.
const BEFORE_END_M: f64 = 1.0;
/// Distance of speed-limit signs from the start of the lane, metres: where the limit changes, and where vehicles enter the network, whose
/// drivers would not see a sign at the start.
const AFTER_CHANGE_M: f64 = 6.0;
const AFTER_ENTRY_M: f64 = 40.0;
/// Length of the shortest street with a sign at its start, metres.
const SHORTEST_M: f64 = 20.0;
/// Minimum distance between a sign's pole and any asphalt, metres. Signs nearer to it are left out.
const FREE_M: f32 = 0.4;
/// Length of the longest street that is taken for the lane of an exit, and length of that lane beside a longer street, metres.
const LONGEST_EXIT_LANE_M: f64 = 600.0;
const EXIT_LANE_M: f64 = 250.0;
/// Distance of the board of an exit from the start of the exit's lane, metres.
const AFTER_EXIT_LANE_M: f64 = 20.0;

impl<'net> SignedRoads<'net> {
    /// Returns all signs of the network.
    pub(super) fn signs(&self) -> Vec<Sign<'net>> {
        let net = self.net;
        let limits = SpeedLimits::of(net);
        let yielding = yielding_junctions(net);
        let mut signs = name_signs::street_names(self);
        for edge in net.edge_ids() {
            let driven = || net.edge(edge).lanes().filter(|lane| net.is_driven(*lane));
            let Some(outermost) = driven().next() else { continue };
            let length_m = net.lane(outermost).line.drawn_m();
            // Where several lanes have different rules, the strictest holds for the sign.
            let rules: Vec<SignKind> = driven().filter_map(|lane| rule(net, lane, &yielding)).collect();
            let order = [SignKind::Stop, SignKind::Yield, SignKind::Zebra, SignKind::Priority];
            if let Some(strictest) = order.into_iter().find(|kind| rules.contains(kind)) {
                let enters = strictest == SignKind::Yield && enters_roundabout(net, outermost);
                let below = enters.then_some(SignKind::Roundabout);
                signs.extend(self.sign((strictest, below), outermost, length_m - BEFORE_END_M));
            }
            let limit = limits.sign_at_start(net, edge);
            let row = if limits.is_entry(edge) { AFTER_ENTRY_M.min(length_m / 2.0) } else { AFTER_CHANGE_M };
            let place = name_signs::place_name(self, outermost, &limits);
            if let (Some(kind), true) = (place.or(limit), length_m >= SHORTEST_M) {
                signs.extend(self.sign((kind, place.and(limit)), outermost, row));
            }
            if let Some(onto) = exit(net, edge) {
                signs.extend(self.exit_signs(outermost, onto));
            }
        }
        stated_signs::add_stated(self, &mut signs);
        signs
    }

    /// Returns the signs of an exit from a street's outermost lane: three beacons before the lane for the exit, a board at that lane, and a
    /// sign where the roads part.
    fn exit_signs(&self, outermost: LaneId, onto: LaneId) -> Vec<Sign<'net>> {
        let net = self.net;
        let mut signs = Vec::new();
        let length_m = |lane: LaneId| net.lane(lane).line.drawn_m();
        // A short street is the part with the lane for the exit.
        let street = net.lane(outermost).edge;
        let leads_here = |way: &&Connection| net.lane(way.to).edge == street && net.is_driven(way.from);
        let before = net.connections().iter().find(leads_here).map(|way| way.from);
        let (street, start_m, board_m) = match before {
            Some(from) if length_m(outermost) < LONGEST_EXIT_LANE_M => {
                let driven = net.edge_of(from).lanes().find(|lane| net.is_driven(*lane));
                let from = driven.unwrap_or(from);
                (from, length_m(from), 0.0)
            }
            _ => (outermost, length_m(outermost) - EXIT_LANE_M, length_m(outermost) - EXIT_LANE_M),
        };
        for hundreds in 1..=3 {
            let row = start_m - 100.0 * f64::from(hundreds);
            if row > 0.0 {
                signs.extend(self.sign((SignKind::ExitAhead(hundreds), None), street, row));
            }
        }
        let board = SignKind::ExitBoard(name_signs::name_beyond(net, onto));
        signs.extend(self.first_free((board, None), outermost, board_m.max(0.0) + AFTER_EXIT_LANE_M));
        // Of an exit with several lanes, the one beside the motorway.
        let onto = net.edge_of(onto).lanes().rfind(|lane| net.is_driven(*lane)).unwrap_or(onto);
        signs.extend(self.first_free((SignKind::Exit, None), onto, 2.0));
        signs
    }

    /// Returns a sign at the first free place beside a lane from a row on, in steps of 2 m, at most 80 m further.
    pub(super) fn first_free(&self, plates: Plates<'net>, lane: LaneId, row: f64) -> Option<Sign<'net>> {
        let rows = (0..40).map(|k| row + 2.0 * f64::from(k));
        let mut rows = rows.take_while(|row| *row < self.net.lane(lane).line.drawn_m());
        rows.find_map(|row| self.sign(plates, lane, row))
    }

    /// Returns a sign, with another below it, beside a street's outermost lane, on the right, or on the left with left-hand traffic; that of an
    /// exit stands on the other side, between the roads. `None` if there is no free place.
    fn sign(&self, (kind, below): Plates<'net>, lane: LaneId, row: f64) -> Option<Sign<'net>> {
        let net = self.net;
        let of = net.lane(lane);
        let side = if net.is_left_hand() != (kind == SignKind::Exit) { 1.0 } else { -1.0 };
        let s_m = row.max(0.0) / of.line.drawn_m().max(0.01) * of.length_m;
        let faces_across = matches!(kind, SignKind::StreetName(_));
        let PlateSize { half_width_m, .. } = size_m(kind, is_large(kind, of.speed_limit_mps));
        let wider_m = if faces_across { 0.0 } else { f64::from((half_width_m - ONE_POLE_M).max(0.0)) };
        let beside = LanePosition { lane, s_m, offset_m: side * (of.half_width_m() + BESIDE_M + wider_m) };
        let foot = net.pose(beside);
        let position = foot.position.as_vec3();
        let has_pavement = net.edge_of(lane).lanes().any(|lane| net.lane(lane).is_footway());
        let is_free = has_pavement || self.surfaces.border_m(position.truncate()) > FREE_M;
        let back = -direction(&foot);
        let facing = if faces_across { back.truncate().perp().extend(0.0) } else { back };
        is_free.then_some(Sign { kind, below, lane, foot: position, facing })
    }

    /// Returns the mesh of all signs.
    pub(in crate::scene) fn mesh(&self) -> Mesh {
        // Welding corners takes most of the time, so it is done once for equal signs.
        let mut models: BTreeMap<(Plates, bool), Mesh> = BTreeMap::new();
        let mut mesh = Mesh::default();
        for Sign { kind, below, lane, foot, facing } in self.signs() {
            let is_large = is_large(kind, self.net.lane(lane).speed_limit_mps);
            let new = || model((kind, below), is_large, self.net.is_left_hand());
            let model = models.entry(((kind, below), is_large)).or_insert_with(new);
            mesh.append_placed(model, Quat::from_rotation_z(facing.y.atan2(facing.x)), foot);
        }
        mesh
    }
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

/// Checks whether a lane leads into a roundabout from outside.
fn enters_roundabout(net: &Network, lane: LaneId) -> bool {
    !name_signs::is_in_roundabout(net, net.lane(lane).edge)
        && net.connections_from(lane).iter().any(|way| name_signs::is_in_roundabout(net, net.lane(way.to).edge))
}

/// Returns a sign with its poles. It stands at the origin and faces along +x.
fn model((kind, below): Plates, is_large: bool, is_left_hand: bool) -> Mesh {
    let is_street_name = matches!(kind, SignKind::StreetName(_));
    let (mut edge_m, mut half_width_m) = (if is_street_name { STREET_NAME_EDGE_M } else { LOWER_EDGE_M }, 0.0f32);
    let mut triangles = TriangleList::default();
    for kind in below.into_iter().chain([kind]) {
        let size = size_m(kind, is_large);
        let plate = plate(kind, size, is_left_hand).moved(|p| p + Vec3::Z * (edge_m + size.half_height_m));
        if is_street_name {
            // Another plate, back to back.
            triangles.append(plate.clone().moved(|p| Quat::from_rotation_z(PI) * p - Vec3::X * 0.02));
        }
        triangles.append(plate);
        edge_m += 2.0 * size.half_height_m + BETWEEN_PLATES_M;
        half_width_m = half_width_m.max(size.half_width_m);
    }
    let top_m = edge_m - BETWEEN_PLATES_M;
    match (is_street_name, half_width_m > ONE_POLE_M) {
        (true, _) => pole(&mut triangles, Vec3::NEG_X * 0.01, STREET_NAME_EDGE_M),
        (false, false) => pole(&mut triangles, Vec3::NEG_X * 0.08, top_m),
        (false, true) => [-0.6, 0.6].into_iter().for_each(|share| {
            pole(&mut triangles, Vec3::new(-0.08, share * half_width_m, 0.0), top_m);
        }),
    }
    triangles.into_mesh(0.3)
}

/// Returns the sign of right of way at the end of a lane; `None` at signals, and where no road goes before the others.
fn rule(net: &Network, lane: LaneId, yielding: &BTreeSet<JunctionId>) -> Option<SignKind<'static>> {
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
    let goes_round = || name_signs::is_in_roundabout(net, net.lane(lane).edge);
    (goes_first && !is_motorway && !goes_round()).then_some(SignKind::Priority)
}

/// Returns the junctions at which all who come from some lane yield or stop.
fn yielding_junctions(net: &Network) -> BTreeSet<JunctionId> {
    let lanes = net.lane_ids().filter(|lane| net.is_driven(*lane) && stop_line(net, *lane).is_some());
    lanes.filter_map(|lane| net.junction_after(lane)).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::{
        map::RoadMap,
        roadside::{road_ends, road_surfaces::RoadSurfaces, town::Town},
        scene::mesh::tests::check,
        space::Pose3,
    };

    pub(in crate::scene::network) fn network(name: &str) -> Network {
        Network::load(&format!("tests/data/networks/{name}.net.xml")).expect("a network of the tests")
    }

    /// Calls a function with the roads of a network whose town has this name.
    pub(in crate::scene::network) fn with_roads<T>(
        net: &Network,
        place: Option<&str>,
        of: impl FnOnce(&SignedRoads) -> T,
    ) -> T {
        let (surfaces, town) = (RoadSurfaces::of(net), Town::of(net));
        let longer = road_ends::running_on(net, &surfaces).0;
        let drawn = longer.as_ref().unwrap_or(net);
        of(&SignedRoads { net, drawn, surfaces: &surfaces, town: &town, place })
    }

    #[test]
    fn signs_say_who_goes_first_and_where_limits_change() {
        use SignKind::{Exit, ExitAhead, ExitBoard, Priority, SpeedLimit, Stop, Yield, Zebra};
        // Counted by hand from the right of way (`state`) and the speeds in the files.
        let counts: [(&str, &[(SignKind, usize)]); 5] = [
            ("crossing", &[(Priority, 2), (Yield, 2), (SpeedLimit(50), 4)]),
            ("allway", &[(Stop, 4), (SpeedLimit(50), 4)]),
            ("roundabout", &[(Yield, 4), (SpeedLimit(50), 4)]),
            ("zebra", &[(Zebra, 2), (SpeedLimit(50), 2)]),
            // Both ways onto the motorway, the motorway after the entry, and the exit, with 292 m of road before its lane.
            // Its roads have no names.
            (
                "ramps",
                &[
                    (SpeedLimit(120), 2),
                    (SpeedLimit(80), 2),
                    (ExitAhead(1), 1),
                    (ExitAhead(2), 1),
                    (ExitBoard(None), 1),
                    (Exit, 1),
                ],
            ),
        ];
        for (name, counts) in counts {
            let net = network(name);
            with_roads(&net, None, |roads| {
                let signs = roads.signs();
                for (kind, count) in counts {
                    assert_eq!(signs.iter().filter(|sign| sign.kind == *kind).count(), *count, "{name}: {kind:?}");
                }
                assert_eq!(signs.len(), counts.iter().map(|(_, count)| count).sum::<usize>(), "{name}: {signs:?}");
                // All who yield there enter a roundabout.
                let round = if name == "roundabout" { 4 } else { 0 };
                assert_eq!(signs.iter().filter(|sign| sign.below.is_some()).count(), round, "{name}");
                let is_round = |sign: &&Sign| sign.below == Some(SignKind::Roundabout) && sign.kind == Yield;
                assert_eq!(signs.iter().filter(is_round).count(), round, "{name}");
            });
        }
        // Signals rule there, no vehicle enters the network, and 13.9 m/s is the limit everywhere.
        let net = network("grid-signals");
        with_roads(&net, None, |roads| assert!(roads.signs().is_empty()));
    }

    #[test]
    fn an_exit_has_three_beacons_and_a_sign_where_the_roads_part() {
        let net = RoadMap::load("motorway").expect("a shipped map").network;
        with_roads(&net, None, |roads| exit_signs_stand_in_order(&net, &roads.signs()));
    }

    fn exit_signs_stand_in_order(net: &Network, signs: &[Sign]) {
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
        // The board is at the lane for the exit, within the first 100 m.
        let boards: Vec<&Sign> = signs.iter().filter(|sign| sign.kind == SignKind::ExitBoard(None)).collect();
        let [board] = boards[..] else { panic!("{signs:?}") };
        let lane = net.lane(board.lane);
        let from_end_m = f64::from(away_m(board));
        assert!(!lane.id.starts_with("middle") && lane.length_m - from_end_m < 100.0, "{board:?}");
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
            with_roads(&net, None, |roads| {
                let signs = roads.signs();
                assert!(!signs.is_empty(), "{name}");
                signs.iter().for_each(|sign| stands_beside(&net, sign));
                check(&roads.mesh(), name);
            });
        }
    }

    fn stands_beside(net: &Network, sign: &Sign) {
        let lane = net.lane(sign.lane);
        let poses = (0..=(lane.length_m * 4.0) as u32).map(|k| lane.line.pose(f64::from(k) / 4.0, 0.0));
        let off_m = |pose: &Pose3| pose.position.as_vec3().distance(sign.foot);
        let beside = poses.min_by(|a, b| off_m(a).total_cmp(&off_m(b))).expect("a lane has poses");
        // On the right of the lane, or on the left with left-hand traffic.
        let ahead = direction(&beside).truncate();
        let left_m = ahead.perp_dot((sign.foot - beside.position.as_vec3()).truncate());
        let is_exit = sign.kind == SignKind::Exit;
        assert!((left_m > 0.0) == (net.is_left_hand() != is_exit), "{sign:?} {left_m}");
        assert!(left_m.abs() > lane.half_width_m() as f32 + 0.5, "{sign:?} {left_m}");
        // Those who drive along read a sign; those who cross read the name of a street.
        let is_across = matches!(sign.kind, SignKind::StreetName(_));
        let (least, most) = if is_across { (-0.1, 0.1) } else { (-1.0, -0.99) };
        assert!((least..=most).contains(&sign.facing.truncate().dot(ahead)), "{sign:?}");
    }
}
