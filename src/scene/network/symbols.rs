//! Symbols painted on lanes: arrows before junctions and where lanes end, bicycles, the word BUS. In: turns and vehicle classes of the
//! lanes. Out: areas of paint just above the asphalt. Lengths of arrows are from `docs/references.md: roads`, all other measures are own.

use super::{
    lanes::{LaneLine, dashes_m},
    strips::Paver,
};
use crate::{
    hud::lettering,
    map::network::{Connection, Lane, LaneId, Network, Side, TurnDirection, VehicleClasses},
};

/// Speed limit above which arrows are longer, m/s: 70 km/h, with a margin for rounding.
const FAST_MPS: f64 = 20.0;
/// Distance of the first arrow's tip from the end of the lane, metres.
const TIP_TO_END_M: f64 = 4.55;
/// Maximum number of equal arrows, one behind the other.
const ARROWS: usize = 3;
/// Distance of the first bicycle or word from the start of the lane, and from each to the next, metres.
const FROM_START_M: f64 = 5.0;
const REPEATED_M: f64 = 50.0;
/// Half the width of the shaft of an arrow, metres.
const SHAFT_M: f64 = 0.1;
/// Maximum distance from the middle of the lane to either side at which a symbol has paint, metres.
const REACH_M: f64 = 1.0;
/// Width of asphalt that a symbol leaves free on either side of its lane, metres.
const FREE_M: f64 = 0.25;

/// Turns that a lane allows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Turns {
    pub left: bool,
    pub straight: bool,
    pub right: bool,
}

/// Kind of a symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Symbol {
    /// Arrows to where a lane leads.
    Turns(Turns),
    /// Arrow from a lane that ends to the lane beside it.
    Merge(Side),
    Bicycle,
    /// Word on lanes for buses.
    Bus,
}

/// Symbol on a lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedSymbol {
    pub symbol: Symbol,
    pub lane: LaneId,
    /// Start of the symbol along the drawn line, metres.
    pub row: f64,
}

/// Convex area of paint: metres along the lane and to its left.
type Area = Vec<[f64; 2]>;

/// Returns all symbols of a network.
pub(super) fn placed(net: &Network) -> Vec<PlacedSymbol> {
    let mut symbols = Vec::new();
    for id in net.lane_ids().filter(|id| net.is_driven(*id)) {
        let Some(symbol) = symbol(net, id) else { continue };
        let lane = net.lane(id);
        let drawn_m = lane.line.drawn_m();
        let length_m = symbol.length_m(lane);
        let rows: Vec<f64> = match symbol {
            Symbol::Turns(_) | Symbol::Merge(_) => {
                let (dash_m, gap_m) = dashes_m(lane);
                let tip = |k: usize| drawn_m - lane.end_offset_m - TIP_TO_END_M - k as f64 * 3.0 * (dash_m + gap_m);
                (0..ARROWS).map(|k| tip(k) - length_m).filter(|row| *row > 0.0).collect()
            }
            Symbol::Bicycle | Symbol::Bus => {
                let n = ((drawn_m - FROM_START_M - length_m) / REPEATED_M).floor() as i64;
                (0..=n).map(|k| FROM_START_M + k as f64 * REPEATED_M).collect()
            }
        };
        symbols.extend(rows.into_iter().map(|row| PlacedSymbol { symbol, lane: id, row }));
    }
    symbols
}

