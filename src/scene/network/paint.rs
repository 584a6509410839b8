//! What is painted across lanes: stop lines, lines to yield at, crossings. In: right of way and signals of the network. Out: strips
//! of paint just over the asphalt. Widths are those of `docs/references.md: roads`.

use super::{lanes::LaneLine, strips::Paver};
use crate::map::network::{EdgeKind, Lane, LaneId, LinkState, Network};

/// Width of stop lines and of lines to yield at, metres.
const STOP_WIDTH_M: f64 = 0.5;
/// How far its middle is before the end of the lane, metres: SUMO's vehicles stop before the end.
const BEFORE_END_M: f64 = 0.55;
/// Dash and gap of a line to yield at, metres.
const YIELD_M: (f64, f64) = (0.5, 0.25);
/// Dash and gap of the lines beside a way for people at signals, and half the width of these lines, metres.
const FORD_M: (f64, f64) = (0.5, 0.2);
const FORD_HALF_M: f32 = 0.06;
/// Bar and gap of a zebra crossing, metres.
const ZEBRA_M: f64 = 0.5;

/// How vehicles stop at the end of a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StopLine {
    /// A whole line: a signal, or a stop sign.
    Solid,
    /// A broken line: yield.
    Broken,
}

/// What is painted at the end of a lane.
fn stop_line(net: &Network, lane: LaneId) -> Option<StopLine> {
    let ways = || net.connections_from(lane).iter().filter(|way| !way.is_turnaround());
    let ruled = ways().any(|way| way.signal.is_some_and(|signal| signal.index.is_some()));
    let stops = ways().any(|way| matches!(way.state, LinkState::Stop | LinkState::AllwayStop));
    // A left turn that lets oncoming traffic pass has no line; a lane from which every way yields has.
    let yields = ways().next().is_some() && ways().all(|way| way.state == LinkState::Minor);
    match (ruled || stops, yields) {
        (true, _) => Some(StopLine::Solid),
        (false, true) => Some(StopLine::Broken),
        _ => None,
    }
}

/// True of a lane of a street on which vehicles drive.
pub(super) fn is_driven(net: &Network, id: LaneId) -> bool {
    let lane: &Lane = net.lane(id);
    net.edge_of(id).kind.is_street() && !lane.is_footway() && !lane.is_railway()
}

/// Lines at the ends of lanes.
pub(super) fn stop_lines(net: &Network, paver: &mut Paver) {
    for id in net.lane_ids().filter(|id| is_driven(net, *id)) {
        let Some(stop) = stop_line(net, id) else { continue };
        let lane = net.lane(id);
        let line = LaneLine::new(lane);
        let row = line.drawn_m - BEFORE_END_M - lane.end_offset_m;
        if row < STOP_WIDTH_M {
            continue;
        }
        // Up to the edge line on the outside; to the middle of the line on the inside.
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

/// Ways for people across streets: bars where they have priority, two broken lines where a signal rules them.
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

/// Dashes from end to end, with half a gap at either, stretched to a whole number.
fn dashes(length_m: f64, (dash_m, gap_m): (f64, f64)) -> Vec<(f64, f64)> {
    let n = (length_m / (dash_m + gap_m)).round().max(1.0);
    let period_m = length_m / n;
    let dash_m = period_m * dash_m / (dash_m + gap_m);
    let dash = |k: usize| ((k as f64 + 0.5) * period_m - dash_m / 2.0, (k as f64 + 0.5) * period_m + dash_m / 2.0);
    (0..n as usize).map(dash).collect()
}
