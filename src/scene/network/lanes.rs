//! Lanes as adjacent ribbons: asphalt with wheel tracks, strips with markings, shoulder and verge beside the outermost lane, raised
//! pavements with kerbs, rails on ballast. In: a lane of the network. Out: ribbons.

use super::{
    junctions,
    layer::{ASPHALT, KERB, LINE_HALF_M, Layer, PAVING, SHOULDER, plain_asphalt},
    name_signs,
    strips::{Column, Ground, Paver},
    verge::{SurfacePoint, VergePaver},
};
use crate::{
    map::network::{EdgeKind, JunctionId, Lane, LaneId, Marking, Network, Side, TurnDirection},
    roadside::{
        junction_areas::JunctionArea,
        outlines::{cleaned, contains},
        road_surfaces::points,
    },
    scene::colours::shade,
};
use glam::{Vec2, Vec3};
use std::collections::{BTreeMap, BTreeSet};

/// Distance outside a walking area at which another paved surface is looked for, metres. A side with one there has a kerb.
const KERB_TO_M: f32 = 0.3;
/// Colour of polished rails, linear albedo.
const RAIL: [f32; 3] = [0.030, 0.027, 0.025];
const HALF_GAUGE_M: f64 = 0.7175;
/// Width of a rail's head, metres.
const RAIL_M: f64 = 0.07;
/// Height of a rail above the ballast, metres.
const RAIL_HEIGHT_M: f32 = 0.05;
/// Width of bare asphalt beside a line, within its strip, metres.
const BARE_M: f64 = 0.16;
/// Maximum distance between rows of a level lane's vertices, metres. The asphalt's colour varies from row to row.
const ROW_M: f64 = 12.0;
/// Maximum distance between rows of a lane that is not level, metres. Bridges begin and end at rows.
const RISING_ROW_M: f64 = 4.0;
/// Half the width of the strip under a seam between lanes, metres.
const SEAM_M: f64 = 0.15;

/// Returns dash and gap of a broken line, metres. They depend on the speed limit: towns, rural roads, motorways
/// (`docs/references.md: roads`).
pub(super) fn dashes_m(lane: &Lane) -> (f64, f64) {
    match lane.speed_limit_mps {
        // Limits of 50 and 100 km/h, with a margin for rounding.
        limit if limit < 15.0 => (3.0, 6.0),
        limit if limit < 28.0 => (4.0, 8.0),
        _ => (6.0, 12.0),
    }
}

/// Centre line of a lane, measured along the drawn line. SUMO's length of the lane may differ.
pub(super) struct LaneLine<'n> {
    lane: &'n Lane,
    /// Length of the drawn line, metres.
    pub drawn_m: f64,
    /// Positions of the line's points along the drawn line, metres.
    joints_m: Vec<f64>,
    /// Maximum distance between rows, metres.
    row_m: f64,
}

impl<'n> LaneLine<'n> {
    pub fn new(lane: &'n Lane) -> Self {
        let mut joints_m = vec![0.0];
        for pair in lane.line.points().windows(2) {
            joints_m.push(joints_m[joints_m.len() - 1] + pair[0].distance(pair[1]));
        }
        let points = lane.line.points();
        let is_level = points.iter().all(|point| point.z == points[0].z);
        let row_m = if is_level { ROW_M } else { RISING_ROW_M };
        Self { lane, drawn_m: joints_m[joints_m.len() - 1], joints_m, row_m }
    }

    /// The place `row` metres along and `offset_m` to the left.
    pub fn surface_point(&self, row: f64, offset_m: f64) -> Vec3 {
        self.lane.line.pose(row / self.drawn_m * self.lane.length_m, offset_m).position.as_vec3()
    }

    /// Returns the rows from `from_m` to `to_m`: both ends, the line's points between them, and further rows so that none are more than
    /// `row_m` apart.
    pub fn rows(&self, from_m: f64, to_m: f64) -> Vec<f64> {
        let inner = self.joints_m.iter().copied().filter(|row| (from_m + 1e-3..to_m - 1e-3).contains(row));
        let marks: Vec<f64> = [from_m].into_iter().chain(inner).chain([to_m]).collect();
        let mut rows = vec![from_m];
        for pair in marks.windows(2) {
            let n = ((pair[1] - pair[0]) / self.row_m).ceil().max(1.0);
            rows.extend((1..=n as usize).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / n));
        }
        rows
    }
}

