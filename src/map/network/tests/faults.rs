//! Faults in a network are reported with file, line and value; unusual but valid networks are read.

use super::*;
use std::fmt::Write;

fn text_of(name: &str) -> String {
    fs::read_to_string(networks_folder().join(format!("{name}.net.xml"))).unwrap()
}

/// Reads a network of `tests/data/networks` in which the first `from` is replaced by `to`.
fn changed(name: &str, from: &str, to: &str) -> Result<Network, String> {
    let text = text_of(name);
    assert!(text.contains(from), "{name} has no {from}");
    Network::read(FilePath::new("bad.net.xml"), &text.replacen(from, to, 1)).map_err(|error| error.to_string())
}

#[test]
fn a_signal_without_a_program_gets_all_links_in_any_order() {
    let lane = |edge: &str, from: &str, to: &str, y: f64| {
        format!(
            "<edge id=\"{edge}\" from=\"{from}\" to=\"{to}\"><lane id=\"{edge}_0\" index=\"0\" speed=\"9\" length=\"40\" shape=\"0,{y} 40,{y}\"/></edge>"
        )
    };
    let way = |from: &str, link: u32| {
        format!(
            "<connection from=\"{from}\" to=\"c\" fromLane=\"0\" toLane=\"0\" tl=\"n\" linkIndex=\"{link}\" dir=\"s\" state=\"O\"/>"
        )
    };
    let junction = |id: &str, kind: &str, lanes: &str| {
        format!("<junction id=\"{id}\" type=\"{kind}\" x=\"0\" y=\"0\" incLanes=\"{lanes}\" intLanes=\"\" shape=\"\"/>")
    };
    let text = lane("a", "m", "n", 0.0) + &lane("b", "m", "n", 4.0) + &lane("c", "n", "m", 8.0);
    let nodes = junction("m", "dead_end", "c_0") + &junction("n", "rail_signal", "a_0 b_0");
    let text = format!("<net version=\"1.20\">{text}{nodes}{}{}</net>", way("a", 1), way("b", 0));
    let net = Network::read(FilePath::new("t.net.xml"), &text).unwrap_or_else(|error| panic!("{error}"));
    let ways: Vec<usize> = net.signals()[0].links.iter().map(Vec::len).collect();
    assert_eq!(ways, [1, 1]);
}

#[test]
fn an_invalid_value_is_refused_with_file_line_element_and_allowed_values() {
    let signal = "<tlLogic id=\"c\" type=\"static\" programID=\"0\" offset=\"0\"><phase duration=\"3\" state=\"rrrrrrrrrrrrrrrrrrrrr\"/></tlLogic>";
    let twice = format!("{signal}<junction id=\"c\"");
    for (name, from, to, expected) in [
        ("ramps", "length=\"", "length=\"0\" was=\"", "length is \"0\"; allowed: a number from 0.001 to 100000 m"),
        ("ramps", "<connection from=\"before\"", "<connection from=\"nowhere\"", "the id of an edge of this network"),
        ("track", "<connection from=\"ab\" to=\"bc\"", "<connection from=\"ab\" to=\"nowhere\"", "to is \"nowhere\""),
        ("track", "toLane=\"0\" via=\":b_1_0\"", "toLane=\"7\" via=\":b_1_0\"", "toLane is \"7\""),
        ("town", "<neigh lane=\"", "<neigh lane=\"x", "allowed: the id of a lane of this network"),
        ("town", "crossingEdges=\"", "crossingEdges=\"x ", "crossingEdges is \"x "),
        ("town", "<junction id=\"c\"", &twice, "allowed: a name that no other program of this signal has"),
        ("town", "tl=\"c\" linkIndex=\"0\"", "tl=\"c\" linkIndex=\"99\"", "linkIndex is \"99\""),
        ("town", "tl=\"c\" linkIndex=\"0\"", "tl=\"d\" linkIndex=\"0\"", "tl is \"d\"; allowed: the id of a tlLogic"),
        ("one-way", "spreadType=\"center\"", "spreadType=\"left\"", "allowed: right, center or roadCenter"),
        ("hill", "z=\"", "z=\"1e9\" was=\"", "z is \"1e9\"; allowed: a number from -1e7 to 1e7 m"),
        ("track", "state=\"Z\"", "state=\"Z\" keepClear=\"maybe\"", "keepClear is \"maybe\"; allowed: 0 or 1"),
    ] {
        let message = changed(name, from, to).map(|net| net.census()).unwrap_err();
        assert!(message.contains("bad.net.xml:") && message.contains(expected), "{expected:?} is not in: {message}");
    }
}