/// Paints all symbols of a network.
pub(super) fn paint(net: &Network, paver: &mut Paver) {
    for placed in placed(net) {
        let lane = net.lane(placed.lane);
        let line = LaneLine::new(lane);
        let narrowed = ((lane.half_width_m() - FREE_M) / REACH_M).clamp(0.1, 1.0);
        for area in placed.symbol.areas(placed.symbol.length_m(lane)) {
            let area: Area = area.into_iter().map(|[along, left]| [placed.row + along, left * narrowed]).collect();
            let rows = area.iter().map(|[row, _]| *row);
            let (from, to) = (rows.clone().fold(f64::INFINITY, f64::min), rows.fold(f64::NEG_INFINITY, f64::max));
            // The asphalt is flat between its rows of vertices. An area across such a row would sink into it on a crest.
            for pair in line.rows(from, to).windows(2) {
                let part = clipped(&clipped(&area, pair[0], 1.0), pair[1], -1.0);
                let corners: Vec<_> = part.into_iter().map(|[row, left]| line.surface_point(row, left)).collect();
                paver.painted_area(&corners);
            }
        }
    }
}

/// Returns the symbol on a lane, if it has one.
fn symbol(net: &Network, id: LaneId) -> Option<Symbol> {
    let lane = net.lane(id);
    if !lane.permissions.intersects(VehicleClasses::ROAD_MOTOR) {
        return lane.is_for_bicycles().then_some(Symbol::Bicycle);
    }
    if !lane.admits_cars() {
        return lane.permissions.contains(VehicleClasses::BUS).then_some(Symbol::Bus);
    }
    if let Some(side) = ends_towards(net, id) {
        return Some(Symbol::Merge(side));
    }
    let own = turns(net, id);
    let leads_on = |beside: &LaneId| net.lane(*beside).admits_cars() && ways(net, *beside).next().is_some();
    // Arrows say which lane to take. Where all lanes lead to the same roads, they would say nothing.
    let differ = net.edge_of(id).lanes().filter(leads_on).any(|beside| turns(net, beside) != own);
    (differ && own != Turns::default()).then_some(Symbol::Turns(own))
}

/// Returns the connections from a lane to others that cars may use, without U-turns.
fn ways(net: &Network, id: LaneId) -> impl Iterator<Item = &Connection> {
    net.connections_from(id).iter().filter(|way| !way.is_turnaround() && net.lane(way.to).admits_cars())
}

fn turns(net: &Network, id: LaneId) -> Turns {
    let mut turns = Turns::default();
    for way in ways(net, id) {
        match way.direction {
            TurnDirection::Left | TurnDirection::PartLeft => turns.left = true,
            TurnDirection::Right | TurnDirection::PartRight => turns.right = true,
            TurnDirection::Straight => turns.straight = true,
            TurnDirection::Turnaround | TurnDirection::TurnaroundLeftHand | TurnDirection::Unknown => {}
        }
    }
    turns
}

/// Returns the side of the lane that continues where this one ends; `None` if this one continues. Of two lanes that lead into one, the
/// outer one ends.
fn ends_towards(net: &Network, id: LaneId) -> Option<Side> {
    let [inwards, outwards] = if net.is_left_hand() { [Side::Right, Side::Left] } else { [Side::Left, Side::Right] };
    let beside = |side: Side| net.neighbour(id, side).filter(|beside| net.lane(*beside).admits_cars());
    if net.connections_from(id).is_empty() {
        let continues = |side: &Side| beside(*side).is_some_and(|beside| ways(net, beside).next().is_some());
        return [inwards, outwards].into_iter().find(continues);
    }
    let inner: Vec<LaneId> =
        beside(inwards).into_iter().flat_map(|beside| ways(net, beside)).map(|way| way.to).collect();
    let joined = ways(net, id).filter(|way| inner.contains(&way.to)).count();
    (joined > 0 && joined == ways(net, id).count()).then_some(inwards)
}

impl Symbol {
    /// Returns the length along the lane, metres.
    fn length_m(self, lane: &Lane) -> f64 {
        match self {
            Self::Turns(_) | Self::Merge(_) if lane.speed_limit_mps > FAST_MPS => 7.5,
            Self::Turns(_) | Self::Merge(_) => 5.0,
            Self::Bicycle => 2.0,
            Self::Bus => 4.0,
        }
    }