/// Paves a lane, with its markings and its verges. Crossings are left to [`super::paint`].
pub(super) fn pave(net: &Network, id: LaneId, shared: &SharedAreas, paver: &mut Paver, verges: VergePaver) {
    let lane = net.lane(id);
    let edge = net.edge_of(id);
    let town = verges.town;
    let is_in_town = town.has_street(lane.edge) || edge.junction.is_some_and(|junction| town.has_junction(junction));
    let verges = verges.with_pavement(is_in_town && !lane.is_footway());
    let line = LaneLine::new(lane);
    let kind = edge.kind;
    // The middle of a roundabout has no pavement: no path leads there.
    let inner_side = if net.is_left_hand() { -1.0 } else { 1.0 };
    let is_on_island = |side: f64| side == inner_side && name_signs::is_in_roundabout(net, lane.edge);
    if kind == EdgeKind::WalkingArea {
        return walking_area(lane, shared.lanes.contains(&id), paver, verges);
    }
    if kind == EdgeKind::Crossing || line.drawn_m < 0.01 {
        return;
    }
    let (half_m, rows) = (lane.half_width_m(), line.rows(0.0, line.drawn_m));
    let surface_point = |row: f64, offset_m: f64| line.surface_point(row, offset_m);
    if lane.is_railway() {
        let inside = kind == EdgeKind::Internal;
        if !inside || leads_straight_on(net, id) {
            railway(&rows, &surface_point, half_m, inside, paver, verges);
        }
        return;
    }
    if lane.is_footway() && kind.is_street() {
        return footway(net, id, &rows, &surface_point, paver, verges);
    }
    let through = through_markings(net, id).filter(|_| kind == EdgeKind::Internal);
    if kind == EdgeKind::Internal && through.is_none() {
        // The same colour as the junction's area, which covers most of the lane.
        let junction = net.edge_of(id).junction;
        let layer =
            if junction.is_some_and(|at| shared.junctions.contains(&at)) { Layer::SharedWay } else { Layer::Way };
        let columns = [-half_m, half_m].map(|at| Column::tarred(at, layer, plain_asphalt()));
        return paver.ribbon(&rows, &surface_point, columns, Ground::Even, None);
    }
    let markings = through.unwrap_or_else(|| [Side::Right, Side::Left].map(|side| net.marking(id, side)));
    verges.pave_deck(paver, &rows, &surface_point, half_m);
    // The texture's start differs between lanes, so that repairs and cracks do not line up.
    let start = Some((id.index() % 61) as f64 * 71.0);
    let inset = markings.map(inset_m);
    let (right_m, left_m) = (-half_m + inset[0], half_m - inset[1]);
    let tone = |share: f32| shade(ASPHALT, share);
    let mut columns = vec![(right_m, tone(1.10)), (left_m, tone(1.10))];
    if half_m > 1.2 {
        // Tyres darken two tracks. Oil darkens the middle less.
        let inner = [(-0.72, 1.06), (-0.45, 0.88), (0.0, 0.93), (0.45, 0.88), (0.72, 1.06)];
        columns.splice(1..1, inner.map(|(at, share)| (at * half_m, tone(share))));
    }
    for pair in columns.windows(2) {
        let columns = [pair[0], pair[1]].map(|(at, colour)| Column::tarred(at, Layer::Street, colour));
        paver.ribbon(&rows, &surface_point, columns, Ground::Tarred, start);
    }
    for (marking, side) in markings.into_iter().zip([-1.0, 1.0]) {
        // Streets with kerbs have no lines along them.
        border(lane, &line, marking, side, paver, start, !(is_in_town && marking == Marking::Edge));
        if marking == Marking::Edge {
            let columns = [(half_m + LINE_HALF_M * 2.0 + 0.22, 1.10), (half_m + SHOULDER, 1.22)];
            let columns = columns.map(|(at, share)| Column::tarred(side * at, Layer::Street, tone(share)));
            paver.ribbon(&rows, &surface_point, ordered(columns), Ground::Tarred, start);
            if through.is_none() {
                let verges = if is_on_island(side) { verges.with_pavement(false) } else { verges };
                verges.pave(paver, &rows, &surface_point, half_m + SHOULDER, side > 0.0);
            }
        } else {
            let columns = [half_m - SEAM_M, half_m + SEAM_M];
            let columns = columns.map(|at| Column::tarred(side * at, Layer::Seam, tone(1.10)));
            paver.ribbon(&rows, &surface_point, ordered(columns), Ground::Tarred, start);
        }
    }
}

