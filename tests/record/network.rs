//! Recordings of drives on networks: vehicles come and go in the table of the cars, the demand goes along, and the drive replays to
//! the bit.

use super::{codrive, said};
use codrive::record::{Manifest, Table, TableReader};
use std::{collections::BTreeSet, fs, path::Path};

/// A scenario with a file of demand beside it.
fn town(folder: &Path) -> std::path::PathBuf {
    let trips: String = (0..40)
        .map(|k| format!("<trip id=\"v{k}\" depart=\"{k}\" from=\"B0B1\" to=\"B1C1\" departLane=\"best\"/>\n"))
        .collect();
    fs::write(folder.join("trips.rou.xml"), format!("<routes>\n{trips}</routes>\n")).unwrap();
    let net = fs::canonicalize("tests/data/networks/grid-signals.net.xml").unwrap();
    let text = format!(
        "map = {net:?}\npath = \"A0B0 B0B1 B1C1 C1C2 C2B2\"\nwarm_up_s = 10.0\nduration_s = 120.0\n\n[demand]\nfiles = [\"trips.rou.xml\"]\n\n\
         [[demand.flows]]\nfrom = \"A0B0\"\nto = \"B2C2\"\nper_hour = 500.0\nmix = [{{ kind = \"car\", share = 3.0 }}, {{ kind = \"truck\", \
         share = 1.0 }}]\n"
    );
    let file = folder.join("town.toml");
    fs::write(&file, text).unwrap();
    file
}

#[test]
fn a_drive_on_a_network_has_its_vehicles_in_the_tables_and_replays_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = town(folder.path());
    let hashes: Vec<Option<String>> = ["p1", "p2"]
        .map(|name| {
            let drive = folder.path().join(name);
            let arguments = ["run", "--scenario", scenario.to_str().unwrap(), "--out", drive.to_str().unwrap()];
            let (code, text) = said(&mut codrive(&arguments));
            assert!(code == 0 && text.contains("vehicles that come and go on"), "{text}");
            Manifest::load(&drive).unwrap().hash
        })
        .into();
    assert!(hashes[0].is_some() && hashes[0] == hashes[1], "{hashes:?}");

    let drive = folder.path().join("p1");
    let cars = TableReader::parquet(&Table::Cars.parquet(&drive)).unwrap();
    let (ticks, ids, lanes) = (cars.wholes("tick"), cars.ids("car"), cars.words("lane"));
    let (s_m, lane_s_m, x_m) = (cars.numbers("s_m"), cars.numbers("lane_s_m"), cars.numbers("x_m"));
    let of_step = |tick: u64| -> BTreeSet<u32> {
        (0..cars.rows()).filter(|&i| ticks[i] == tick).map(|i| ids[i].unwrap()).collect()
    };
    let (early, late) = (of_step(100), of_step(ticks[cars.rows() - 1]));
    assert!(early.contains(&0) && late.contains(&0), "the ego is there all the time");
    assert!(!early.is_subset(&late) && !late.is_subset(&early), "others come and go: {early:?} {late:?}");
    assert!(x_m.iter().all(Option::is_some));
    let beside = (0..cars.rows()).filter(|&i| s_m[i].is_none()).count();
    assert!(beside > 100 && beside < cars.rows() - 100, "{beside} of {} rows are beside the path", cars.rows());
    // A lane that the path does not go over.
    let off = (0..cars.rows()).filter(|&i| lanes[i].starts_with("B1B2"));
    assert!(off.clone().count() > 10 && off.into_iter().all(|i| s_m[i].is_none() && lane_s_m[i].is_some()));

    // The files that it was made from may be gone.
    fs::remove_file(folder.path().join("trips.rou.xml")).unwrap();
    let (code, text) = said(&mut codrive(&["analyse", drive.to_str().unwrap()]));
    assert!(code != 0 && text.contains("a drive on a network: measures are those of"), "{code} {text}");
    let (code, text) = said(&mut codrive(&["replay", drive.to_str().unwrap()]));
    assert!(code == 0 && text.contains("are the same to the bit; every file is as it was"), "{text}");
}
