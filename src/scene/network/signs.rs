//! Road signs beside the ends and starts of streets: stop, yield, zebra crossing, priority, speed limit. In: right of way and speed limits
//! of the network. Out: one mesh of plates and poles. Signs and their sizes are German (`docs/references.md: roads`).

use super::{
    paint::{StopLine, is_driven, stop_line, yields_to_walkers_alone},
    road_surfaces::RoadSurfaces,
    signals::{BESIDE_M, STEEL, direction, pole},
};
use crate::{
    hud::lettering,
    map::network::{EdgeId, JunctionId, LaneId, LanePosition, LinkState, Network},
    scene::{
        Material, Mesh,
        car::number_plate::thinned,
        mesh::{SurfaceFinish, TriangleList},
    },
    units::MPS_PER_KMH,
};
use glam::{Quat, Vec2, Vec3};
use std::{
    collections::{BTreeMap, BTreeSet},
    f32::consts::{PI, SQRT_2, TAU},
};

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
const MOTORWAY_MPS: f64 = 28.0;
/// Distance between plate and lettering, metres: at 80 m the depth buffer still tells them apart.
const RAISED_M: f32 = 0.015;
/// Tolerance for omitted points of letters, as a share of their height.
const COARSE: f32 = 0.02;

const RED: SurfaceFinish = SurfaceFinish::new(Material::Reflector, [0.42, 0.012, 0.012]);
const WHITE: SurfaceFinish = SurfaceFinish::grey(Material::Reflector, 0.72);
const YELLOW: SurfaceFinish = SurfaceFinish::new(Material::Reflector, [0.72, 0.42, 0.01]);
const BLUE: SurfaceFinish = SurfaceFinish::new(Material::Reflector, [0.012, 0.07, 0.33]);
const BLACK: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.012);

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
        let driven = || net.edge(edge).lanes().filter(|lane| is_driven(net, *lane));
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
    }
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
    let lanes = net.lane_ids().filter(|lane| is_driven(net, *lane) && stop_line(net, *lane).is_some());
    lanes.filter_map(|lane| net.junction_after(lane)).collect()
}

/// Returns the speed limit of a street as signs state it, km/h; `None` if it is not a multiple of ten.
fn limit_kmh(net: &Network, edge: EdgeId) -> Option<u32> {
    let lane = net.edge(edge).lanes().find(|lane| is_driven(net, *lane) && net.lane(*lane).admits_cars())?;
    let limit_kmh = net.lane(lane).speed_limit_mps / MPS_PER_KMH;
    let tens = (limit_kmh / 10.0).round() * 10.0;
    ((limit_kmh - tens).abs() < ROUNDED_KMH && tens > 0.0).then_some(tens as u32)
}

/// Returns the limits of the streets from which cars come into each street, km/h; 0 for a limit that no sign states. Streets where vehicles
/// enter the network are left out.
fn limits_before(net: &Network) -> BTreeMap<EdgeId, BTreeSet<u32>> {
    let mut before: BTreeMap<EdgeId, BTreeSet<u32>> = BTreeMap::new();
    for lane in net.lane_ids().filter(|lane| is_driven(net, *lane)) {
        let limit = limit_kmh(net, net.lane(lane).edge).unwrap_or(0);
        for way in net.connections_from(lane).iter().filter(|way| !way.is_turnaround()) {
            before.entry(net.lane(way.to).edge).or_default().insert(limit);
        }
    }
    before
}