/// Returns the markings on the right and the left of a lane inside a junction without crossing connections, such as a bend of a street.
/// `None` for all other lanes: their markings end at the junction.
fn through_markings(net: &Network, id: LaneId) -> Option<[Marking; 2]> {
    let junction = net.junction(net.edge_of(id).junction?);
    let (&[before], mut after) = (net.predecessors(id), net.successors(id)) else { return None };
    let (after, None) = (after.next()?, after.next()) else { return None };
    let streets = [before, after].iter().all(|lane| net.is_driven(*lane));
    let one_width = (net.lane(before).width_m - net.lane(after).width_m).abs() < 0.05;
    let way = net.connections_from(before).iter().find(|way| way.next() == id)?;
    if !no_one_meets(net, id) || junction.kind.has_signals() || !streets || !one_width || way.is_turnaround() {
        return None;
    }
    let of = |side: Side| match (net.marking(before, side), net.marking(after, side)) {
        (Marking::Edge, Marking::Broken) | (Marking::Broken, Marking::Edge) => Marking::Broken,
        // The two directions do not bend about one centre, so their centre lines would not coincide.
        (Marking::Centre { .. }, _) => Marking::None,
        (one, other) if one == other => one,
        _ => Marking::None,
    };
    Some([of(Side::Right), of(Side::Left)])
}

/// Returns the right column first.
fn ordered([a, b]: [Column; 2]) -> [Column; 2] {
    if a.offset_m <= b.offset_m { [a, b] } else { [b, a] }
}

/// Returns the width of a marking's strip inside the lane, metres.
fn inset_m(marking: Marking) -> f64 {
    match marking {
        Marking::None | Marking::Kerb => 0.0,
        Marking::Edge => BARE_M,
        _ => LINE_HALF_M + BARE_M,
    }
}

/// Paves the strip of a marking on one side of a lane; `side` is -1 on the right, 1 on the left.
fn border(
    lane: &Lane,
    line: &LaneLine,
    marking: Marking,
    side: f64,
    paver: &mut Paver,
    start: Option<f64>,
    is_painted: bool,
) {
    let half_m = lane.half_width_m();
    // Distances of the line's middle and of the strip's outer edge from the lane's middle, metres; true if the line is broken.
    let wide_m = LINE_HALF_M + BARE_M;
    let (middle_m, outer_m, broken) = match marking {
        Marking::None | Marking::Kerb => return,
        Marking::Edge => (half_m + LINE_HALF_M, half_m + 2.0 * LINE_HALF_M + 0.22, false),
        Marking::Broken | Marking::Centre { overtaking: true } => (half_m, half_m, true),
        Marking::Solid | Marking::Centre { overtaking: false } => (half_m, half_m, false),
        Marking::ChangeFromHere => (half_m - wide_m / 2.0, half_m, true),
        Marking::ChangeToHere => (half_m - wide_m / 2.0, half_m, false),
    };
    let surface_point = |row: f64, offset_m: f64| line.surface_point(row, offset_m);
    let ends = [half_m - inset_m(marking), outer_m];
    let painted = ends.map(|at| Column::painted(side * at, Layer::Street, at - middle_m, LINE_HALF_M));
    let bare = ends.map(|at| Column::tarred(side * at, Layer::Street, shade(ASPHALT, 1.10)));
    let mut section = |from_m: f64, to_m: f64, is_painted: bool| {
        let (columns, ground) = if is_painted { (painted, Ground::Painted) } else { (bare, Ground::Tarred) };
        paver.ribbon(&line.rows(from_m, to_m), &surface_point, ordered(columns), ground, start);
    };
    if !broken {
        return section(0.0, line.drawn_m, is_painted);
    }
    let (dash_m, gap_m) = dashes_m(lane);
    if line.drawn_m < dash_m + gap_m / 2.0 {
        return section(0.0, line.drawn_m, false);
    }
    // Half a gap at either end, so that the dashes of both directions coincide.
    let n = (line.drawn_m / (dash_m + gap_m)).round().max(1.0);
    let period_m = line.drawn_m / n;
    let gap_m = period_m * gap_m / (dash_m + gap_m);
    for k in 0..n as usize {
        let at_m = k as f64 * period_m;
        section(at_m, at_m + gap_m / 2.0, false);
        section(at_m + gap_m / 2.0, at_m + period_m - gap_m / 2.0, true);
        section(at_m + period_m - gap_m / 2.0, at_m + period_m, false);
    }
}

