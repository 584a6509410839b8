//! Transverse markings: stop lines, yield lines, crossings. In: right of way and signals of the network. Out: strips of paint just above
//! the asphalt. Widths are from `docs/references.md: roads`.

use super::{lanes::LaneLine, strips::Paver};
use crate::map::network::{Connection, EdgeKind, LaneId, LinkState, Network};

/// Width of stop lines and yield lines, metres.
const STOP_WIDTH_M: f64 = 0.5;
/// Distance of the line's middle from the end of the lane, metres: SUMO's vehicles stop before the end.
const BEFORE_END_M: f64 = 0.55;
/// Dash and gap of a yield line, metres.
const YIELD_M: (f64, f64) = (0.5, 0.25);
/// Dash and gap of the two lines of a signalised crossing, metres.
const FORD_M: (f64, f64) = (0.5, 0.2);
/// Half the width of the lines of a signalised crossing, metres.
const FORD_HALF_M: f32 = 0.06;
/// Bar and gap of a zebra crossing, metres.
const ZEBRA_M: f64 = 0.5;

/// Kind of a line across the end of a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StopLine {
    /// Solid line of a signal or a stop sign.
    Solid,
    /// Broken line of a yield sign.
    Broken,
}

/// Returns true if a connection yields to vehicles, not only to those who walk across the road. Without rules in the file, a connection
/// that yields does so to vehicles.
fn yields_to_vehicles(net: &Network, way: &Connection) -> bool {
    let Some(junction) = net.junction_after(way.from).map(|junction| net.junction(junction)) else { return true };
    let Some(rule) = way.link.and_then(|link| junction.links.get(link as usize)) else { return true };
    let is_walker = |link: usize| {
        let foe = junction.links.get(link).and_then(|link| link.connection).map(|foe| net.connection(foe).from);
        foe.is_some_and(|from| net.edge_of(from).kind == EdgeKind::WalkingArea)
    };
    rule.yields_to.iter().next().is_none() || rule.yields_to.iter().any(|link| !is_walker(link))
}

/// Returns true if all who leave a lane yield, and only to those who walk across the road: before a zebra crossing.
pub(super) fn yields_to_walkers_alone(net: &Network, lane: LaneId) -> bool {
    let mut ways = net.connections_from(lane).iter().filter(|way| !way.is_turnaround()).peekable();
    ways.peek().is_some() && ways.all(|way| way.state == LinkState::Minor && !yields_to_vehicles(net, way))
}

/// Returns the line across the end of a lane; `None` if vehicles there have right of way.
pub(super) fn stop_line(net: &Network, lane: LaneId) -> Option<StopLine> {
    let ways = || net.connections_from(lane).iter().filter(|way| !way.is_turnaround());
    let ruled = ways().any(|way| way.signal.is_some_and(|signal| signal.index.is_some()));
    let stops = ways().any(|way| matches!(way.state, LinkState::Stop | LinkState::AllwayStop));
    // A lane has a yield line only if all its connections yield, not if only a left turn yields to oncoming traffic.
    let yields =
        ways().next().is_some() && ways().all(|way| way.state == LinkState::Minor && yields_to_vehicles(net, way));
    match (ruled || stops, yields) {
        (true, _) => Some(StopLine::Solid),
        (false, true) => Some(StopLine::Broken),
        _ => None,
    }
}

/// Adds stop lines and yield lines at the ends of lanes.
pub(super) fn stop_lines(net: &Network, paver: &mut Paver) {
    for id in net.lane_ids().filter(|id| net.is_driven(*id)) {
        let Some(stop) = stop_line(net, id) else { continue };
        let lane = net.lane(id);
        let line = LaneLine::new(lane);
        let row = line.drawn_m - BEFORE_END_M - lane.end_offset_m;
        if row < STOP_WIDTH_M {
            continue;
        }
        // The line ends 2 cm inside the lane's edges.
        let half_m = lane.half_width_m() - 0.02;
        let surface_point = |offset_m: f64| line.surface_point(row, offset_m);
        match stop {
            StopLine::Solid => {
                paver.painted_line(surface_point(-half_m), surface_point(half_m), STOP_WIDTH_M as f32 / 2.0)
            }
            StopLine::Broken => {
                for (from, to) in dashes(2.0 * half_m, YIELD_M) {
                    paver.painted_line(
                        surface_point(from - half_m),
                        surface_point(to - half_m),
                        STOP_WIDTH_M as f32 / 2.0,
                    );
                }
            }
        }
    }
}

/// Adds pedestrian crossings: two broken lines if signalised, else the bars of a zebra crossing.
pub(super) fn crossings(net: &Network, paver: &mut Paver) {
    for id in net.lane_ids().filter(|id| net.edge_of(*id).kind == EdgeKind::Crossing) {
        let lane = net.lane(id);
        let line = LaneLine::new(lane);
        let half_m = lane.half_width_m();
        let ruled = net
            .predecessors(id)
            .iter()
            .any(|before| net.connections_from(*before).iter().any(|way| way.next() == id && way.signal.is_some()));
        if ruled {
            for side_m in [-half_m, half_m] {
                for (from, to) in dashes(line.drawn_m, FORD_M) {
                    paver.painted_line(line.surface_point(from, side_m), line.surface_point(to, side_m), FORD_HALF_M);
                }
            }
        } else {
            for (from, to) in dashes(line.drawn_m, (ZEBRA_M, ZEBRA_M)) {
                let row = (from + to) / 2.0;
                paver.painted_line(
                    line.surface_point(row, -half_m),
                    line.surface_point(row, half_m),
                    (to - from) as f32 / 2.0,
                );
            }
        }
    }
}

/// Returns start and end of each dash along a length, metres, with half a gap at either end. Dashes and gaps are scaled to fit a whole
/// number of them.
fn dashes(length_m: f64, (dash_m, gap_m): (f64, f64)) -> Vec<(f64, f64)> {
    let n = (length_m / (dash_m + gap_m)).round().max(1.0);
    let period_m = length_m / n;
    let dash_m = period_m * dash_m / (dash_m + gap_m);
    let dash = |k: usize| ((k as f64 + 0.5) * period_m - dash_m / 2.0, (k as f64 + 0.5) * period_m + dash_m / 2.0);
    (0..n as usize).map(dash).collect()
}