#[test]
fn idle_signals_islands_and_unknown_classes_are_read_and_counted() {
    let idle = "<tlLogic id=\"idle\" type=\"static\" programID=\"a\" offset=\"begin\"><phase duration=\"30\" state=\"Gr\" name=\"go\"/>\
                <phase duration=\"5\" minDur=\"3\" maxDur=\"9\" state=\"ry\"/><param key=\"k\" value=\"v\"/></tlLogic><junction id=\"b\"";
    let net = changed("track", "<junction id=\"b\"", idle).unwrap();
    let census = net.census();
    assert_eq!((census.signals, census.idle_signals), (net.signals().len(), 1));
    let signal = net.signals().iter().find(|signal| signal.id == "idle").unwrap();
    assert!(signal.rules_nothing());
    let program = &signal.programs[0];
    assert_eq!((program.cycle_s(), program.offset_s, program.phases[1].max_s), (35.0, None, Some(9.0)));
    assert_eq!(program.phases[0].light(0), Some(SignalLight::GreenMajor));
    assert_eq!((program.phases[1].light(1), program.phases[1].light(2)), (Some(SignalLight::Yellow), None));
    // A class of a later SUMO version: no known class may drive there.
    let net = changed("track", "allow=\"tram rail\"", "allow=\"hovercraft\"").unwrap();
    assert!(net.lanes().iter().any(|lane| lane.permissions.is_empty()));
}

#[test]
fn a_network_without_junctions_joins_edges_by_junction_name() {
    let text = "<net><edge id=\"a\" from=\"n\" to=\"m\"><lane id=\"a_0\" speed=\"9\" length=\"50\" shape=\"0,0 50,0\"/></edge>\
                <edge id=\"b\" from=\"m\" to=\"n\"><lane id=\"b_0\" speed=\"9\" length=\"50\" shape=\"50,5,3 0,5,1\"/></edge>\
                <connection from=\"a\" to=\"b\" fromLane=\"0\" toLane=\"0\"/></net>";
    let net = Network::read(FilePath::new("n"), text).unwrap();
    let (a, b) = (net.edge(net.edge_named("a").unwrap()), net.edge(net.edge_named("b").unwrap()));
    assert_eq!((a.to, a.from), (b.from, b.to));
    assert!(net.junctions().iter().all(|junction| !junction.declared) && net.junctions().len() == 2);
    assert_eq!(net.successors(lane(&net, "a_0")).collect::<Vec<_>>(), [lane(&net, "b_0")]);
    assert_eq!((net.census().ends, net.census().islands), (1, 1));
}

#[test]
fn coordinates_and_shapes_at_the_limits_are_found_in_little_memory() {
    // A lane of 28,000 km, and another of 20,000 points in one place.
    let mut text = String::from(
        "<net><edge id=\"a\" to=\"m\"><lane id=\"a_0\" speed=\"9\" length=\"100000\" shape=\"-1e7,-1e7 1e7,1e7\"/></edge>\
         <edge id=\"b\" to=\"n\"><lane id=\"b_0\" speed=\"9\" length=\"5\" shape=\"",
    );
    for k in 0..20_000 {
        let _ = write!(text, "{},{} ", f64::from(k) * 2e-6, f64::from(k % 2) * 3e-6);
    }
    text += "\"/></edge></net>";
    let net = Network::read(FilePath::new("n"), &text).unwrap();
    assert!(net.grid.bytes() < 16 << 20, "{} bytes", net.grid.bytes());
    let at = LanePosition { lane: lane(&net, "a_0"), s_m: 75_000.0, offset_m: 1.0 };
    let found = net.locate(net.pose(at).position, None).unwrap();
    assert!(found.lane == at.lane && (found.s_m - at.s_m).abs() < 1e-6, "{found:?}");
    assert_eq!(net.locate(glam::dvec3(0.02, 0.0, 0.0), Some(lane(&net, "b_0"))).unwrap().lane, lane(&net, "b_0"));
}

#[test]
fn a_stop_line_before_the_end_of_its_lane_is_read() {
    let text = "<net><edge id=\"a\"><lane id=\"a_0\" index=\"0\" speed=\"9\" length=\"40\" endOffset=\"4\" shape=\"0,0 40,0\"/>\
                <lane id=\"a_1\" index=\"1\" speed=\"9\" length=\"40\" shape=\"0,3.2 40,3.2\"/></edge></net>";
    let net = Network::read(FilePath::new("t.net.xml"), text).unwrap();
    assert_eq!(["a_0", "a_1"].map(|id| net.lane(lane(&net, id)).end_offset_m), [4.0, 0.0]);
}

#[test]
fn a_wrong_index_is_read_inside_junctions_where_netconvert_writes_it() {
    let other = |lane: &str| {
        let (right, wrong) = (format!("\"{lane}\" index=\"1\""), format!("\"{lane}\" index=\"0\""));
        changed("grid-signals", &right, &wrong)
    };
    let net = other(":A1_0_1").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(net.index_in_edge(lane(&net, ":A1_0_1")), 1);
    let error = other("A0A1_1").unwrap_err();
    assert!(error.contains("lane \"A0A1_1\": index is \"0\"; allowed: the lane's place in its edge"), "{error}");
}