/// Paves the wedges between a lane of a street and the areas of the junctions at its ends.
pub(super) fn pave_ends(net: &Network, id: LaneId, areas: &BTreeMap<JunctionId, &JunctionArea>, paver: &mut Paver) {
    let (lane, edge) = (net.lane(id), net.edge_of(id));
    if !edge.kind.is_street() || !net.is_driven(id) || lane.is_railway() {
        return;
    }
    for (junction, s_m, forwards) in [(edge.to, lane.length_m, 1.0), (edge.from, 0.0, -1.0)] {
        let Some(area) = junction.and_then(|junction| areas.get(&junction)) else { continue };
        // With the shoulder of a street's outermost lane.
        let half_m = |side: Side| lane.half_width_m() + if net.neighbour(id, side).is_none() { SHOULDER } else { 0.0 };
        let (right, left) = (-half_m(Side::Right), half_m(Side::Left));
        let at = |offset_m: f64| lane.line.pose(s_m, offset_m).position.as_vec3();
        let ahead = Vec2::from_angle(lane.line.pose(s_m, 0.0).yaw_rad as f32) * forwards;
        let edges = if forwards > 0.0 { [at(right), at(left)] } else { [at(left), at(right)] };
        junctions::pave_up_to(area, edges, ahead, paver);
    }
}

/// A pavement: a kerb higher than what lies beside it.
fn footway(
    net: &Network,
    id: LaneId,
    rows: &[f64],
    surface_point: SurfacePoint,
    paver: &mut Paver,
    verges: VergePaver,
) {
    let half_m = net.lane(id).half_width_m();
    let columns = [-half_m, half_m].map(|at| Column::tarred(at, Layer::Pavement, PAVING));
    paver.ribbon(rows, surface_point, columns, Ground::Tarred, None);
    for (side, sign) in [(Side::Right, -1.0), (Side::Left, 1.0)] {
        let beside = net.neighbour(id, side);
        if beside.is_some_and(|beside| net.lane(beside).is_footway()) {
            continue;
        }
        if beside.is_none() {
            verges.pave(paver, rows, surface_point, half_m, sign > 0.0);
            continue;
        }
        // The kerb's face points outwards. Columns go from right to left of the line, so on the left the upper one comes first.
        let upper = Column::tarred(sign * half_m, Layer::Pavement, KERB);
        let lower = Column { z_m: Layer::Verge.z_m(), ..upper };
        paver.ribbon(
            rows,
            surface_point,
            if sign > 0.0 { [upper, lower] } else { [lower, upper] },
            Ground::Tarred,
            None,
        );
    }
}

/// Checks whether a lane inside a junction leads straight on.
fn leads_straight_on(net: &Network, id: LaneId) -> bool {
    let ways = net.predecessors(id).iter().flat_map(|before| net.connections_from(*before));
    ways.into_iter().any(|way| way.next() == id && way.direction == TurnDirection::Straight)
}

/// Walking areas that vehicles drive across, as in networks without crossings, and the junctions that have such areas.
#[derive(Debug, Default)]
pub(super) struct SharedAreas {
    lanes: BTreeSet<LaneId>,
    junctions: BTreeSet<JunctionId>,
}