/// Returns a sign beside a street's outermost lane, on the right, or on the left with left-hand traffic; `None` if there is no free place.
fn sign(net: &Network, kind: SignKind, lane: LaneId, row: f64, surfaces: &RoadSurfaces) -> Option<Sign> {
    let of = net.lane(lane);
    let side = if net.is_left_hand() { 1.0 } else { -1.0 };
    let s_m = row.max(0.0) / of.line.drawn_m().max(0.01) * of.length_m;
    let beside = LanePosition { lane, s_m, offset_m: side * (of.half_width_m() + BESIDE_M) };
    let foot = net.pose(beside);
    let position = foot.position.as_vec3();
    let has_pavement = net.edge_of(lane).lanes().any(|lane| net.lane(lane).is_footway());
    let is_free = has_pavement || surfaces.border_m(position.truncate()) > FREE_M;
    is_free.then_some(Sign { kind, lane, foot: position, facing: -direction(&foot) })
}

/// Returns true for the larger signs of fast roads: discs above 80 km/h, triangles and squares above 100 km/h, with a margin for rounding.
fn is_large(kind: SignKind, limit_mps: f64) -> bool {
    match kind {
        SignKind::Stop => false,
        SignKind::SpeedLimit(_) => limit_mps > 22.5,
        SignKind::Yield | SignKind::Zebra | SignKind::Priority => limit_mps > MOTORWAY_MPS,
    }
}

/// Returns the size of a sign: the diameter of discs and octagons, the side of triangles and squares, metres.
fn size_m(kind: SignKind, is_large: bool) -> f32 {
    match (kind, is_large) {
        (SignKind::Stop, _) | (SignKind::Yield, false) => 0.9,
        (SignKind::Yield, true) => 1.26,
        (SignKind::Zebra | SignKind::Priority, true) => 0.84,
        (SignKind::SpeedLimit(_), true) => 0.75,
        (SignKind::Zebra | SignKind::Priority | SignKind::SpeedLimit(_), false) => 0.6,
    }
}

/// Returns a plate around its middle that faces along +x, and half its height, metres. Seen from before it, +y is to the right.
fn plate(kind: SignKind, size_m: f32) -> (TriangleList, f32) {
    let mut plate = Plate::default();
    let round = |radius_m: f32, corners: usize, turn: f32| -> Vec<Vec2> {
        let angle = |k: usize| TAU * (k as f32 + turn) / corners as f32;
        (0..corners).map(|k| Vec2::from_angle(angle(k)) * radius_m).collect()
    };
    let half_m = size_m / 2.0;
    let half_height_m = match kind {
        SignKind::Stop => {
            // The diameter is that between two parallel sides.
            let corner_m = half_m / (PI / 8.0).cos();
            let [outer, inner] = [corner_m, corner_m * 0.94].map(|radius_m| round(radius_m, 8, 0.5));
            plate.frame(&outer, &inner, WHITE);
            plate.area(&inner, RED);
            plate.text("STOP", size_m * 0.27, WHITE);
            half_m
        }
        SignKind::Yield => {
            // An equilateral triangle with its tip down; its corners are cut.
            let height_m = size_m * 0.75f32.sqrt();
            let triangle = |share: f32| {
                let corners =
                    [(-0.5, 1.0), (0.0, -2.0), (0.5, 1.0)].map(|(y, z)| Vec2::new(y * size_m, z * height_m / 3.0));
                let cut = |k: usize, to: usize| corners[k].lerp(corners[to], 0.05) * share;
                [cut(0, 2), cut(0, 1), cut(1, 0), cut(1, 2), cut(2, 1), cut(2, 0)].to_vec()
            };
            let [outer, inner] = [triangle(1.0), triangle(0.64)];
            plate.frame(&outer, &inner, RED);
            plate.area(&inner, WHITE);
            height_m * 2.0 / 3.0
        }
        SignKind::Priority => {
            let corner_m = size_m * 0.5f32.sqrt();
            let [outer, inner] = [corner_m, corner_m * 0.72].map(|radius_m| round(radius_m, 4, 0.0));
            plate.frame(&outer, &inner, WHITE);
            plate.area(&inner, YELLOW);
            corner_m
        }
        SignKind::Zebra => {
            let [outer, inner] = [1.0, 0.94].map(|share| round(half_m * share * SQRT_2, 4, 0.5));
            plate.frame(&outer, &inner, WHITE);
            plate.area(&inner, BLUE);
            let triangle = [(0.0, 0.76), (-0.8, -0.66), (0.8, -0.66)].map(|(y, z)| Vec2::new(y, z) * half_m);
            plate.raised_area(&triangle, RAISED_M, WHITE);
            plate.walker(half_m);
            half_m
        }
        SignKind::SpeedLimit(kmh) => {
            let [outer, inner] = [half_m, half_m * 0.78].map(|radius_m| round(radius_m, 24, 0.0));
            plate.frame(&outer, &inner, RED);
            plate.area(&inner, WHITE);
            let height = if kmh < 100 { 0.42 } else { 0.32 };
            plate.text(&kmh.to_string(), size_m * height, BLACK);
            half_m
        }
    };
    (plate.triangles, half_height_m)
}

