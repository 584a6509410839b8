//! Tests of refusals: networks that are too large or invalid in a part that only SUMO reads, special files, and a converter that does not
//! end.

use super::*;
use std::{
    fs,
    path::Path,
    sync::atomic::AtomicBool,
    time::{Duration, Instant},
};

fn message(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.net.xml");
    fs::write(&file, text).unwrap();
    RoadMap::load(file.to_str().unwrap()).map(|map| map.name).unwrap_err().to_string()
}

fn fixture(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CODRIVE_ROOT")).join("tests/data").join(name)).unwrap()
}

#[test]
fn far_coordinates_and_lengths_are_refused_before_points_are_made() {
    let good = fixture("junctions-none.net.xml");
    let lane = good.lines().find(|line| line.contains("id=\"bc_0\"")).unwrap();
    let start = lane.find("shape=\"").unwrap() + 7;
    let point = &lane[start..start + lane[start..].find(' ').unwrap()];
    // Without limits, these took 9.4 GB and caused two panics.
    for far in ["1e8,0", "0,1e18", "0,-1e300"] {
        let refusal = message(&good.replace(lane, &lane.replacen(point, far, 1)));
        assert!(refusal.contains("lane \"bc_0\": shape is ") && refusal.contains("from -1e7 to 1e7"), "{refusal}");
    }
    let length = &lane[lane.find("length=\"").unwrap()..];
    let length = &length[..length[8..].find('"').unwrap() + 9];
    for text in ["1e308", "1e6", "-1", "0"] {
        let refusal = message(&good.replace(lane, &lane.replace(length, &format!("length=\"{text}\""))));
        assert!(
            refusal.contains(&format!("length is \"{text}\"; allowed: a number from 0.001 to 100000 m")),
            "{refusal}"
        );
    }
    // Each coordinate is within limits, but the gap between two lanes is not.
    let edges = ["ab", "bc", "cd", "da"].map(str::to_owned);
    let chosen = loop_search::ChosenEdges { edges: &edges, closed: true };
    let far = good.replace(lane, &lane.replacen(point, "9e6,0", 1));
    let refusal = RoadMap::read(Path::new("bad.net.xml"), &far, Some(chosen)).unwrap_err().to_string();
    assert!(refusal.contains("gap in the route") || refusal.contains("declared length of lane \"bc_0\""), "{refusal}");
}

#[test]
fn a_file_beyond_any_size_limit_is_refused_before_it_is_parsed() {
    let refusal = message(&format!("<net>{}</net>", "<a/>".repeat(600_000)));
    assert!(refusal.contains("the number of tags is 600002; allowed: at most 600000"), "{refusal}");
    let attributes: String = (0..257).map(|k| format!(" a{k}=\"\"")).collect();
    let refusal = message(&format!("<net{attributes}/>"));
    assert!(refusal.contains("the number of attributes of one element is 257; allowed: at most 256"), "{refusal}");
    let refusal = message(&format!("<net>{}</net>", "<a b=\"\" c=\"\" d=\"\" e=\"\" f=\"\"/>".repeat(500_001)));
    assert!(refusal.contains("the number of attributes is 2500005"), "{refusal}");
    let refusal = message(&format!("<net>{}</net>", "<a xmlns:b=\"c\"/>".repeat(17)));
    assert!(refusal.contains("the number of namespaces is 17"), "{refusal}");
    let shape = "0,0 ".repeat(20_001);
    let refusal = message(&format!(
        "<net><edge id=\"e\"><lane id=\"e_0\" speed=\"9\" length=\"9\" shape=\"{shape}\"/></edge></net>"
    ));
    assert!(refusal.contains("at most 20000"), "{}", &refusal[refusal.len() - 200..]);
}