    /// Returns the symbol's areas from its start to `length_m`, up to [`REACH_M`] to either side.
    fn areas(self, length_m: f64) -> Vec<Area> {
        let shapes = match self {
            Self::Turns(turns) => turn_arrow(turns),
            Self::Merge(side) => merge_arrow(sign(side)),
            Self::Bicycle => bicycle(),
            Self::Bus => bus(),
        };
        shapes.into_iter().map(|area| area.into_iter().map(|[at, left]| [at * length_m, left]).collect()).collect()
    }
}

/// Returns 1 for the left and -1 for the right.
fn sign(side: Side) -> f64 {
    if side == Side::Left { 1.0 } else { -1.0 }
}

/// Arrow with up to three heads, of length 1.
fn turn_arrow(turns: Turns) -> Vec<Area> {
    // Without a head straight on, the branches leave the shaft further ahead. With one branch, the shaft moves aside so that the arrow
    // stands in the middle of the lane.
    let branch_at = if turns.straight { 0.24 } else { 0.58 };
    let shift = match (turns.left, turns.straight, turns.right) {
        (true, false, false) => -0.45,
        (false, false, true) => 0.45,
        _ => 0.0,
    };
    let shaft_to = if turns.straight { 0.66 } else { branch_at + 0.16 };
    let mut areas = vec![vec![[0.0, -SHAFT_M], [shaft_to, -SHAFT_M], [shaft_to, SHAFT_M], [0.0, SHAFT_M]]];
    if turns.straight {
        areas.push(vec![[shaft_to, -0.4], [1.0, 0.0], [shaft_to, 0.4]]);
    }
    for (is_there, sign) in [(turns.left, 1.0), (turns.right, -1.0)] {
        if is_there {
            let (inner, outer) = (SHAFT_M * sign, 0.36 * sign);
            let at = |along: f64| branch_at + along;
            areas.push(vec![[at(0.0), inner], [at(0.16), inner], [at(0.28), outer], [at(0.14), outer]]);
            areas.push(vec![[at(0.02), outer], [at(0.40), outer], [at(0.25), REACH_M * sign]]);
        }
    }
    areas.iter_mut().flatten().for_each(|corner| corner[1] += shift);
    areas
}

/// Slanting arrow to the side `sign`, of length 1.
fn merge_arrow(sign: f64) -> Vec<Area> {
    let corner = |along: f64, left: f64| [along, left * sign];
    vec![
        vec![corner(0.0, -0.75), corner(0.62, 0.0), corner(0.62, 0.25), corner(0.0, -0.5)],
        vec![corner(0.56, -0.35), corner(1.0, 0.6), corner(0.66, 0.6)],
    ]
}

/// Bicycle seen from its left, of length 1: two wheels, the frame, the fork, saddle and handlebar.
fn bicycle() -> Vec<Area> {
    const WHEEL_M: f64 = 0.3;
    // Seen from its left, the front wheel is on the left.
    let hubs = [0.42, -0.42];
    let mut areas = Vec::new();
    for hub in hubs {
        // Wheels stand higher than wide, as all that is read from a low angle.
        let at = |k: usize, share: f64| {
            let turn = std::f64::consts::TAU * k as f64 / 16.0;
            [0.3 + 0.3 * share * turn.sin(), hub + WHEEL_M * share * turn.cos()]
        };
        areas.extend((0..16).map(|k| vec![at(k, 0.76), at(k, 1.0), at(k + 1, 1.0), at(k + 1, 0.76)]));
    }
    let crank = [0.28, 0.02];
    let (saddle, head) = ([0.74, -0.14], [0.72, 0.26]);
    let strokes = [
        ([0.3, hubs[1]], crank),
        ([0.3, hubs[1]], [0.64, -0.11]),
        (crank, saddle),
        (crank, head),
        ([0.64, -0.11], [0.64, 0.28]),
        ([0.3, hubs[0]], [0.9, 0.2]),
    ];
    areas.extend(strokes.map(|(from, to)| stroke(from, to, 0.03)));
    areas.push(stroke([0.76, -0.26], [0.76, 0.0], 0.03));
    areas.push(stroke([0.9, 0.2], [0.94, 0.4], 0.03));
    areas
}