/// Builder of a plate that faces along +x. Outlines are counter-clockwise, seen from before the plate.
#[derive(Default)]
struct Plate {
    triangles: TriangleList,
}

impl Plate {
    /// Adds a convex area.
    fn area(&mut self, outline: &[Vec2], finish: SurfaceFinish) {
        self.raised_area(outline, 0.0, finish);
    }

    /// Adds a convex area, `off_m` before the plate.
    fn raised_area(&mut self, outline: &[Vec2], off_m: f32, finish: SurfaceFinish) {
        for k in 1..outline.len() - 1 {
            self.triangles.triangle([outline[0], outline[k], outline[k + 1]].map(|p| on(p, off_m)), finish);
        }
    }

    /// Adds a walking person over the bars of a crossing, within `half_m` of the middle.
    fn walker(&mut self, half_m: f32) {
        // Strokes as right, up, right, up and half the width, in shares of half the plate: trunk, arms, legs, bars.
        let strokes = [
            [0.01, 0.22, -0.02, -0.10, 0.075],
            [0.01, 0.20, -0.15, 0.02, 0.030],
            [0.01, 0.20, 0.16, 0.04, 0.030],
            [-0.02, -0.10, -0.16, -0.46, 0.045],
            [-0.02, -0.10, 0.14, -0.46, 0.045],
            [-0.52, -0.56, -0.34, -0.56, 0.045],
            [-0.09, -0.56, 0.09, -0.56, 0.045],
            [0.34, -0.56, 0.52, -0.56, 0.045],
        ];
        for [from_y, from_z, to_y, to_z, half] in strokes {
            self.stroke([Vec2::new(from_y, from_z), Vec2::new(to_y, to_z)].map(|p| p * half_m), half * half_m, BLACK);
        }
        let head = |k: u8| Vec2::from_angle(TAU * f32::from(k) / 8.0) * 0.085 + Vec2::new(0.02, 0.38);
        let head: Vec<Vec2> = (0..8).map(|k| head(k) * half_m).collect();
        self.raised_area(&head, 2.0 * RAISED_M, BLACK);
    }

    /// Adds a bar between two points before the plate.
    fn stroke(&mut self, [from, to]: [Vec2; 2], half_m: f32, finish: SurfaceFinish) {
        let along = (to - from).normalize_or_zero() * half_m * 0.5;
        let across = along.perp() * 2.0;
        let corners = [from - along - across, to + along - across, to + along + across, from - along + across];
        self.raised_area(&corners, 2.0 * RAISED_M, finish);
    }

    /// Adds the frame between two outlines with equally many corners, and the grey back of the plate.
    fn frame(&mut self, outer: &[Vec2], inner: &[Vec2], finish: SurfaceFinish) {
        let n = outer.len();
        for k in 0..n {
            let next = (k + 1) % n;
            self.triangles.quad([outer[k], outer[next], inner[next], inner[k]].map(|p| on(p, 0.0)), finish);
            let behind = [outer[next], outer[k], Vec2::ZERO].map(|p| on(p, -0.01));
            self.triangles.triangle(behind, STEEL);
        }
    }

