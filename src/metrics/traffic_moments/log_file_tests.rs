//! Files of trajectories as logs: positions, layouts, and faults.

use super::*;

fn read(text: &str) -> Result<VehicleTrajectories, LineFault> {
    log_of(&mut text.as_bytes()).map_err(|fault| match fault {
        ReadFault::Line(fault) => fault,
        ReadFault::Io(why) => panic!("{why}"),
    })
}

/// Returns line, fault and remedy of a refused text.
fn refused(text: &str) -> LineFault {
    read(text).unwrap_err()
}

#[test]
fn a_single_leader_drives_the_integral_of_its_speeds() {
    // 10 m/s, rising by 0.5 m/s2: after t seconds 10 t + 0.25 t^2 metres.
    let rows: String = (0..=40).map(|k| format!("{},{}\n", f64::from(k) / 2.0, 10.0 + 0.25 * f64::from(k))).collect();
    let log = read(&format!("time_s,speed_mps\n{rows}")).unwrap();
    let [leader] = &log.vehicles[..] else { panic!("one vehicle") };
    assert_eq!((log.step_s, leader.name.as_str()), (0.5, "1"));
    for (k, s_m) in (0..).zip(&leader.s_m) {
        let t = f64::from(k) / 2.0;
        assert!((s_m - (10.0 * t + 0.25 * t * t)).abs() < 1e-9, "{t}: {s_m}");
    }
}

#[test]
fn a_row_of_one_vehicle_out_of_a_ring_is_a_log() {
    // Rows as in the Arizona Ring Experiments; a sensor at a standstill shows less than 0.
    let log = read("t_s,car,leader,speed_mps,x_m,gap_m\n0.0,7,6,-0.012,-178.1,7.8\n0.1,7,6,0.1,-178.1,7.8\n").unwrap();
    assert_eq!(log.vehicles[0].speed_mps, [0.0, 0.1]);
}

#[test]
fn a_platoon_has_positions_behind_its_first_vehicle() {
    // The layout of OpenACC: gaps from the front to the rear of the vehicle ahead; vehicles count as 5 m long.
    let text = "t_s,v1_audi,v2_bmw,gap2_m,v3_tesla,gap3_m\n1.0,10,10,20,10,12\n1.1,10,10,20,10,12.5\n";
    let log = read(text).unwrap();
    let names: Vec<&str> = log.vehicles.iter().map(|own| own.name.as_str()).collect();
    assert_eq!(names, ["v3", "v2", "v1"], "the rearmost first");
    let near = |found: &[f64], wanted: [f64; 2]| found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(near(&log.vehicles[2].s_m, [0.0, 1.0]) && near(&log.vehicles[1].s_m, [-25.0, -24.0]));
    assert!(near(&log.vehicles[0].s_m, [-42.0, -41.5]), "{:?}", log.vehicles[0].s_m);
}

#[test]
fn a_ring_is_cut_behind_the_first_vehicle_of_the_file() {
    // b leads a, c leads b, a leads c. So c, whose leader is the first vehicle of the file, is the first on the lane.
    let rows = |t: &str, gap_m: f64| format!("{t},a,b,5,{gap_m}\n{t},b,c,5,7\n{t},c,a,5,9\n");
    let log = read(&format!("time_s,vehicle,leader,speed_mps,gap_m\n{}{}", rows("0", 6.0), rows("1", 5.5))).unwrap();
    let found: Vec<_> = log.vehicles.iter().map(|own| (own.name.as_str(), own.s_m.clone())).collect();
    assert_eq!(found, [("a", vec![-23.0, -17.5]), ("b", vec![-12.0, -7.0]), ("c", vec![0.0, 5.0])]);
}

#[test]
fn positions_of_the_file_go_before_gaps_and_speeds() {
    let log = read("time_s,vehicle,s_m,speed_mps\n0,b,10,5\n0,a,40,5\n1,b,15.2,5\n1,a,44.9,5\n").unwrap();
    assert_eq!([&log.vehicles[0].s_m, &log.vehicles[1].s_m], [&[10.0, 15.2], &[40.0, 44.9]]);
}

#[test]
fn every_fault_of_a_log_has_its_line_and_remedy() {
    let long: String = (0..20).map(|k| format!("{k},{},36\n", 10 * k)).collect();
    let long = format!("time_s,s_m,speed_mps\n{long}");
    let cases = [
        ("time_s,speed_kmh\n0,36\n", 1, "no column \"speed_mps\"", "divide km/h by 3.6 (column speed_kmh)"),
        ("speed_mps\n5\n", 1, "no column \"time_s\"", "at least these columns in the first line: time_s,speed_mps"),
        ("time_s,speed_mps\n0,5\n0.1,-3\n", 3, "speed_mps is \"-3\"; allowed: a number from -0.5 to 60 (column 2)", ""),
        ("time_s,speed_mps\n0,5\n0.1,90\n", 3, "speed_mps is \"90\"", "write the value in this unit"),
        ("time_s,speed_mps\n0,5\n1,5\n3,5\n", 4, "at time 3 s, expected 2.000 s", "without holes"),
        ("time_s,speed_mps\n0,5\n1,5\n0.5,5\n", 4, "at time 0.5 s, expected 2.000 s", "in order"),
        ("time_s,speed_mps\n0,5\n5,5\n", 3, "the step is 5.000 s; allowed: 0.001 to 1 s", "short steps"),
        ("time_s,speed_mps\n0,5\n-1,5\n", 3, "the step is -1.000 s", "in order of time"),
        (&long, 2, "drives 190 m by its positions and 684 m by its speeds", "km/h divided by 3.6"),
        (
            "time_s,vehicle,s_m,speed_mps\n0,a,0,5\n0,b,9,5\n1,a,5,5\n1,b,9.5,1\n",
            4,
            "vehicle \"a\" at 5.00 m overlaps vehicle \"b\" at 9.50 m after 1.0 s",
            "rows of one lane",
        ),
        ("time_s,vehicle,speed_mps\n0,a,5\n0,b,5\n1,a,5\n1,b,5\n", 3, "neither positions nor a leader", "column s_m"),
        (
            "time_s,vehicle,leader,speed_mps,gap_m\n0,a,b,5,9\n0,b,a,5,9\n0,c,d,5,9\n0,d,c,5,9\n1,a,b,5,9\n1,b,a,5,9\n1,c,d,5,9\n1,d,c,5,9\n",
            4,
            "\"c\" and its leaders follow each other round a ring of their own",
            "rows of one ring, or of one vehicle alone",
        ),
    ];
    for (text, line, what, remedy) in cases {
        let fault = refused(text);
        assert!(fault.0 == line && fault.1.contains(what) && fault.2.contains(remedy), "{text}: {fault:?}");
    }
}
