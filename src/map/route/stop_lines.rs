//! Stop lines at signals along a route. In: a [`RoadMap`]. Out: their positions, and the signal and letter that control each. Metres.

use crate::map::{RoadMap, network::SignalId};

/// Stop line at the end of a lane of the route, controlled by a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopLine {
    /// Position on the route, metres.
    pub s_m: f64,
    /// Signal that controls the line.
    pub signal: SignalId,
    /// Index of the letter in the states of the signal.
    pub link: u32,
}

/// Returns the stop lines of the route's lanes whose connection to the next lane is controlled by a signal, in driving order.
pub fn stop_lines(map: &RoadMap) -> Vec<StopLine> {
    let (net, route) = (&map.network, &map.route);
    let lanes = route.lanes();
    let pairs = (0..lanes.len()).filter_map(|k| Some((k, route.next_lane(k)?)));
    let line = |(k, next): (usize, usize)| {
        let (from, to) = (lanes[k].lane?, lanes[next].lane?);
        let ways = net.connections_from(from);
        let way = ways.iter().find(|connection| connection.next() == to)?;
        let ruled = way.signal?;
        let s_m = lanes[k].start_s_m + lanes[k].length_m - net.lane(from).end_offset_m;
        Some(StopLine { s_m, signal: ruled.signal, link: ruled.index? })
    };
    let mut lines: Vec<StopLine> = pairs.filter_map(line).collect();
    lines.sort_by(|a, b| a.s_m.total_cmp(&b.s_m));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: &str = "tests/data/networks/grid-signals.net.xml";

    #[test]
    fn stop_lines_of_a_path_belong_to_the_signals_along_it() {
        let map = RoadMap::load_along(GRID, &["B0B1", "B1C1", "C1C2"]).expect("a path");
        let net = &map.network;
        let lines = stop_lines(&map);
        let ids: Vec<&str> = lines.iter().map(|line| net.signal(line.signal).id.as_str()).collect();
        assert_eq!(ids, ["B1", "C1"]);
        // In the file, B0B1_0 and B1C1_1 have 69.20 m, and the turn between them 9.03 m.
        let places: Vec<f64> = lines.iter().map(|line| (line.s_m * 100.0).round()).collect();
        assert_eq!(places, [6920.0, 14743.0], "at the ends of the lanes: {lines:?}");
        // The file's linkIndex of the connections from B0B1_0 to B1C1 and from B1C1_1 to C1C2.
        for (line, (from, to)) in lines.iter().zip([("B0B1_0", "B1C1"), ("B1C1_1", "C1C2")]) {
            let text = std::fs::read_to_string(GRID).expect("the file");
            let (edge, lane) = from.rsplit_once('_').expect("an index");
            let of = |line: &&str| line.contains(&format!("from=\"{edge}\" to=\"{to}\" fromLane=\"{lane}\""));
            let element = text.lines().find(of).expect("a connection");
            assert!(element.contains(&format!("linkIndex=\"{}\"", line.link)), "{element} {line:?}");
        }
    }
}
