//! Tests of maps as a whole: rings of many lengths, and the maps that ship.

use super::{ring::Ring, *};
use std::{fs, path::Path};

fn shipped_ring(name: &str) -> Ring {
    match name {
        "ring-250" => Ring { circumference_m: 250.0, speed_limit_mps: 30.0, width_m: 3.6 },
        "ring-641" => Ring { circumference_m: 640.9, speed_limit_mps: 17.88, width_m: 4.0 },
        _ => unreachable!("{name}"),
    }
}

/// Compares a committed network with what its generator makes now; `CODRIVE_UPDATE_MAPS=1` writes it instead.
fn compare_with_generator(name: &str, made: &str) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps").join(name).join("net.xml");
    if std::env::var_os("CODRIVE_UPDATE_MAPS").is_some() {
        fs::write(&file, made).unwrap();
    }
    let kept = fs::read_to_string(&file).unwrap();
    let line = kept.lines().zip(made.lines()).position(|(a, b)| a != b).map(|line| line + 1);
    assert!(kept == made, "{}: line {line:?} is not what the generator makes", file.display());
}

#[test]
fn the_shipped_rings_are_what_the_generator_makes() {
    for name in ["ring-250", "ring-641"] {
        compare_with_generator(name, &shipped_ring(name).net_xml().unwrap());
    }
}

#[test]
fn rings_of_any_length_add_up_and_lie_on_their_circle() {
    for circumference_m in [150.0, 250.0, 640.9, 1234.5, 5000.0] {
        let folder = tempfile::tempdir().unwrap();
        let ring = Ring { circumference_m, speed_limit_mps: 30.0, width_m: 3.6 };
        ring::write(&folder.path().join("r"), &ring, "A \"ring\"", "").unwrap();
        let map = RoadMap::load(folder.path().join("r").to_str().unwrap()).unwrap();
        assert_eq!((map.name.as_str(), map.title.as_str()), ("r", "A \"ring\""));
        assert!((map.route.length_m() - circumference_m).abs() < 1e-3, "{}", map.route.length_m());
        let radius_m = circumference_m / std::f64::consts::TAU;
        for i in 0..10_000 {
            let s_m = circumference_m * f64::from(i) / 10_000.0;
            let off = map.route.point_at(s_m).length() - radius_m;
            assert!(off < 2e-6 && off > -0.004, "{circumference_m} {s_m} {off}");
            assert!((map.route.curvature_at(s_m, 4.0) * radius_m - 1.0).abs() < 1e-3, "{circumference_m} {s_m}");
        }
        let (centre, radius) = map.bounds();
        assert!(centre.length() < 1e-6 && (radius - radius_m).abs() < 1e-5);
    }
}

#[test]
fn a_ring_out_of_range_is_refused_with_the_range() {
    let ring = |circumference_m, speed_limit_mps| Ring { circumference_m, speed_limit_mps, width_m: 3.6 }.net_xml();
    let message = |made: Result<String, MapError>| made.unwrap_err().to_string();
    assert_eq!(message(ring(149.9, 30.0)), "circumference is 149.9; allowed: 150 to 5000 m");
    assert_eq!(message(ring(f64::NAN, 30.0)), "circumference is NaN; allowed: 150 to 5000 m");
    assert_eq!(message(ring(250.0, -1.0)), "speed limit is -1; allowed: 1 to 100 m/s");
}

#[test]
fn every_shipped_map_loads_closes_and_round_trips() {
    let maps = list();
    assert!(maps.len() >= 2, "{maps:?}");
    for info in maps {
        let map = RoadMap::load(&info.name).unwrap();
        assert!(!info.title.is_empty() && !info.description.is_empty(), "{info:?}");
        let route = &map.route;
        let lanes = route.lanes();
        for (k, lane) in lanes.iter().enumerate() {
            let next = &lanes[(k + 1) % lanes.len()];
            let gap_m = lane.shape[lane.shape.len() - 1].distance(next.shape[0]);
            assert!(gap_m < 1e-3, "{}: {} ends {gap_m} m from {}", map.name, lane.id, next.id);
            assert_eq!(route.s_of(&lane.id, 1.0), Some(lane.start_s_m + 1.0));
        }
        for i in 0..2000 {
            let s_m = route.length_m() * f64::from(i) / 2000.0;
            for offset_m in [-1.5, 0.0, 1.5] {
                let left = DVec2::from_angle(route.yaw_at(s_m)).perp();
                let found = route.project(route.point_at(s_m) + left * offset_m, Some(s_m));
                assert!(route.difference(found.s_m, s_m).abs() < 0.05, "{} {s_m} {found:?}", map.name);
                assert!((found.offset_m - offset_m).abs() < 0.005, "{} {s_m} {found:?}", map.name);
            }
        }
    }
}
