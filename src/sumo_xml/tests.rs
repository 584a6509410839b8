//! Tests of the gate with documents of a few lines. The expected results are written by hand, from SUMO's schemas and
//! the rules of XML.

use super::{gate::label, stream, *};
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

/// Writes files into a folder and copies the first as a demand.
fn copied(files: &[(&str, &[u8])]) -> Result<(String, Dropped), String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    copy(&folder.path().join(files[0].0)).map_err(|text| text.replace(&format!("{}/", folder.path().display()), ""))
}

fn copy(file: &Path) -> Result<(String, Dropped), String> {
    let text = |error| match error {
        stream::StreamError::File { file, problem } => format!("{}: {problem}", file.display()),
        stream::StreamError::Element { file, line, problem } => {
            format!("{}:{line}: {}: {}", file.display(), problem.element, problem.problem)
        }
    };
    let (bytes, dropped) = stream::copy(file, demand(), Vec::new(), &mut |_| Ok(())).map_err(text)?;
    Ok((String::from_utf8(bytes).unwrap(), dropped))
}

fn one(text: &str) -> Result<(String, Dropped), String> {
    copied(&[("a.rou.xml", text.as_bytes())])
}

#[test]
fn a_canonical_document_keeps_the_content_and_passes_unchanged() {
    let text = "\u{feff}<?xml version='1.0'?><!-- by somebody -->\n<routes xmlns:xsi='http://www.w3.org/2001/XMLSchema-instance' \
                xsi:noNamespaceSchemaLocation='http://example.org/x.xsd'>\n<vType id='a&amp;b' tau='1'  vClass=\"passenger\">words\
                <param value='1' key='junctionModel.ignoreIDs'/></vType><?do this?>\n\
                <vehicle id='&lt;&quot;&#10;&#9;' depart='0'><route edges='a  b'></route></vehicle></routes>";
    let expected = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<routes>\n    <vType id=\"a&amp;b\" tau=\"1\" vClass=\"passenger\">\n        \
                    <param key=\"junctionModel.ignoreIDs\" value=\"1\"/>\n    </vType>\n    \
                    <vehicle id=\"&lt;&quot;&#10;&#9;\" depart=\"0\">\n        <route edges=\"a  b\"/>\n    </vehicle>\n</routes>\n";
    let (first, dropped) = one(text).unwrap();
    assert_eq!(first, expected);
    assert!(dropped.is_empty(), "{dropped}");
    assert_eq!(one(&first).unwrap().0, expected);
}

#[test]
fn unsafe_parts_are_refused_with_file_line_and_remedy() {
    for (text, expected) in [
        (
            "<routes>\n<vType id='t'>\n<param key='device.ssm.file' value='/x'/></vType></routes>",
            "a.rou.xml:3: param \"device.ssm.file\": the parameter names a file",
        ),
        (
            "<routes><vType id='t'><param key='has.fcd.device' value='1'/></vType></routes>",
            "a.rou.xml:1: param \"has.fcd.device\": the parameter names",
        ),
        ("<routes>\n<vType id='t' imgFile='/x'/></routes>", "a.rou.xml:2: vType \"t\": attribute imgFile names a file"),
        (
            "<routes>\n<edgeData id='e' file='/x'/></routes>",
            "a.rou.xml:2: edgeData \"e\": SUMO writes or reads files for this element",
        ),
        (
            "<routes><vehicel id='v'/></routes>",
            "a.rou.xml:1: vehicel \"v\": unknown element in a demand (did you mean vehicle?)",
        ),
        (
            "<routes><trip id='a'><trip id='b'/></trip></routes>",
            "a.rou.xml:1: trip \"b\": the element is in the wrong place; allowed in <trip>: route, stop",
        ),
        ("<net/>", "a.rou.xml:1: net: unknown element in a demand"),
        ("<a>", "a.rou.xml:1: a: unknown element"),
        ("<!DOCTYPE routes SYSTEM 'x'>\n<routes/>", "a.rou.xml:1: <!DOCTYPE>: a document type can name other files"),
        ("<routes>\n<trip id='&x;'/></routes>", "a.rou.xml:2: trip: "),
        ("<routes><trip id='&#1;'/></routes>", "a.rou.xml:1: trip "),
        ("<routes><trip id='a' id='b'/></routes>", "a.rou.xml:1: trip: "),
        ("<routes><trip id='a'>", "a.rou.xml:1: this is not XML: the file ends before"),
        ("<routes/><routes/>", "a.rou.xml:1: this is not XML: a second outermost element"),
        ("", "a.rou.xml: the file has no element"),
    ] {
        let error = one(text).expect_err(text);
        assert!(error.starts_with(expected), "{text}: {error}");
        let is_xml = error.contains("SUMO") || error.contains("unknown element");
        assert!(!is_xml || error.ends_with("\n  remedy: remove it from the file"), "{error}");
    }
}

