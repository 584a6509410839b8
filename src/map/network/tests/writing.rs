//! A network is written as it was read, and netconvert reads the written file as the same network.

use super::*;
use std::process::Command;

fn netconvert() -> (PathBuf, PathBuf) {
    let sumo = root().join(".sumo/sumo");
    let program = sumo.join("bin/netconvert");
    assert!(program.is_file(), "{}: run scripts/setup first", program.display());
    (sumo, program)
}

/// Converts a network with netconvert and reads the result.
fn converted(file: &FilePath, out: &FilePath, options: &[&str]) -> Network {
    let (sumo, program) = netconvert();
    let mut command = Command::new(program);
    command.arg("-s").arg(file).arg("-o").arg(out).args(["--no-warnings", "true", "--xml-validation", "never"]);
    let done = command.args(options).env("SUMO_HOME", sumo).output().unwrap();
    assert!(done.status.success(), "{}: {}", file.display(), String::from_utf8_lossy(&done.stderr));
    read(out)
}

#[test]
fn a_written_network_reads_as_an_equal_network() {
    for file in files() {
        let net = read(&file);
        let text = net.to_net_xml();
        let again = Network::read(&file, &text).unwrap_or_else(|error| panic!("{error}"));
        assert!(again == net, "{}", file.display());
        assert_eq!(again.to_net_xml(), text);
        assert!(!text.contains("<param"), "{}: its file has no parameters", file.display());
    }
}

#[test]
fn a_stop_line_before_the_end_of_its_lane_is_written() {
    let text = "<net><edge id=\"a\"><lane id=\"a_0\" index=\"0\" speed=\"9\" length=\"40\" endOffset=\"4\" shape=\"0,0 40,0\"/>\
                <lane id=\"a_1\" index=\"1\" speed=\"9\" length=\"40\" shape=\"0,3.2 40,3.2\"/></edge></net>";
    let file = FilePath::new("t.net.xml");
    let again = Network::read(file, &Network::read(file, text).unwrap().to_net_xml()).unwrap();
    assert_eq!(["a_0", "a_1"].map(|id| again.lane(lane(&again, id)).end_offset_m), [4.0, 0.0]);
}

/// Returns all relevant data as rows that do not depend on the order of the file. Lengths and points are rounded to a centimetre;
/// connections include settings made by hand, and signals their programs and phases.
fn essence(net: &Network) -> Vec<String> {
    let lane = |id: LaneId| net.lane(id).id.as_str();
    let lanes = |ids: &[LaneId]| ids.iter().map(|id| lane(*id)).collect::<Vec<_>>().join(" ");
    let junction = |id: Option<JunctionId>| id.map(|id| net.junction(id).id.as_str());
    let centimetres = |x: f64| (x * 100.0).round() as i64;
    let mut rows = Vec::new();
    for edge in net.edges() {
        rows.push(format!(
            "edge {} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?}",
            edge.id,
            edge.kind,
            junction(edge.from),
            junction(edge.to),
            edge.name,
            edge.road_type,
            edge.priority,
            edge.spread,
            edge.crosses.iter().map(|id| &net.edge(*id).id).collect::<Vec<_>>()
        ));
    }
    for lane_of in net.lanes() {
        let shape: Vec<[i64; 3]> = lane_of.shape().iter().map(|point| point.to_array().map(centimetres)).collect();
        rows.push(format!(
            "lane {} {} {} {} {:?} {:?} {:?} {:?} {} {shape:?}",
            lane_of.id,
            centimetres(lane_of.length_m),
            centimetres(lane_of.speed_limit_mps),
            centimetres(lane_of.width_m),
            lane_of.permissions,
            lane_of.change_left,
            lane_of.change_right,
            lane_of.opposite.map(lane),
            lane_of.acceleration
        ));
    }
    for of in net.junctions() {
        let rules: Vec<_> = of.links.iter().map(|link| (&link.yields_to, &link.crosses, link.waits_inside)).collect();
        rows.push(format!(
            "junction {} {:?} {:?} {} / {} {rules:?}",
            of.id,
            of.kind,
            of.position.to_array().map(centimetres),
            lanes(&of.incoming),
            lanes(&of.inside)
        ));
    }
    for way in net.connections() {
        let signal = way.signal.map(|ruled| (net.signal(ruled.signal).id.as_str(), ruled.index, ruled.second));
        rows.push(format!(
            "connection {} {} {:?} {:?} {:?} {signal:?} {:?} {} {:?}",
            lane(way.from),
            lane(way.to),
            way.via.map(lane),
            way.direction,
            way.state,
            way.link,
            way.keep_clear,
            way.options
        ));
    }
    for signal in net.signals() {
        rows.push(format!("signal {} {:?}", signal.id, signal.programs));
    }
    for of in net.roundabouts() {
        let edges: Vec<&str> = of.edges.iter().map(|edge| net.edge(*edge).id.as_str()).collect();
        rows.push(format!("roundabout {edges:?}"));
    }
    rows.sort();
    rows
}

#[test]
fn netconvert_reads_the_written_network_as_the_original() {
    let folder = tempfile::tempdir().unwrap();
    let (written, again, first) = (
        folder.path().join("written.net.xml"),
        folder.path().join("again.net.xml"),
        folder.path().join("first.net.xml"),
    );
    for file in files() {
        let net = read(&file);
        fs::write(&written, net.to_net_xml()).unwrap();
        // The two fixtures and the maps were not made by this netconvert with these options: the results of netconvert are compared.
        let of_file = converted(&file, &first, &[]);
        let of_written = converted(&written, &again, &[]);
        let (of_file, of_written) = (essence(&of_file), essence(&of_written));
        for (a, b) in of_file.iter().zip(&of_written) {
            assert_eq!(a, b, "{}", file.display());
        }
        assert_eq!(of_file.len(), of_written.len(), "{}", file.display());
        if file.starts_with(networks_folder()) {
            let own = essence(&net);
            for (a, b) in own.iter().zip(&of_written) {
                assert_eq!(a, b, "{}: netconvert changed what was written", file.display());
            }
        }
    }
}

#[test]
fn sumo_accepts_a_written_network() {
    let folder = tempfile::tempdir().unwrap();
    let written = folder.path().join("written.net.xml");
    let (sumo, _) = netconvert();
    for file in files() {
        fs::write(&written, read(&file).to_net_xml()).unwrap();
        let mut run = Command::new(sumo.join("bin/sumo"));
        run.arg("-n").arg(&written).args(["--end", "1", "--no-step-log", "true", "--xml-validation", "never"]);
        let done = run.env("SUMO_HOME", &sumo).output().unwrap();
        let words = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(done.status.success() && words.is_empty(), "{}: {words}", file.display());
    }
}
