//! Tests of the count of a demand. The expected numbers follow by hand from SUMO's documentation of flows.

use super::*;
use crate::traffic::Flow;

fn due(elements: &str, until_s: f64) -> Option<f64> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.rou.xml");
    std::fs::write(&file, format!("<routes><vType id=\"a\"/>{elements}</routes>")).unwrap();
    Demand { files: vec![file], ..Demand::default() }.due(until_s)
}

/// Returns the count of one file's elements before a time, s, or the text of the first fault.
fn counted(elements: &str, until_s: f64) -> Result<u64, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.rou.xml");
    std::fs::write(&file, format!("<routes>{elements}</routes>")).unwrap();
    let (mut count, mut fault) = (DemandCount::new(&Demand::default(), until_s), Ok(()));
    let mut look = |tag: &Tag| {
        fault = fault.clone().and_then(|()| count.add(tag));
        Ok(())
    };
    stream::copy(&file, sumo_xml::demand(), io::sink(), &mut look).map_err(|error| format!("{error:?}"))?;
    fault.map(|()| count.vehicles())
}

#[test]
fn vehicles_that_are_due_are_counted_as_by_hand() {
    // One departure every 1.8 s from 0 on; the one at 3.6 s is not before 3.6 s.
    let even = "<flow id=\"f\" begin=\"0\" end=\"9999\" vehsPerHour=\"2000\"/>";
    assert_eq!([0.0, 1.0, 3.6, 3.7].map(|until_s| due(even, until_s)), [0.0, 1.0, 2.0, 3.0].map(Some));
    assert_eq!(due("<flow id=\"f\" begin=\"10\" end=\"20\" number=\"5\"/>", 15.0), Some(3.0), "at 10, 12 and 14");
    assert_eq!(due("<flow id=\"f\" begin=\"10\" end=\"20\" period=\"4\"/>", 99.0), Some(3.0), "at 10, 14 and 18");
    assert_eq!(due("<flow id=\"f\" begin=\"0\" period=\"exp(0.5)\"/>", 30.0), Some(15.0));
    assert_eq!(due("<flow id=\"f\" begin=\"0\" end=\"50\" probability=\"0.2\"/>", 100.0), Some(10.0));
    assert_eq!(due("<trip id=\"t\" depart=\"3\"/><vehicle id=\"v\" depart=\"5\"/>", 4.0), Some(1.0));
    assert_eq!(due("<trip id=\"t\" depart=\"triggered\"/>", 4.0), None);
    assert_eq!(due("<flow id=\"f\" begin=\"0\"/>", 4.0), None, "no rate");
    let flow = Flow { from: "a".into(), to: "b".into(), per_hour: 720.0, mix: Vec::new() };
    assert_eq!(Demand { flows: vec![flow], ..Demand::default() }.due(10.0), Some(2.0));
    assert_eq!(Demand { files: vec!["no.rou.xml".into()], ..Demand::default() }.due(1.0), None);
}

#[test]
fn every_kind_of_rate_counts_until_the_end_of_the_drive() {
    let cases = [
        ("<flow id=\"f\" begin=\"0\" end=\"100\" number=\"7\"/>", 7),
        ("<flow id=\"f\" begin=\"0\" end=\"100\" period=\"10\"/>", 10),
        ("<flow id=\"f\" begin=\"0:00:50\" end=\"0:01:40\" period=\"10\"/>", 5),
        ("<flow id=\"f\" begin=\"0\" end=\"100\" period=\"exp(0.5)\"/>", 50),
        ("<flow id=\"f\" begin=\"0\" end=\"100\" vehsPerHour=\"360\"/>", 10),
        ("<flow id=\"f\" begin=\"0\" end=\"100\" perHour=\"720\"/>", 20),
        ("<flow id=\"f\" begin=\"0\" end=\"100\" probability=\"0.25\"/>", 25),
        ("<personFlow id=\"f\" begin=\"0\" end=\"100\" personsPerHour=\"360\"/>", 10),
        ("<personFlow id=\"f\" begin=\"0\" end=\"100\" period=\"5\"/>", 20),
        ("<containerFlow id=\"f\" begin=\"0\" end=\"100\" containersPerHour=\"3600\"/>", 100),
        // SUMO ends a flow without an end after a day; the drive ends earlier.
        ("<flow id=\"f\" begin=\"0\" period=\"1\"/>", 1000),
        ("<flow id=\"f\" period=\"1\"/>", 1000),
        // A number without a rate is spread over that day, or over the flow's own times.
        ("<flow id=\"f\" begin=\"0\" number=\"864\"/>", 10),
        ("<flow id=\"f\" begin=\"0\" end=\"2000\" number=\"100\"/>", 50),
        ("<flow id=\"f\" begin=\"0\" end=\"0\" number=\"9\"/>", 9),
        // With a number and a period, the number is the maximum.
        ("<flow id=\"f\" begin=\"0\" number=\"3\" period=\"10\"/>", 3),
        (
            "<interval begin=\"100\" end=\"200\"><flow id=\"f\" period=\"10\"/></interval><flow id=\"g\" period=\"100\"/>",
            20,
        ),
        ("<trip id=\"t\" depart=\"5\"/><vehicle id=\"v\" depart=\"triggered\"><route edges=\"a b\"/></vehicle>", 2),
        ("<person id=\"p\" depart=\"0\"><walk edges=\"a\"/></person><container id=\"c\" depart=\"1:00:00\"/>", 2),
    ];
    let wrong = |(element, expected): &(&str, u64)| {
        let found = counted(element, 1000.0);
        (found != Ok(*expected)).then(|| format!("{element}: {found:?}, not {expected}"))
    };
    let wrong: Vec<String> = cases.iter().filter_map(wrong).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let flow = Flow { from: "a".into(), to: "b".into(), per_hour: 720.0, mix: Vec::new() };
    let demand = Demand { flows: vec![flow], ..Demand::default() };
    assert_eq!(DemandCount::new(&demand, 100.0).vehicles(), 20, "flows of a scenario count, too");
    assert_eq!([Demand::horizon_s(300.0, 60.0), Demand::horizon_s(0.0, 60.0)], [360.0, 3660.0]);
}

