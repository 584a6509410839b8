//! Closed routes on which a lane leads to two lanes of the next edge: SUMO's vehicles know the edges and choose a lane by themselves.

use super::*;
use codrive::traffic::sumo::SumoTraffic;
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// Returns a block of four streets. Street ab has one lane and bc two; ab leads to both lanes of bc, and both lead on to cd.
fn forked(folder: &Path) -> PathBuf {
    let place = |name: &str| folder.join(name);
    let node = |(id, x, y)| format!("<node id=\"{id}\" x=\"{x}\" y=\"{y}\"/>");
    let nodes: String = [("a", 60, 0), ("b", 120, 0), ("c", 120, 120), ("d", 60, 120)].map(node).concat();
    fs::write(place("block.nod.xml"), format!("<nodes>{nodes}</nodes>")).unwrap();
    let edge = |(from, to, lanes, shape): (&str, &str, u32, &str)| {
        format!("<edge id=\"{from}{to}\" from=\"{from}\" to=\"{to}\" numLanes=\"{lanes}\" speed=\"13.9\" {shape}/>")
    };
    // The bends are wide.
    let back = "shape=\"60,120 20,120 6,114 0,100 0,20 6,6 20,0 60,0\"";
    let edges: String =
        [("a", "b", 1, ""), ("b", "c", 2, ""), ("c", "d", 1, ""), ("d", "a", 1, back)].map(edge).concat();
    fs::write(place("block.edg.xml"), format!("<edges>{edges}</edges>")).unwrap();
    let way = |(from, to, lane, onto)| {
        format!("<connection from=\"{from}\" to=\"{to}\" fromLane=\"{lane}\" toLane=\"{onto}\"/>")
    };
    let ways: String =
        [("ab", "bc", 0, 0), ("ab", "bc", 0, 1), ("bc", "cd", 0, 0), ("bc", "cd", 1, 0)].map(way).concat();
    fs::write(place("block.con.xml"), format!("<connections>{ways}</connections>")).unwrap();
    let sumo = Path::new(env!("CARGO_MANIFEST_DIR")).join(".sumo/sumo");
    let mut netconvert = Command::new(sumo.join("bin/netconvert"));
    netconvert.arg("-n").arg(place("block.nod.xml")).arg("-e").arg(place("block.edg.xml"));
    netconvert.arg("-x").arg(place("block.con.xml")).arg("-o").arg(place("net.xml"));
    netconvert.args(["--no-turnarounds", "true", "--default.junctions.radius", "12"]).env("SUMO_HOME", &sumo);
    assert!(netconvert.output().unwrap().status.success());
    place("net.xml")
}

#[test]
fn cars_take_the_lane_of_the_route_where_one_leads_to_two() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let net = forked(folder.path());
    let setup = even(net.to_str().unwrap(), 6, model(0.0), 0.0);
    let route = setup.map.route.clone();
    let ids: Vec<&str> = route.lanes().iter().map(|lane| lane.id(&setup.map.network)).collect();
    assert!(ids.contains(&"bc_0") && !ids.contains(&"bc_1"), "{ids:?}");
    let drive = |traffic: &mut SumoTraffic| super::run(&setup.map, traffic, 900, |_, _| None);
    let here = drive(&mut SumoTraffic::start(setup.clone()).unwrap());
    // Each vehicle has been all round, through the fork: a lap takes less than 90 s.
    for car in 0..6 {
        let driven_m: f64 = here.iter().map(|cars| cars[car].speed_mps * STEP_S).sum();
        assert!(driven_m > route.length_m(), "car {car} drove {driven_m} m of {} m", route.length_m());
    }
    // Vehicles at the fork see the vehicles behind them: there is no collision.
    let (gap_m, _) = smallest_gap_and_way(&setup.map, &here);
    assert!(gap_m > 0.0, "{gap_m}");
}
