//! Files of trajectories: what is read, and how faults are named.

use super::*;
use std::io::Write as _;

const HEAD: &str = "time_s,vehicle,leader,speed_mps,gap_m\n";

fn read(text: &str) -> Result<VehicleTrajectories, LineFault> {
    parsed(&mut text.as_bytes(), Some(260.0)).map_err(|fault| match fault {
        ReadFault::Line(fault) => fault,
        ReadFault::Io(why) => panic!("{why}"),
    })
}

/// Returns line, fault and remedy of a refused text.
fn refused(rows: &str) -> LineFault {
    read(&format!("{HEAD}{rows}")).unwrap_err()
}

#[test]
fn a_ring_of_two_is_read_with_columns_in_any_order() {
    let text = "speed_mps,note,vehicle,gap_m,leader,time_s\r\n3.5,x,a,6,b,10\r\n3,,b,7,a,10\r\n3.6,,a,6.1,b,10.2\r\n3.1,,b,7.1,a,10.2\r\n";
    let all = read(text).unwrap();
    assert!((all.step_s - 0.2).abs() < 1e-9 && all.ring_m == Some(260.0) && all.steps() == 2);
    let [a, b] = &all.vehicles[..] else { panic!("two vehicles") };
    assert_eq!((a.name.as_str(), a.leader, b.leader), ("a", Some(1), Some(0)));
    assert_eq!((&a.speed_mps[..], &b.gap_m[..]), (&[3.5, 3.6][..], &[7.0, 7.1][..]));
}

#[test]
fn the_first_of_a_platoon_has_neither_leader_nor_gap() {
    let all = read(&format!("{HEAD}0,1,,3,\n0,2,1,3,5\n0.1,1,,3,\n0.1,2,1,3,5\n")).unwrap();
    assert_eq!((all.vehicles[0].leader, all.vehicles[0].gap_m.len(), all.vehicles[1].leader), (None, 0, Some(0)));
}

#[test]
fn a_compressed_file_is_read_and_faults_name_file_line_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ring.csv.gz");
    let write = |text: &str| {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packed.write_all(text.as_bytes()).unwrap();
        std::fs::write(&path, packed.finish().unwrap()).unwrap();
    };
    write(&format!("{HEAD}0,1,,3,\n0.1,1,,3,\n"));
    assert_eq!(read_trajectories(&path, None).unwrap().steps(), 2);
    write(&format!("{HEAD}0,1,,fast,\n"));
    let text = read_trajectories(&path, None).unwrap_err().to_string();
    let wanted = "ring.csv.gz: line 2: speed_mps is \"fast\"; allowed: a number from -2 to 100 (column 4)\n  remedy: ";
    assert!(text.contains(wanted), "{text}");
}

#[test]
fn every_fault_has_its_line() {
    let cases = [
        ("0,1,,3,\n0.1,1,,nan,\n", 3, "speed_mps is \"nan\""),
        ("0,1,2,3,\n", 2, "gap_m is \"\""),
        ("0,1,1,3,4\n", 2, "vehicle \"1\" with leader \"1\""),
        ("0,1,,3,\n0.1,1,2,3,5\n", 3, "vehicle \"1\" follows \"2\", before it followed \"\""),
        ("0,1,,3,\n0.1,1,,3,\n0.3,1,,3,\n", 4, "vehicle \"1\" is at time 0.3 s, expected 0.200 s"),
        ("0,1,,3,\n1,1,,3,\n", 3, "the step is 1.000 s; allowed: 0.001 to 0.5 s"),
        ("0,1,,3,\n0.1,1,,3,\n0,2,1,3,4\n", 4, "vehicle \"2\" has 1 steps from 0 s on, others have 2 from 0 s on"),
        ("0,1,9,3,4\n0.1,1,9,3,4\n", 2, "leader \"9\" has no rows of its own"),
        ("", 1, "there are no two steps of a vehicle"),
    ];
    for (rows, line, what) in cases {
        let fault = refused(rows);
        assert!(fault.0 == line && fault.1.contains(what) && !fault.2.is_empty(), "{rows}: {fault:?}");
    }
    let (line, what, _) = read("time,vehicle\n").unwrap_err();
    let long = refused(&format!("0,{},,3,\n", "x".repeat(5000)));
    assert!(long.0 == 2 && long.1.contains("at most 4096 bytes"), "{long:?}");
    let many: String = (0..1001).map(|vehicle| format!("0,{vehicle},,3,\n")).collect();
    assert!(refused(&many).1.contains("1000 vehicles"));
    assert!(line == 1 && what.contains("no column \"time_s\"; the columns are \"time, vehicle\""), "{what}");
}