#[test]
fn parts_without_effect_are_dropped_and_listed_by_name() {
    let text = "<routes><trip id='a' depart='0' weather='fine'><param key='osm.profile' value='x'/></trip>\
                <trip id='b' depart='1' weather='bad'/></routes>";
    let (copy, dropped) = one(text).unwrap();
    assert!(!copy.contains("weather") && !copy.contains("profile"), "{copy}");
    let names: BTreeMap<&str, usize> = dropped.names().collect();
    assert_eq!(names, BTreeMap::from([("weather of trip", 2), ("param osm.profile of trip", 1)]));
    assert_eq!(dropped.to_string(), "2 x weather of trip, 1 x param osm.profile of trip");
    // A parameter has no child elements.
    let error = one("<routes><trip id='a'><param key='x'><edgeData/></param></trip></routes>").unwrap_err();
    assert!(error.contains("edgeData: SUMO writes or reads files"), "{error}");
    let error = one("<routes><trip id='a'><param key='x'><param key='device.ssm.file'/></param></trip></routes>");
    assert!(error.unwrap_err().contains("param \"device.ssm.file\": unknown element"));
}

#[test]
fn an_additional_file_keeps_what_moves_traffic_and_no_outputs() {
    let folder = tempfile::tempdir().unwrap();
    let copied = |text: &str| {
        let file = folder.path().join("a.add.xml");
        fs::write(&file, text).unwrap();
        match stream::copy(&file, additional(), Vec::new(), &mut |_| Ok(())) {
            Ok((bytes, dropped)) => Ok((String::from_utf8(bytes).unwrap(), dropped.to_string())),
            Err(stream::StreamError::Element { line, problem, .. }) => {
                Err(format!("{line}: {}: {}", problem.element, problem.problem))
            }
            Err(error) => Err(format!("{error:?}")),
        }
    };
    // The examples of SUMO's documentation (Definition of Public Transport, Rerouter, Calibrator, Variable Speed Signs).
    let moves = "<busStop id=\"s\" lane=\"e_0\" startPos=\"1\" endPos=\"9\" lines=\"100\">\n        <access lane=\"p_0\" pos=\"3\"/>\n    </busStop>\n    \
                 <rerouter id=\"r\" edges=\"e\">\n        <interval begin=\"0\" end=\"100\">\n            \
                 <closingReroute id=\"f\" disallow=\"passenger\"/>\n        </interval>\n    </rerouter>\n    \
                 <calibrator id=\"c\" lane=\"e_0\" pos=\"5\">\n        <flow begin=\"0\" end=\"9\" vehsPerHour=\"90\" speed=\"8\" route=\"x\"/>\n    \
                 </calibrator>\n    <variableSpeedSign id=\"v\" lanes=\"e_0\">\n        <step time=\"0\" speed=\"5\"/>\n    </variableSpeedSign>\n";
    let expected = format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<additional>\n    {moves}</additional>\n");
    let only_writes = "<edgeData id='x' file='/tmp/x'/><e3Detector id='d' file='/tmp/y'><detEntry lane='e_0' pos='1'/></e3Detector>\
                       <poly id='p' imgFile='/tmp/z'><param key='device.x.file' value='1'/></poly><edgeData id='y' file='z'/>";
    let text = format!("<additional>{only_writes}{moves}</additional>");
    let (copy, dropped) = copied(&text.replace("pos=\"5\"", "pos=\"5\" output=\"/tmp/c\"")).unwrap();
    assert_eq!(copy, expected);
    assert_eq!(dropped, "2 x edgeData, 1 x e3Detector, 1 x output of calibrator and 1 other names");
    assert_eq!(copied(&copy).unwrap(), (expected, String::new()));
    for (text, refused) in [
        ("<additional><variableSpeedSign id='v' lanes='e_0' file='/x'/></additional>", "attribute file names a file"),
        ("<additional><rerouter id='v' edges='e' file='/x'/></additional>", "attribute file names a file"),
        (
            "<additional><vType id='t'><param key='has.fcd.device' value='1'/></vType></additional>",
            "the parameter names",
        ),
        (
            "<additional><rerouter id='v' edges='e'><edgeData id='x'/></rerouter></additional>",
            "edgeData \"x\": SUMO writes",
        ),
        ("<additional><overheadWire id='w'/></additional>", "overheadWire \"w\": SUMO writes or reads files"),
    ] {
        let error = copied(text).expect_err(text);
        assert!(error.contains(refused), "{text}: {error}");
    }
}