#[test]
fn a_long_way_into_a_loop_is_searched_in_linear_time() {
    // 30,000 edges in a row lead into a ring of three; a pass over all edges would remove one of them at a time.
    let n = 30_000;
    let mut text = String::from("<net>");
    for k in 0..n + 3 {
        // Each edge of the ring is a third of a circle with a radius of 20 m.
        let on_ring = |part: usize| {
            let angle = ((k - n) as f64 + part as f64 / 12.0) * std::f64::consts::TAU / 3.0;
            format!("{:.3},{:.3} ", 20.0 * angle.cos(), 20.0 * angle.sin())
        };
        let (shape, length) = match k < n {
            true => (format!("{k},9 {},9", k + 1), 9),
            false => ((0..=12).map(on_ring).collect(), 42),
        };
        text += &format!(
            "<edge id=\"{k}\"><lane id=\"{k}_0\" speed=\"9\" length=\"{length}\" shape=\"{}\"/></edge>",
            shape.trim()
        );
    }
    for k in 0..n + 3 {
        let next = if k == n + 2 { n } else { k + 1 };
        text += &format!("<connection from=\"{k}\" to=\"{next}\" fromLane=\"0\" toLane=\"0\"/>");
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("way.net.xml");
    fs::write(&file, text + "</net>").unwrap();
    assert_eq!(RoadMap::load(file.to_str().unwrap()).unwrap().route.lanes().len(), 3);
}

#[test]
fn parts_that_only_sumo_reads_are_checked_with_line_element_and_value() {
    let good = fixture("junctions-inside.net.xml");
    let cases = [
        (
            "<junction id=\"b\" type=\"priority\"",
            "<junction id=\"b\" type=\"pirority\"",
            "junction \"b\": type is \"pirority\"",
        ),
        (
            "<junction id=\"b\" ",
            "<junction id=\"a\" ",
            "junction \"a\": id is \"a\"; allowed: a name that no other junction has",
        ),
        ("x=\"140.00\" y=\"0.00\"", "x=\"nan\" y=\"0.00\"", "junction \"b\": x is \"nan\""),
        ("incLanes=\"ab_0 ab_1\"", "incLanes=\"ab_0 ab_7\"", "incLanes is \"ab_0 ab_7\"; allowed: ids of lanes"),
        ("intLanes=\":b_0_0\"", "intLanes=\":b_0_9\"", "intLanes is \":b_0_9\""),
        ("intLanes=\":b_0_0\"", "intLanes=\":b_0_0 :c_0_0\"", "intLanes is \":b_0_0 :c_0_0\"; allowed: as many"),
        ("index=\"1\" response=\"01\"", "index=\"9\" response=\"01\"", "request: index is \"9\""),
        (
            "index=\"1\" response=\"01\"",
            "index=\"1\" response=\"0111\"",
            "response is \"0111\"; allowed: a 0 or 1 for each",
        ),
        ("foes=\"1000000\"", "foes=\"100000x\"", "foes is \"100000x\""),
        ("from=\"a\" to=\"c\"", "from=\"a\" to=\"zz\"", "edge \"ac\": to is \"zz\"; allowed: the id of a junction"),
        (
            "<edge id=\"ac\" ",
            "<edge id=\"ab\" ",
            "lane \"ac_0\": id is \"ac_0\"; allowed: the edge's id, an underscore",
        ),
        ("id=\"cd_1\" index=\"1\"", "id=\"cd_1\" index=\"3\"", "lane \"cd_1\": index is \"3\""),
        ("</net>", "<edge id=\"z\"/></net>", "edge \"z\": lane is absent; allowed: at least one lane"),
        ("<lane id=\"bc_0\"", "<lame id=\"bc_0\"", "lame \"bc_0\": unknown element in a network (did you mean lane?)"),
        ("toLane=\"1\" via=\":c_1_0\" dir=\"l\"", "toLane=\"1\" via=\":c_1_0\" dir=\"x\"", "dir is \"x\""),
        ("dir=\"t\" state=\"M\"", "dir=\"t\" state=\"?\"", "state is \"?\""),
        (
            "dir=\"t\" state=\"M\"",
            "dir=\"t\" state=\"M\" tl=\"a\" linkIndex=\"0\"",
            "tl is \"a\"; allowed: the id of a tlLogic",
        ),
        ("</net>", "<tlLogic id=\"a\"><phase duration=\"-3\" state=\"G\"/></tlLogic></net>", "duration is \"-3\""),
        ("version=\"1.20\" ", "", "net: version is absent; allowed: the version of the format"),
        (
            "<junction id=\"b\"",
            "<lane id=\"bc_0\" index=\"0\"/><junction id=\"b\"",
            "lane \"bc_0\": the element is in the wrong place; allowed in <net>: connection",
        ),
        (
            " via=\":b_0_0\"",
            "",
            "lane \":b_0_0\": id is \":b_0_0\"; allowed: a lane inside a junction that is the via of one",
        ),
        ("via=\":b_0_0\"", "via=\":a_9_0\"", "via is \":a_9_0\"; allowed: a lane that is the via of no other"),
        (
            "<connection from=\":b_0\" to=\"bc\"",
            "<prohibition from=\":b_0\" to=\"bc\"",
            "that leads to the same lane as its connection",
        ),
        (
            "from=\"bc\" to=\"cd\" fromLane=\"0\" toLane=\"0\"",
            "from=\"bc\" to=\"ae\" fromLane=\"0\" toLane=\"0\"",
            "an edge that begins at",
        ),
        (
            "</net>",
            "<connection from=\"bc\" to=\"cd\" fromLane=\"0\" toLane=\"0\"/></net>",
            "one connection from a lane to another",
        ),
        ("</net>", "<tlLogic id=\"a\"/></net>", "allowed: at least one phase"),
        (
            "</net>",
            "<tlLogic id=\"a\" type=\"off\"><phase duration=\"3\" state=\"G\"/></tlLogic></net>",
            "tlLogic \"a\": type is \"off\"; allowed: static actuated",
        ),
        (
            "</net>",
            "<tlLogic id=\"a\"><phase duration=\"3\" state=\"G\"/></tlLogic></net>",
            "tlLogic \"a\": type is absent",
        ),
        ("<edge id=\"ac\" ", "<edge id=\"ac\" bidi=\"zz\" ", "edge \"ac\": bidi is \"zz\"; allowed: the id of an edge"),
        ("</net>", "<roundabout nodes=\"a q\" edges=\"ab\"/></net>", "nodes is \"a q\""),
        ("</net>", "<location netOffset=\"1,inf\"/></net>", "netOffset is \"1,inf\""),
    ];
    for (from, to, expected) in cases {
        assert!(good.contains(from), "{from}");
        let refusal = message(&good.replacen(from, to, 1));
        assert!(refusal.contains("bad.net.xml:") && refusal.contains(expected), "{expected:?}: {refusal}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_pipe_a_device_and_a_folder_are_not_networks() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.net.xml");
    nix::unistd::mkfifo(&pipe, nix::sys::stat::Mode::S_IRWXU).unwrap();
    let refusal = RoadMap::load(pipe.to_str().unwrap()).unwrap_err().to_string();
    assert!(refusal.contains("pipe.net.xml: it is a pipe; save"), "{refusal}");
    let refusal = RoadMap::load("/dev/zero").unwrap_err().to_string();
    assert!(refusal.contains("it is a device"), "{refusal}");
    let stop = AtomicBool::new(false);
    let bounds = import::ImportOptions { seconds: 5, memory_mib: 512, stop: &stop, side: None };
    let refusal = import::import_into(folder.path(), Path::new("netconvert"), &pipe, "no", &bounds);
    assert!(refusal.unwrap_err().to_string().contains("it is a pipe"));
}

/// Makes a converter that writes down its process id and then runs `line`; returns it with a file to convert.
fn converter(folder: &Path, line: &str) -> (PathBuf, PathBuf) {
    let program = folder.join("netconvert");
    fs::write(&program, format!("#!/bin/sh\necho $$ >{}/pid\n{line}\n", folder.display())).unwrap();
    fs::set_permissions(&program, std::os::unix::fs::PermissionsExt::from_mode(0o700)).unwrap();
    let osm = folder.join("town.osm");
    fs::write(&osm, "<osm/>").unwrap();
    (program, osm)
}

#[cfg(target_os = "linux")]
#[test]
fn a_converter_that_does_not_end_is_ended_with_its_child_processes() {
    let folder = tempfile::tempdir().unwrap();
    // Without `exec`: the sleep is a process of its own.
    let (program, osm) = converter(folder.path(), "sleep 600; true");
    let maps = folder.path().join("maps");
    let stop = AtomicBool::new(false);
    let bounds = import::ImportOptions { seconds: 1, memory_mib: 512, stop: &stop, side: None };
    let gone = || {
        let pid = fs::read_to_string(folder.path().join("pid")).unwrap();
        let children = format!("/proc/{0}/task/{0}/children", pid.trim());
        assert!(!Path::new(&children).exists(), "process {} still runs", pid.trim());
        assert_eq!(fs::read_dir(&maps).unwrap().count(), 0, "nothing is left behind");
    };
    #[expect(clippy::disallowed_methods, reason = "the end of a real process is waited for")]
    let begun = Instant::now();
    let refusal = import::import_into(&maps, &program, &osm, "town", &bounds).unwrap_err().to_string();
    assert!(refusal.contains("town.osm: netconvert failed: netconvert was stopped at the time limit"), "{refusal}");
    assert!(refusal.contains("allowed: 1 s (--time-limit) and 512 MiB (--memory-limit)"), "{refusal}");
    gone();
    // The user presses Ctrl-C.
    let bounds = import::ImportOptions { seconds: 600, ..bounds };
    let ended = std::thread::scope(|scope| {
        let import = scope.spawn(|| import::import_into(&maps, &program, &osm, "town", &bounds));
        std::thread::sleep(Duration::from_millis(300));
        stop.store(true, std::sync::atomic::Ordering::Relaxed);
        import.join().unwrap().unwrap_err().to_string()
    });
    assert!(ended.contains("town.osm: the import was stopped; no file was kept"), "{ended}");
    gone();
    assert!(begun.elapsed() < Duration::from_secs(60), "ten times what it takes on a busy machine");
}

#[cfg(target_os = "linux")]
#[test]
fn a_converter_gets_no_more_memory_than_its_limit() {
    let folder = tempfile::tempdir().unwrap();
    let (program, osm) = converter(folder.path(), "exec dd if=/dev/zero of=/dev/null bs=1G count=1");
    let stop = AtomicBool::new(false);
    let bounds = import::ImportOptions { seconds: 60, memory_mib: 256, stop: &stop, side: None };
    let refusal = import::import_into(&folder.path().join("maps"), &program, &osm, "town", &bounds);
    let refusal = refusal.unwrap_err().to_string();
    assert!(refusal.contains("town.osm: netconvert failed: ") && refusal.contains("memory"), "{refusal}");
    assert!(refusal.contains("256 MiB (--memory-limit)"), "{refusal}");
}
