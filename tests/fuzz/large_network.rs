//! Test of the memory for the largest networks: a grid by SUMO's netgenerate. No other test of this program may run while memory is
//! counted.

use crate::memory::{self, MOST};
use codrive::map::network::Network;
use std::{fs, path::Path, process::Command};

#[test]
fn a_network_of_ten_thousand_edges_is_read_within_the_memory_limit() {
    let _alone = super::alone();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("grid.net.xml");
    let sumo = Path::new(env!("CARGO_MANIFEST_DIR")).join(".sumo/sumo");
    let mut command = Command::new(sumo.join("bin/netgenerate"));
    command.args(["--grid", "--grid.number", "51", "--grid.length", "100", "-L", "2", "-j", "traffic_light"]);
    command.args(["--no-warnings", "true", "--xml-validation", "never", "-o"]).arg(&file).env("SUMO_HOME", &sumo);
    assert!(command.output().unwrap().status.success(), "{}: run scripts/setup first", sumo.display());
    let start = memory::begin();
    let text = fs::read_to_string(&file).unwrap();
    let network = Network::read(&file, &text).unwrap_or_else(|error| panic!("{error}"));
    let (_, peak) = memory::since(start);
    // Each of 51 rows and columns has 50 streets, both ways, of two lanes.
    let streets = network.edges().iter().filter(|edge| edge.kind.is_street());
    assert_eq!(streets.clone().count(), 2 * 2 * 51 * 50);
    assert!(streets.into_iter().all(|edge| edge.lanes().len() == 2));
    assert_eq!(network.signals().len(), 51 * 51);
    println!("{} bytes of text, {} MiB at most", text.len(), peak >> 20);
    assert!(peak < MOST, "{} MiB for {} bytes of text", peak >> 20, text.len());
}