#[test]
fn elements_of_the_lists_nest_to_a_limited_depth() {
    for vocabulary in [network(), demand(), additional()] {
        let mut depth = BTreeMap::from([("", 0)]);
        // Each round adds one level: after the largest allowed number of rounds nothing may be new.
        for round in 1..=8 {
            for rule in vocabulary.rules() {
                if rule.parents().iter().any(|parent| depth.get(parent) == Some(&(round - 1))) {
                    depth.insert(rule.name, round);
                }
            }
        }
        let deepest = depth.values().max().unwrap();
        assert!(*deepest <= 6, "{depth:?}");
        assert_eq!(depth.len(), vocabulary.rules().count() + 1, "each element can stand somewhere");
    }
}

#[test]
fn no_allowed_name_refers_to_files() {
    for rule in network().rules().chain(demand().rules()).chain(additional().rules()) {
        for name in rule.attributes().iter().chain(rule.keys()) {
            // `accelProfile` is a curve of numbers, not a file.
            let lower = name.to_lowercase().replace("accelprofile", "");
            assert!(
                !["file", "output", "device", "href", "freq"].iter().any(|word| lower.contains(word)),
                "{name} of {}",
                rule.name
            );
        }
    }
    assert_eq!(label("param", [("key", "a")].into_iter()), "param \"a\"");
}

#[test]
fn included_elements_take_the_place_of_the_include() {
    let types = b"<additional><vType id='mine' maxSpeed='9'/></additional>";
    let (copy, _) = copied(&[
        ("a.rou.xml", b"<routes><include href='sub/types.xml'/><trip id='a' type='mine' depart='3'/></routes>"),
        ("sub/types.xml", b"<routes><include href='./more.xml'></include></routes>"),
        ("sub/more.xml", types),
    ])
    .unwrap();
    let expected =
        one("<routes><vType id='mine' maxSpeed='9'/><trip id='a' type='mine' depart='3'/></routes>").unwrap();
    assert_eq!(copy, expected.0);
}

#[test]
fn includes_stay_in_the_folder_and_are_limited_in_depth_and_number() {
    let routes = |body: &str| format!("<routes>\n{body}</routes>");
    for href in ["../b.xml", "/etc/passwd", "sub/../../b.xml", "", "file:b.xml", "http://127.0.0.1/b.xml", "..\\b.xml"]
    {
        let error = one(&routes(&format!("<include href='{href}'/>"))).expect_err(href);
        assert!(
            error.starts_with(&format!("a.rou.xml:2: include \"{href}\": href is not a file of this folder")),
            "{error}"
        );
    }
    let error = one(&routes("<include href='b.xml'/>")).unwrap_err();
    assert!(
        error.contains("include \"b.xml\": b.xml: No such file") && error.contains("remedy: put the file"),
        "{error}"
    );
    let itself = copied(&[
        ("a.rou.xml", routes("<include href='b.xml'/>").as_bytes()),
        ("b.xml", routes("\n<include href='a.rou.xml'/>").as_bytes()),
    ]);
    assert!(itself.unwrap_err().starts_with("b.xml:3: include \"a.rou.xml\": the file includes itself"));
    let wrong =
        copied(&[("a.rou.xml", routes("<include href='b.xml'/>").as_bytes()), ("b.xml", b"<net/>")]).unwrap_err();
    assert!(
        wrong.starts_with("b.xml:1: net: allowed as the outermost element of an included file: routes, additional"),
        "{wrong}"
    );
    let within = one(&routes("<vehicle id='v'><include href='b.xml'/></vehicle>")).unwrap_err();
    assert!(within.contains("include \"b.xml\""), "{within}");
    // Ten files, each of which includes the next: eight are read.
    let chain: Vec<(String, String)> =
        (0..10).map(|k| (format!("{k}.xml"), routes(&format!("<include href='{}.xml'/>", k + 1)))).collect();
    let files: Vec<(&str, &[u8])> = chain.iter().map(|(name, text)| (name.as_str(), text.as_bytes())).collect();
    let deep = copied(&files).unwrap_err();
    assert!(
        deep.starts_with(
            "8.xml:2: include \"9.xml\": this is include 9 of the file, at depth 9; allowed: 256 includes, depth 8"
        ),
        "{deep}"
    );
    // Each of eight files includes the next one three times: 3^8 files.
    let many: Vec<(String, String)> =
        (0..8).map(|k| (format!("{k}.xml"), routes(&format!("<include href='{}.xml'/>", k + 1).repeat(3)))).collect();
    let mut files: Vec<(&str, &[u8])> = many.iter().map(|(name, text)| (name.as_str(), text.as_bytes())).collect();
    files.push(("8.xml", b"<routes/>"));
    let error = copied(&files).unwrap_err();
    assert!(error.contains("this is include 257 of the file"), "{error}");
}