    /// Adds a line of text around the middle, `height_m` high.
    fn text(&mut self, text: &str, height_m: f32, finish: SurfaceFinish) {
        let half_m = lettering::PEN / 2.0 * height_m;
        for stroke in lettering::set(text).strokes {
            let points: Vec<Vec2> =
                stroke.into_iter().map(|[right, down]| Vec2::new(right, -down) * height_m).collect();
            for pair in thinned(&points, COARSE * height_m).windows(2) {
                self.stroke([pair[0], pair[1]], half_m, finish);
            }
        }
    }
}

/// Returns a point of a plate, `off_m` before it.
fn on(point: Vec2, off_m: f32) -> Vec3 {
    Vec3::new(off_m, point.x, point.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        scene::{
            mesh::tests::{check, faces},
            network,
        },
        space::Pose3,
    };

    fn network(name: &str) -> Network {
        Network::load(&format!("tests/data/networks/{name}.net.xml")).expect("a network of the tests")
    }

    #[test]
    fn signs_say_who_goes_first_and_where_limits_change() {
        use SignKind::{Priority, SpeedLimit, Stop, Yield, Zebra};
        // Counted by hand from the right of way (`state`) and the speeds in the files.
        let counts: [(&str, &[(SignKind, usize)]); 5] = [
            ("crossing", &[(Priority, 2), (Yield, 2), (SpeedLimit(50), 4)]),
            ("allway", &[(Stop, 4), (SpeedLimit(50), 4)]),
            ("roundabout", &[(Yield, 4), (SpeedLimit(50), 4)]),
            ("zebra", &[(Zebra, 2), (SpeedLimit(50), 2)]),
            // Both ways onto the motorway, the motorway after the entry, and the exit.
            ("ramps", &[(SpeedLimit(120), 2), (SpeedLimit(80), 2)]),
        ];
        for (name, counts) in counts {
            let net = network(name);
            let signs = placed(&net, &network::surfaces(&net));
            for (kind, count) in counts {
                assert_eq!(signs.iter().filter(|sign| sign.kind == *kind).count(), *count, "{name}: {kind:?}");
            }
            assert_eq!(signs.len(), counts.iter().map(|(_, count)| count).sum::<usize>(), "{name}: {signs:?}");
        }
        // Signals rule there, no vehicle enters the network, and 13.9 m/s is the limit everywhere.
        let net = network("grid-signals");
        assert!(placed(&net, &network::surfaces(&net)).is_empty());
    }

    #[test]
    fn signs_stand_beside_the_road_and_face_those_who_come() {
        for name in ["crossing", "town", "town-left", "random-3", "hill", "ramps"] {
            let net = network(name);
            let surfaces = network::surfaces(&net);
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
                assert!((left_m > 0.0) == net.is_left_hand(), "{name}: {sign:?} {left_m}");
                assert!(left_m.abs() > lane.half_width_m() as f32 + 0.5, "{name}: {sign:?} {left_m}");
                assert!(sign.facing.truncate().dot(ahead) < -0.99, "{name}: {sign:?}");
            }
            check(&super::signs(&net, &surfaces), name);
        }
    }

    #[test]
    fn a_plate_shows_its_colours_to_the_front_alone() {
        let kinds = [SignKind::Stop, SignKind::Yield, SignKind::Zebra, SignKind::Priority, SignKind::SpeedLimit(80)];
        for kind in kinds {
            let (plate, half_height_m) = plate(kind, 0.6);
            for (corners, face) in faces(&plate.into_mesh(0.3)) {
                let is_back = corners[0].colour == STEEL.colour;
                assert_eq!(face.x > 0.0, !is_back, "{kind:?}: {corners:?}");
                assert!(corners.iter().all(|corner| corner.position[2] >= -half_height_m - 1e-4), "{kind:?}");
            }
        }
    }
}
