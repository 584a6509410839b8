//! The network equals what SUMO's own library, sumolib, reads from the same files: lanes, connections, signals, rules.

use super::*;
use serde_json::Value;
use std::{collections::BTreeSet, process::Command};

/// Returns what sumolib reads, by file.
fn read_by_sumolib(files: &[PathBuf]) -> Value {
    let tools = root().join(".sumo/sumo/tools");
    assert!(tools.is_dir(), "{}: run scripts/setup first", tools.display());
    let done = Command::new("python3").arg(networks_folder().join("read_networks.py")).arg(&tools).args(files).output();
    let done = done.expect("python3 is there");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    serde_json::from_slice(&done.stdout).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// Parses a list of lists of links.
fn rows(value: &Value) -> Vec<Vec<usize>> {
    let row = |row: &Value| row.as_array().unwrap().iter().map(|k| k.as_u64().unwrap() as usize).collect();
    value.as_array().unwrap().iter().map(row).collect()
}

fn check_lane(net: &Network, id: LaneId, theirs: &Value, place: &str) {
    let lane = net.lane(id);
    assert_eq!(lane.length_m, theirs["length"].as_f64().unwrap(), "{place}");
    assert_eq!(lane.width_m, theirs["width"].as_f64().unwrap(), "{place}");
    assert_eq!(lane.speed_limit_mps, theirs["speed"].as_f64().unwrap(), "{place}");
    let mut classes: Vec<&str> = lane.permissions.names().collect();
    classes.sort_unstable();
    let known: Vec<&str> =
        theirs["permissions"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    // sumolib lists names of old networks too if all classes are permitted.
    let known: Vec<&str> = known.into_iter().filter(|name| VehicleClasses::parse(name).list() == *name).collect();
    assert_eq!(classes, known, "{place}");
    let shape: Vec<Vec<f64>> = theirs["shape"].as_array().unwrap().iter().map(numbers).collect();
    assert_eq!(lane.shape().iter().map(|point| point.to_array().to_vec()).collect::<Vec<_>>(), shape, "{place}");
    if net.edge_of(id).kind != EdgeKind::WalkingArea && lane.shape().iter().all(|point| point.z == 0.0) {
        for (part, at) in [0.2, 0.5, 0.9].into_iter().zip(theirs["at"].as_array().unwrap()) {
            let (found, at) = (lane.line.pose(lane.length_m * part, 0.0).position, numbers(at));
            assert!((found.x - at[0]).hypot(found.y - at[1]) < 1e-6, "{place}: {found} is not {at:?}");
        }
    }
    let ways: BTreeSet<String> = theirs["ways"].as_array().unwrap().iter().map(Value::to_string).collect();
    let ours = net.connections_from(id).iter().map(|way| {
        let id = |lane: LaneId| net.lane(lane).id.clone();
        let (signal, letter) = match way.signal {
            Some(ruled) => (Some(net.signal(ruled.signal).id.clone()), ruled.index.map_or(-1, i64::from)),
            None => (None, -1),
        };
        let inside = net.edge_of(way.from).kind == EdgeKind::Internal;
        let row = serde_json::json!({
            "to": id(way.to),
            "via": way.via.map(id),
            "dir": way.direction.name(),
            "state": way.state.name(),
            "tl": signal,
            "tl_link": letter,
            // sumolib has no rules for connections that lead out of a junction.
            "link": way.link.filter(|_| !inside).map_or(-1, i64::from),
        });
        row.to_string()
    });
    assert_eq!(ours.collect::<BTreeSet<_>>(), ways, "{place}");
}

#[test]
fn lanes_connections_rules_and_signals_equal_those_of_sumolib() {
    let files = files();
    let theirs = read_by_sumolib(&files);
    let (mut lanes, mut rules) = (0, 0);
    for file in &files {
        let (net, theirs) = (read(file), &theirs[file.to_str().unwrap()]);
        let of_edges = theirs["edges"].as_object().unwrap();
        assert_eq!(net.edges().len(), of_edges.len());
        for edge in net.edges() {
            let row = &of_edges[&edge.id];
            let place = format!("{}: edge {}", file.display(), edge.id);
            let function = row["function"].as_str().filter(|word| !word.is_empty()).unwrap_or("normal");
            assert_eq!(edge.kind.name(), function, "{place}");
            let end = |junction: Option<JunctionId>| junction.or(edge.junction).map(|id| net.junction(id).id.as_str());
            assert_eq!(end(edge.from), row["from"].as_str(), "{place}");
            assert_eq!(end(edge.to), row["to"].as_str(), "{place}");
            let ids: Vec<&str> = edge.lanes().map(|lane| net.lane(lane).id.as_str()).collect();
            assert_eq!(serde_json::json!(ids), row["lanes"], "{place}");
        }
        let of_lanes = theirs["lanes"].as_object().unwrap();
        assert_eq!(net.lanes().len(), of_lanes.len());
        for id in net.lane_ids() {
            let place = format!("{}: lane {}", file.display(), net.lane(id).id);
            check_lane(&net, id, &of_lanes[&net.lane(id).id], &place);
            lanes += 1;
        }
        let total_m: f64 = of_lanes.values().map(|lane| lane["length"].as_f64().unwrap()).sum();
        assert!((net.lanes().iter().map(|lane| lane.length_m).sum::<f64>() - total_m).abs() < 1e-6);
        for (id, row) in theirs["nodes"].as_object().unwrap() {
            let junction = net.junctions().iter().find(|junction| junction.id == *id).unwrap();
            let place = format!("{}: junction {id}", file.display());
            assert_eq!(junction.kind.name(), row["type"].as_str().unwrap(), "{place}");
            let at = numbers(&row["at"]);
            assert_eq!(junction.position.to_array()[..at.len()], at[..], "{place}");
            let sets = |of: fn(&LinkRule) -> &LinkSet| -> Vec<Vec<usize>> {
                junction.links.iter().map(|link| of(link).iter().collect()).collect()
            };
            assert_eq!(sets(|link| &link.crosses), rows(&row["foes"]), "{place}");
            assert_eq!(sets(|link| &link.yields_to), rows(&row["yields"]), "{place}");
            rules += junction.links.len();
        }
        let programs = theirs["programs"].as_object().unwrap();
        for signal in net.signals() {
            // sumolib has a signal without programs where SUMO makes it.
            let known =
                programs.get(&signal.id).is_some_and(|known| known.as_object().unwrap().len() == signal.programs.len());
            assert!(known, "{}: signal {}", file.display(), signal.id);
            for program in &signal.programs {
                let row = &programs[&signal.id][&program.id];
                assert_eq!(program.kind.name(), row["type"].as_str().unwrap());
                let phases: Vec<Value> =
                    program.phases.iter().map(|phase| serde_json::json!([phase.duration_s, phase.state])).collect();
                let of_sumo = |phase: &Value| serde_json::json!([phase[0].as_f64().unwrap(), phase[1]]);
                assert_eq!(phases, row["phases"].as_array().unwrap().iter().map(of_sumo).collect::<Vec<_>>());
            }
        }
    }
    assert!(lanes > 500 && rules > 200, "{lanes} lanes, {rules} rules");
}

#[test]
fn every_lane_leads_on_or_is_an_end_and_successors_match_predecessors() {
    for file in files() {
        let net = read(&file);
        let mut ends = 0;
        for here in net.lane_ids() {
            for next in net.successors(here) {
                assert!(net.predecessors(next).contains(&here), "{}: {}", file.display(), net.lane(here).id);
                let (end, start) = (net.lane(here).shape().last().unwrap(), &net.lane(next).shape()[0]);
                // With internal lanes, a lane begins where the previous one ends, to netconvert's centimetre. Lanes of different widths
                // are aligned at their outer borders.
                let inside =
                    net.edge_of(here).kind == EdgeKind::Internal || net.edge_of(next).kind == EdgeKind::Internal;
                let apart_m = 0.05 + (net.lane(here).half_width_m() - net.lane(next).half_width_m()).abs();
                assert!(!inside || end.distance(*start) < apart_m, "{}: {}", file.display(), net.lane(here).id);
            }
            for before in net.predecessors(here) {
                assert!(net.successors(*before).any(|next| next == here));
            }
            let kind = net.edge_of(here).kind;
            if net.connections_from(here).is_empty() {
                assert_ne!(
                    kind,
                    EdgeKind::Internal,
                    "{}: {} is inside and leads nowhere",
                    file.display(),
                    net.lane(here).id
                );
                ends += usize::from(kind.is_street());
            }
        }
        let walked: usize = net
            .lane_ids()
            .filter(|lane| {
                let ways = net.connections_from(*lane);
                net.edge_of(*lane).kind.is_street()
                    && !ways.is_empty()
                    && ways.iter().all(|way| !net.edge_of(way.to).kind.is_street())
            })
            .count();
        assert_eq!(net.census().ends, ends + walked, "{}", file.display());
    }
}

#[test]
fn links_of_a_junction_are_its_internal_lanes() {
    let mut links = 0;
    for file in files() {
        let net = read(&file);
        for junction in net.junctions() {
            for (k, link) in junction.links.iter().enumerate() {
                let connection = link.connection.unwrap_or_else(|| panic!("{}: {} {k}", file.display(), junction.id));
                assert_eq!(net.connection(connection).link, Some(k as u32));
                if let Some(inside) = junction.inside.get(k) {
                    // The internal lane with that index, or for a way in two parts the second of them.
                    let next = net.connection(connection).next();
                    let second = net.successors(next).next();
                    assert!(next == *inside || second == Some(*inside), "{}: {} {k}", file.display(), junction.id);
                    links += 1;
                }
            }
        }
    }
    assert!(links > 200, "{links}");
}

#[test]
fn each_letter_of_a_signal_has_the_connections_that_name_it() {
    let mut letters = 0;
    for file in files() {
        let net = read(&file);
        for (k, connection) in net.connections().iter().enumerate() {
            let Some(SignalLink { signal, index: Some(index), .. }) = connection.signal else { continue };
            assert!(
                net.signal(signal).links[index as usize].contains(&ConnectionId::from_index(k)),
                "{}",
                file.display()
            );
            letters += 1;
        }
        for signal in net.signals() {
            for program in &signal.programs {
                assert!(program.phases.iter().all(|phase| phase.state.len() == signal.links.len()));
                assert!((0..signal.links.len() as u32).all(|link| program.phases[0].light(link).is_some()));
            }
            assert!(!signal.rules_nothing(), "{}: {}", file.display(), signal.id);
        }
    }
    // The crossings of the grid and of the two towns.
    assert!(letters > 100, "{letters}");
}

#[test]
fn the_census_counts_the_parts_of_a_network() {
    // Counted in the descriptions of `tests/data/networks/source`.
    let town = named("town").census();
    assert_eq!((town.streets, town.junctions, town.signals, town.crossings), (15, 7, 1, 2));
    assert_eq!((town.signalled, town.idle_signals, town.islands, town.has_heights()), (1, 0, 1, false));
    let one_way = named("one-way").census();
    assert_eq!((one_way.streets, one_way.lanes, one_way.islands, one_way.signals), (6, 7, 2, 0));
    let grid = named("grid-signals").census();
    // Three by three crossings, twelve streets in both directions, two lanes each.
    assert_eq!((grid.streets, grid.lanes, grid.junctions), (24, 48, 9));
    assert!(named("town-left").is_left_hand() && !named("town").is_left_hand());
    assert_eq!(named("roundabout").roundabouts().len(), 1);
    assert_eq!(named("roundabout").roundabouts()[0].edges.len(), 4);
}

#[test]
fn markings_follow_from_lane_change_permissions() {
    let net = named("town");
    let marking = |id: &str, side: Side| net.marking(lane(&net, id), side);
    assert_eq!(marking("ce_0", Side::Left), Marking::Kerb);
    assert_eq!(marking("ce_0", Side::Right), Marking::None);
    assert_eq!(marking("ce_1", Side::Right), Marking::Kerb);
    // A bicycle lane beside a lane for all other classes.
    assert_eq!(marking("ce_1", Side::Left), Marking::Solid);
    // From the bus lane only emergency vehicles may change to the left; buses and taxis may change into it.
    assert_eq!(marking("ec_1", Side::Left), Marking::Broken);
    // Vehicles may change to the lane on the left, and not back.
    assert_eq!(marking("wc_1", Side::Left), Marking::ChangeFromHere);
    assert_eq!(marking("wc_2", Side::Right), Marking::ChangeToHere);
    assert_eq!(marking("ce_2", Side::Left), Marking::Centre { overtaking: true });
    assert_eq!(marking("wn_0", Side::Left), Marking::Edge);
    assert_eq!(marking("eend_0", Side::Right), Marking::Edge);
    assert_eq!(marking(":c_1_0", Side::Left), Marking::None);
    let left = named("town-left");
    assert_eq!(left.marking(lane(&left, "cs_1"), Side::Right), Marking::Centre { overtaking: false });
    assert_eq!(left.marking(lane(&left, "ende_0"), Side::Left), Marking::Edge);
}
