//! Checks of networks before SUMO reads them: the networks of this repository pass whole, and hostile ones are refused by name.

use super::*;
use std::collections::BTreeMap;

fn fault_of(text: &str) -> String {
    Network::read(FilePath::new("a.net.xml"), text).map(|_| ()).unwrap_err().to_string()
}

#[test]
fn every_network_here_passes_whole_and_its_copy_passes_unchanged() {
    for file in files() {
        let text = fs::read_to_string(&file).unwrap();
        let network = read(&file);
        let copy = network.sumo_text();
        assert!(copy.dropped().is_empty(), "{}: {}", file.display(), copy.dropped());
        if file.starts_with(root().join("maps")) {
            assert_eq!(copy.as_str(), text, "{}: ours goes byte by byte", file.display());
            continue;
        }
        let tags = |text: &str| {
            text.matches("<lane ").count() + text.matches("<request ").count() + text.matches("<phase ").count()
        };
        assert_eq!(tags(copy.as_str()), tags(&text), "{}", file.display());
        assert!(!copy.as_str().contains("<!--") && !copy.as_str().contains("xmlns"), "{}", file.display());
        let again = Network::read(&file, copy.as_str()).unwrap();
        assert!(again == network, "{}", file.display());
        assert_eq!(again.sumo_text().as_str(), copy.as_str(), "{}", file.display());
    }
}

#[test]
fn elements_that_write_or_read_files_are_refused_in_a_network() {
    let signal = |body: &str| {
        format!(
            "<net>\n<tlLogic id=\"s\" type=\"actuated\" programID=\"0\">\n{body}<phase duration=\"3\" state=\"G\"/></tlLogic></net>"
        )
    };
    for (text, expected) in [
        (
            "<net>\n<edgeData id=\"x\" file=\"/x\"/></net>".to_owned(),
            "a.net.xml:2: edgeData \"x\": SUMO writes or reads files for this element",
        ),
        (signal("<param key=\"file\" value=\"/x\"/>"), "a.net.xml:3: param \"file\": the parameter names a file"),
        (
            signal("<param key=\"whetherOutputState\" value=\"1\"/>"),
            "a.net.xml:3: param \"whetherOutputState\": the parameter names",
        ),
        (signal("<condition id=\"a\" value=\"1\"/>"), "a.net.xml:3: condition \"a\": unknown element"),
        ("<net><include href=\"/etc/x\"/></net>".into(), "a.net.xml:1: include \"/etc/x\": SUMO writes or reads files"),
        (
            "<net>\n<edge id=\"e\" imgFile=\"x\"/></net>".into(),
            "a.net.xml:2: edge \"e\": attribute imgFile names a file",
        ),
        ("<net><net/></net>".into(), "a.net.xml:1: net: the element is in the wrong place"),
        ("<!DOCTYPE net SYSTEM \"x\"><net/>".into(), "a.net.xml:1:1: this is not XML: a document type"),
    ] {
        let error = fault_of(&text);
        assert!(error.starts_with(expected), "{expected}: {error}");
        assert!(error.contains("remedy"), "{error}");
    }
}

#[test]
fn a_projection_that_names_files_is_dropped_and_a_plain_one_kept() {
    let projection = |value: &str| {
        let text = format!("<net><location netOffset=\"0,0\" projParameter=\"{value}\"/></net>");
        let network = Network::read(FilePath::new("a.net.xml"), &text).unwrap();
        let copy = network.sumo_text();
        (copy.as_str().contains(&format!("projParameter=\"{value}\"")), copy.dropped().is_empty())
    };
    for plain in [
        "!",
        "+proj=utm +zone=32 +ellps=WGS84 +datum=WGS84 +units=m +no_defs",
        "+proj=tmerc +lat_0=0 +lon_0=9 +k=0.9996 +towgs84=0,0,0",
    ] {
        assert_eq!(projection(plain), (true, true), "{plain}");
    }
    for file in [
        "+init=/tmp/x:1",
        "+proj=utm +nadgrids=@/tmp/x",
        "+proj=utm +geoidgrids=http://127.0.0.1/x",
        "/tmp/x.wkt",
        "+proj=../x",
    ] {
        assert_eq!(projection(file), (false, false), "{file}");
    }
}

#[test]
fn parameters_without_effect_are_dropped_and_counted_by_name() {
    let text = "<net><edge id=\"e\" weather=\"fine\"><lane id=\"e_0\" index=\"0\" speed=\"9\" length=\"50\" shape=\"0,0 50,0\">\
                <param key=\"origId\" value=\"7\"/></lane><param key=\"origId\" value=\"7\"/></edge></net>";
    let network = Network::read(FilePath::new("a.net.xml"), text).unwrap();
    let names: BTreeMap<&str, usize> = network.sumo_text().dropped().names().collect();
    assert_eq!(
        names,
        BTreeMap::from([("param origId of edge", 1), ("param origId of lane", 1), ("weather of edge", 1)])
    );
    assert!(!network.sumo_text().as_str().contains("origId"));
}