#[cfg(unix)]
#[test]
fn an_include_through_a_link_out_of_the_folder_is_refused() {
    let (inside, outside) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let place = |name: &str| inside.path().join(name);
    fs::write(outside.path().join("secret.xml"), "<routes/>").unwrap();
    fs::write(place("here.xml"), "<routes/>").unwrap();
    let link = |to: PathBuf, name: &str| std::os::unix::fs::symlink(to, place(name)).unwrap();
    link(outside.path().join("secret.xml"), "out.xml");
    link(outside.path().into(), "folder");
    link("here.xml".into(), "in.xml");
    for (href, allowed) in [("in.xml", true), ("out.xml", false), ("folder/secret.xml", false)] {
        fs::write(place("a.rou.xml"), format!("<routes><include href='{href}'/></routes>")).unwrap();
        let result = copy(&place("a.rou.xml"));
        match allowed {
            true => assert!(result.is_ok(), "{result:?}"),
            false => {
                assert!(result.unwrap_err().contains("href is a link that leads out of the folder, to "), "{href}")
            }
        }
    }
}

#[test]
fn a_compressed_file_is_read_and_limited_by_its_unpacked_size() {
    use flate2::{Compression, write::GzEncoder};
    let packed = |text: &[u8], times: usize| {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        (0..times).for_each(|_| encoder.write_all(text).unwrap());
        encoder.finish().unwrap()
    };
    let text = "<routes><trip id='a' depart='0'/></routes>";
    assert_eq!(copied(&[("a.rou.xml.gz", &packed(text.as_bytes(), 1))]).unwrap(), one(text).unwrap());
    // A mebibyte of spaces, 257 times, in a compressed file of a megabyte.
    let mut bomb = packed(b"<routes>", 1);
    bomb.extend(packed(&vec![b' '; 1 << 20], 257));
    let error = copied(&[("a.rou.xml", &bomb)]).unwrap_err();
    assert_eq!(error, "a.rou.xml: a tag, comment or text is too long; allowed: at most 4 MiB");
    let mut bomb = packed(b"<routes>", 1);
    bomb.extend(packed(&[&vec![b' '; 1 << 20][..], b"<!---->"].concat(), 257));
    let error = copied(&[("a.rou.xml", &bomb)]).unwrap_err();
    assert_eq!(
        error,
        "a.rou.xml: the file is too large; allowed: at most 256 MiB, unpacked and with the files that it includes"
    );
    let error = copied(&[("a.rou.xml", &[0x1f, 0x8b, 1, 2, 3])]).unwrap_err();
    assert!(error.starts_with("a.rou.xml: "), "{error}");
}

#[test]
fn a_file_with_too_many_elements_is_refused() {
    let text = format!("<routes>{}</routes>", "<trip/>".repeat(stream::MOST_ELEMENTS as usize));
    let error = one(&text).unwrap_err();
    assert_eq!(error, "a.rou.xml: too many elements; allowed: at most 2000000, with the files that it includes");
}