/// Returns all shared areas of a network.
pub(super) fn shared_areas(net: &Network) -> SharedAreas {
    // Sample points on the centre lines of each junction's lanes.
    let mut driven: BTreeMap<JunctionId, Vec<Vec3>> = BTreeMap::new();
    let of_kind = |kind: EdgeKind| net.lane_ids().filter(move |id| net.edge_of(*id).kind == kind);
    for id in of_kind(EdgeKind::Internal) {
        if let Some(junction) = net.edge_of(id).junction {
            let lane = net.lane(id);
            let at = |share: f64| lane.line.pose(share * lane.length_m, 0.0).position.as_vec3();
            driven.entry(junction).or_default().extend([0.2, 0.5, 0.8].map(at));
        }
    }
    let mut shared = SharedAreas::default();
    for id in of_kind(EdgeKind::WalkingArea) {
        let Some(junction) = net.edge_of(id).junction else { continue };
        let outline = points(net.lane(id).shape());
        let ways = driven.get(&junction).into_iter().flatten();
        if ways.into_iter().any(|at| contains(&outline, at.truncate())) {
            shared.lanes.insert(id);
            shared.junctions.insert(junction);
        }
    }
    shared
}

/// Paves a walking area, with a kerb on each side that borders another paved surface. Shared areas have no kerbs.
fn walking_area(lane: &Lane, is_shared: bool, paver: &mut Paver, verges: VergePaver) {
    let outline = points(lane.shape());
    if is_shared {
        return paver.area(&outline, Layer::Shared, PAVING);
    }
    paver.area(&outline, Layer::Pavement, PAVING);
    let flat: Vec<_> = outline.iter().map(|point| point.truncate()).collect();
    let round = cleaned(&flat);
    for (k, &from) in round.iter().enumerate() {
        let to = round[(k + 1) % round.len()];
        // No kerb towards open ground.
        let along = flat[to] - flat[from];
        let outside = (flat[from] + flat[to]) / 2.0 + Vec2::new(along.y, -along.x).normalize_or_zero() * KERB_TO_M;
        if verges.surfaces.border_m(outside) > 0.0 {
            continue;
        }
        let surface_point = |row: f64, _: f64| outline[from].lerp(outline[to], row as f32);
        let upper = Column::tarred(0.0, Layer::Pavement, KERB);
        let lower = Column { z_m: Layer::Verge.z_m(), ..upper };
        // Counter-clockwise, the outside is on the right.
        paver.ribbon(&[0.0, 1.0], &surface_point, [lower, upper], Ground::Tarred, None);
    }
}

/// Ballast with two rails; across roads the rails alone.
fn railway(
    rows: &[f64],
    surface_point: SurfacePoint,
    half_m: f64,
    inside: bool,
    paver: &mut Paver,
    verges: VergePaver,
) {
    if !inside {
        let columns = [-half_m, half_m].map(|at| Column::grown(at, Layer::Street.z_m(), -0.5));
        paver.ribbon(rows, surface_point, columns, Ground::Grown, None);
        [false, true].into_iter().for_each(|left| verges.pave(paver, rows, surface_point, half_m, left));
    }
    for middle_m in [-HALF_GAUGE_M, HALF_GAUGE_M] {
        let rail =
            |aside: f64, z_m: f32| Column { offset_m: middle_m + aside * RAIL_M / 2.0, z_m, colour: RAIL, share: 0.0 };
        let top = if inside { Layer::Paint.z_m() } else { RAIL_HEIGHT_M };
        for pair in [rail(-1.0, 0.0), rail(-1.0, top), rail(1.0, top), rail(1.0, 0.0)].windows(2) {
            paver.ribbon(rows, surface_point, [pair[0], pair[1]], Ground::Tarred, None);
        }
    }
}

/// Checks whether a lane is inside a junction that has no crossing connections.
pub(super) fn no_one_meets(net: &Network, inside: LaneId) -> bool {
    let junction = net.edge_of(inside).junction.map(|junction| net.junction(junction));
    junction.is_some_and(|junction| junction.links.iter().all(|link| link.crosses.iter().next().is_none()))
}