#[test]
fn a_rate_that_no_road_carries_is_refused_with_the_rate() {
    for (attributes, expected) in [
        ("period=\"exp(1e9)\"", "period is \"exp(1e9)\", which is 1000000000 per second; allowed: at most 1000"),
        ("period=\"0.0001\"", "period is \"0.0001\", which is 10000 per second"),
        ("vehsPerHour=\"1e9\"", "vehsPerHour is \"1e9\", which is 277778 per second"),
        ("perHour=\"1e9\"", "perHour is \"1e9\", which is 277778 per second"),
        ("number=\"1001\" end=\"0\"", "number is \"1001\", which is 1001 per second"),
        ("number=\"2000000000\"", "number is \"2000000000\", which is 23148 per second"),
        ("number=\"250000\" end=\"1000\"", "number is \"250000\" brings 250000 until 1000 s; allowed: at most 200000"),
        ("period=\"exp(500)\"", "period is \"exp(500)\" brings 500000 until 1000 s; allowed: at most 200000"),
        ("period=\"0.002\"", "period is \"0.002\" brings 500000 until 1000 s"),
    ] {
        for kind in ["flow", "personFlow", "containerFlow"] {
            let fault = counted(&format!("<{kind} id=\"f\" begin=\"0\" {attributes}/>"), 1000.0).expect_err(attributes);
            assert!(fault.contains(expected), "{expected:?} is not in: {fault}");
        }
    }
}

#[test]
fn values_that_are_no_numbers_are_refused_with_what_is_allowed() {
    for (element, expected) in [
        (
            "<flow begin=\"0\" period=\"nan\"/>",
            "period is \"nan\"; allowed: seconds above 0, or exp(NUMBER PER SECOND)",
        ),
        ("<flow begin=\"0\" period=\"exp(x)\"/>", "period is \"exp(x)\""),
        ("<flow begin=\"0\" period=\"exp(1\"/>", "period is \"exp(1\""),
        ("<flow begin=\"0\" period=\"0\"/>", "period is \"0\""),
        ("<flow begin=\"0\" vehsPerHour=\"many\"/>", "vehsPerHour is \"many\"; allowed: a number above 0"),
        ("<flow begin=\"0\" perHour=\"inf\"/>", "perHour is \"inf\""),
        ("<flow begin=\"0\" probability=\"1.5\"/>", "probability is \"1.5\"; allowed: a number above 0, at most 1"),
        ("<flow begin=\"0\" number=\"-1\"/>", "number is \"-1\"; allowed: a whole number from 0"),
        ("<flow begin=\"0\" number=\"1e9\"/>", "number is \"1e9\""),
        ("<flow begin=\"soon\" number=\"1\"/>", "begin is \"soon\"; allowed: seconds from 0, h:mm:ss, triggered"),
        ("<flow begin=\"0\" end=\"never\" number=\"1\"/>", "end is \"never\"; allowed: seconds from 0, or h:mm:ss"),
        ("<flow begin=\"0\"/>", "the flow has no rate; allowed: period"),
        ("<trip depart=\"-1\"/>", "depart is \"-1\""),
        ("<route edges=\"a\" repeat=\"x\"/>", "repeat is \"x\"; allowed: a whole number from 0"),
        ("<interval begin=\"x\"/>", "begin is \"x\""),
    ] {
        let fault = counted(element, 1000.0).expect_err(element);
        assert!(fault.contains(expected), "{expected:?} is not in: {fault}");
    }
}

#[test]
fn repeated_routes_types_and_members_have_bounds() {
    assert_eq!(counted("<route id=\"r\" edges=\"a b\" repeat=\"49999\"/>", 1.0), Ok(0));
    let fault = counted("<route id=\"r\" edges=\"a b\" repeat=\"50000\"/>", 1.0).expect_err("100,002 edges");
    assert_eq!(fault, "repeat is 50000, so the route has 100002 edges; allowed: at most 100000");
    // The limit is a hundred routes of 100,000 edges each.
    let long = "<route edges=\"a b\" repeat=\"49999\"/>";
    assert_eq!(counted(&long.repeat(100), 1.0), Ok(0));
    assert!(counted(&long.repeat(101), 1.0).expect_err("too many").starts_with("repeated routes have 10100000 edges"));

    assert_eq!(counted(&"<vType/>".repeat(20_000), 1.0), Ok(0));
    assert_eq!(
        counted(&"<vType/>".repeat(20_001), 1.0),
        Err("this is type 20001 of the demand; allowed: at most 20000".into())
    );
    let fault = counted(&format!("<routeDistribution routes=\"{}\"/>", "r ".repeat(20_001)), 1.0).expect_err("members");
    assert_eq!(fault, "routes has 20001 members; allowed: at most 20000");
}
