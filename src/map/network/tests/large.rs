//! A network of ten thousand edges is read, and finding a lane in it costs the same as in a small one.

use super::*;
use std::process::Command;

/// Makes a grid of streets in both directions, with all internal lanes, by SUMO's netgenerate.
fn grid(side: usize, folder: &FilePath) -> PathBuf {
    let sumo = root().join(".sumo/sumo");
    let program = sumo.join("bin/netgenerate");
    assert!(program.is_file(), "{}: run scripts/setup first", program.display());
    let file = folder.join(format!("grid-{side}.net.xml"));
    let mut command = Command::new(program);
    command.args(["--grid", "--grid.length", "100", "--no-warnings", "true", "--xml-validation", "never"]);
    command.arg("--grid.number").arg(side.to_string()).arg("-o").arg(&file).env("SUMO_HOME", sumo);
    assert!(command.output().unwrap().status.success());
    file
}

#[test]
fn finding_a_lane_among_ten_thousand_edges_costs_no_more_than_among_few() {
    let folder = tempfile::tempdir().unwrap();
    let mut most_near = Vec::new();
    for side in [10, 50] {
        let net = read(&grid(side, folder.path()));
        let census = net.census();
        // Each of side rows and columns has side - 1 streets in both directions.
        assert_eq!((census.streets, census.islands), (4 * side * (side - 1), 1));
        // U-turns extend slightly beyond the outermost streets.
        assert!((net.bounds().1.truncate().max_element() - 100.0 * (side - 1) as f64).abs() < 5.0);
        let every = net.lanes().len() / 500;
        let mut most = 0;
        for lane in net.lane_ids().step_by(every) {
            let at = LanePosition { lane, s_m: 0.6 * net.lane(lane).length_m, offset_m: 0.4 };
            let point = net.pose(at).position;
            let (near, free) = (net.locate(point, Some(lane)).unwrap(), net.locate(point, None).unwrap());
            assert!(near.lane == lane && (near.s_m - at.s_m).abs() < 0.001, "{at:?} {near:?}");
            assert!(net.pose(free).position.distance(point) < 0.001, "{at:?} {free:?}");
            let segments = net.grid.near(point.truncate()).iter().map(|run| run.segments().count());
            most = most.max(segments.sum());
        }
        most_near.push(most);
    }
    // The cell of a crossing lists its own lanes; others appear by chance where cells share a slot of the table.
    assert!(most_near[1] < 2 * most_near[0] && most_near[1] < 2000, "{most_near:?}");
}