/// The word BUS, of length 1.
fn bus() -> Vec<Area> {
    /// Width of the letters, metres for each share of their height, and half the width of their strokes.
    const WIDTH: f64 = 0.75;
    const HALF: f64 = 0.06;
    let strokes = lettering::set("BUS").strokes;
    let point = |[right, down]: [f32; 2]| [0.5 - f64::from(down) * (1.0 - 2.0 * HALF), -f64::from(right) * WIDTH];
    // Strokes are joined of parts that share a point.
    let bars = strokes.iter().flat_map(|stroke| stroke.windows(2)).filter(|pair| pair[0] != pair[1]);
    bars.map(|pair| stroke(point(pair[0]), point(pair[1]), HALF)).collect()
}

/// Bar between two points, `half` wide to either side.
fn stroke(from: [f64; 2], to: [f64; 2], half: f64) -> Area {
    let along = [to[0] - from[0], to[1] - from[1]];
    let length = along[0].hypot(along[1]);
    let across = [-along[1] / length * half, along[0] / length * half];
    let beside = |point: [f64; 2], sign: f64| [point[0] + sign * across[0], point[1] + sign * across[1]];
    vec![beside(from, -1.0), beside(to, -1.0), beside(to, 1.0), beside(from, 1.0)]
}

/// Returns the part of a convex area beyond (`sign` 1) or before (-1) a row.
fn clipped(area: &[[f64; 2]], row: f64, sign: f64) -> Area {
    let beyond_m = |corner: [f64; 2]| (corner[0] - row) * sign;
    let mut part = Vec::new();
    for (k, &corner) in area.iter().enumerate() {
        let next = area[(k + 1) % area.len()];
        let (here_m, next_m) = (beyond_m(corner), beyond_m(next));
        if here_m >= 0.0 {
            part.push(corner);
        }
        if here_m * next_m < 0.0 {
            let share = here_m / (here_m - next_m);
            part.push([row, corner[1] + share * (next[1] - corner[1])]);
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::RoadMap;
    use std::sync::Arc;

    fn of_tests(name: &str) -> Arc<Network> {
        Arc::new(Network::load(&format!("tests/data/networks/{name}.net.xml")).expect("a network of the tests"))
    }

    fn count(net: &Network, is_counted: impl Fn(Symbol) -> bool) -> usize {
        placed(net).iter().filter(|placed| is_counted(placed.symbol)).count()
    }

    #[test]
    fn arrows_stand_where_lanes_lead_to_different_roads_or_end() {
        // Nine crossings of four approaches, each with a lane to the left and one for the others, two arrows on each.
        let grid = RoadMap::load("grid").expect("a shipped map").network;
        let left = Turns { left: true, ..Turns::default() };
        let others = Turns { straight: true, right: true, ..Turns::default() };
        for turns in [left, others] {
            assert_eq!(count(&grid, |symbol| symbol == Symbol::Turns(turns)), 9 * 4 * 2, "{turns:?}");
        }
        assert_eq!(placed(&grid).len(), 2 * 9 * 4 * 2);
        // Four lanes become two, and two become one: three lanes end, with three arrows each.
        let bottleneck = RoadMap::load("bottleneck").expect("a shipped map").network;
        assert_eq!(count(&bottleneck, |symbol| symbol == Symbol::Merge(Side::Left)), 3 * 3);
        assert_eq!(placed(&bottleneck).len(), 3 * 3);
        // A lane that ends after the entry, and three lanes before the exit. Each has room for two arrows 54 m apart.
        let ramps = of_tests("ramps");
        assert_eq!(count(&ramps, |symbol| symbol == Symbol::Merge(Side::Left)), 2);
        assert_eq!(count(&ramps, |symbol| matches!(symbol, Symbol::Turns(_))), 3 * 2);
        // Single lanes need no arrows.
        assert!(placed(&of_tests("crossing")).is_empty());
    }

    #[test]
    fn arrows_point_where_the_roads_are() {
        let mut seen = 0;
        for name in ["grid-signals", "town", "town-left", "random-3", "random-8"] {
            let net = of_tests(name);
            for placed in placed(&net) {
                let Symbol::Turns(turns) = placed.symbol else { continue };
                let end = net.lane(placed.lane).line.end_direction();
                let heads = turn_arrow(turns);
                let shaft = (heads[0][0][1] + heads[0][2][1]) / 2.0;
                let reaches = |sign: f64| heads.iter().flatten().any(|corner| (corner[1] - shaft) * sign > 0.9);
                for way in ways(&net, placed.lane) {
                    let to = net.lane(way.to).line.pose(0.0, 0.0);
                    let turn_rad = end.angle_to(glam::DVec2::from_angle(to.yaw_rad));
                    // Sharper than half a right angle is a turn.
                    if turn_rad.abs() > std::f64::consts::FRAC_PI_4 {
                        assert!(reaches(turn_rad.signum()), "{name}: {placed:?} turns by {turn_rad}");
                        seen += 1;
                    }
                }
            }
        }
        assert!(seen > 10, "{seen}");
    }

    #[test]
    fn bicycle_and_bus_lanes_have_their_symbols_and_paint_stays_in_its_lane() {
        for name in ["town", "town-left"] {
            let net = of_tests(name);
            let symbols = placed(&net);
            for id in net.lane_ids().filter(|id| net.is_driven(*id) && net.lane(*id).line.drawn_m() > 20.0) {
                let classes = net.lane(id).permissions;
                let of_lane: Vec<_> =
                    symbols.iter().filter(|placed| placed.lane == id).map(|placed| placed.symbol).collect();
                let has_motors = classes.intersects(VehicleClasses::ROAD_MOTOR);
                assert_eq!(!has_motors, of_lane.contains(&Symbol::Bicycle), "{name}: {}", net.lane(id).id);
                let is_bus_lane = has_motors && !classes.contains(VehicleClasses::PASSENGER);
                assert_eq!(is_bus_lane, of_lane.contains(&Symbol::Bus), "{name}: {}", net.lane(id).id);
            }
            for placed in symbols {
                let lane = net.lane(placed.lane);
                for corner in placed.symbol.areas(placed.symbol.length_m(lane)).iter().flatten() {
                    assert!(
                        (-1e-9..=placed.symbol.length_m(lane) + 1e-9).contains(&corner[0]),
                        "{placed:?} {corner:?}"
                    );
                    assert!(corner[1].abs() <= REACH_M + 1e-9, "{placed:?} {corner:?}");
                }
            }
        }
    }

    #[test]
    fn a_cut_area_keeps_its_size_and_lies_on_its_side_of_the_row() {
        // A cut across the middle of a triangle leaves a quarter of it before the tip.
        let triangle = [[0.0, -1.0], [2.0, 0.0], [0.0, 1.0]];
        let size = |area: &[[f64; 2]]| {
            let n = area.len();
            (0..n).map(|k| area[k][0] * area[(k + 1) % n][1] - area[k][1] * area[(k + 1) % n][0]).sum::<f64>() / 2.0
        };
        let (near, far) = (clipped(&triangle, 1.0, -1.0), clipped(&triangle, 1.0, 1.0));
        assert!((size(&near) - 1.5).abs() < 1e-12 && (size(&far) - 0.5).abs() < 1e-12, "{near:?} {far:?}");
        assert!(near.iter().all(|corner| corner[0] <= 1.0) && far.iter().all(|corner| corner[0] >= 1.0));
        assert!(clipped(&triangle, 3.0, 1.0).is_empty());
    }
}
