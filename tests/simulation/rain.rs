//! Requirements on vehicles in rain: less grip, as a handbook has it, for the full and for the light body, and where a scenario says so.

use codrive::{
    controls::Controls,
    ego::{CarParams, EgoCar, GroundSurface, LongitudinalCar, TyreParams, UniformGround, water_mm},
    scenario::Scenario,
    sim::World,
    space::Pose,
    traffic::EngineChoice,
};

/// Returns the braking distances of the full and of the light car from `speed_mps`, m.
fn braking_m(params: &CarParams, speed_mps: f64) -> [f64; 2] {
    let mut full = EgoCar::new(params, Pose::default(), speed_mps, 0).expect("a car");
    let mut light = LongitudinalCar::new(params, speed_mps).expect("a car");
    let stop = Controls { brake: 1.0, ..Controls::default() };
    let mut way_m = 0.0;
    for _ in 0..3000 {
        full.tick(&stop, &UniformGround(GroundSurface::Asphalt), &[]);
        way_m += light.tick(&stop, 0.0);
    }
    assert!(full.state().speed_mps.abs() < 0.01 && light.speed_mps().abs() < 0.01, "both stand");
    [full.state().position.x, way_m]
}

#[test]
fn wet_roads_lengthen_braking_as_the_handbooks_friction_says() {
    let wet = |water_mm: f64| {
        let tyres = TyreParams { water_mm, ..TyreParams::default() };
        CarParams { tyres, ..CarParams::default() }
    };
    // Automotive handbook of Bosch (docs/references.md: rain), new tyres: 0.85 dry, 0.65 wet and 0.55 in heavy rain up to 50 km/h.
    for (depth_mm, friction) in [(0.2, 0.65), (1.0, 0.55)] {
        let [dry_m, wet_m] = [wet(0.0), wet(depth_mm)].map(|params| braking_m(&params, 50.0 / 3.6));
        for k in [0, 1] {
            let longer = wet_m[k] / dry_m[k];
            // The brake needs the same time to build up on both, which is a few per cent of the way.
            assert!((longer / (0.85 / friction) - 1.0).abs() < 0.05, "{depth_mm} mm, body {k}: {longer}");
        }
    }
    // At 130 km/h in heavy rain the friction is 0.20 of 0.75, and grows as the car slows down.
    let [dry_m, wet_m] = [wet(0.0), wet(1.0)].map(|params| braking_m(&params, 130.0 / 3.6)[0]);
    assert!((1.8..3.75).contains(&(wet_m / dry_m)), "{dry_m} m dry, {wet_m} m in heavy rain");
}

#[test]
fn the_rain_of_a_scenario_wets_the_road_of_its_drive() {
    for rain_mmph in [0.0, 3.0, 50.0] {
        let scenario = Scenario { traffic: EngineChoice::Native, rain_mmph, ..Scenario::default() };
        let world = World::new(&scenario).expect("a world");
        assert_eq!(world.ego_params().tyres.water_mm, water_mm(rain_mmph), "{rain_mmph} mm/h");
    }
    assert_eq!(CarParams::default().tyres.water_mm, 0.0, "dry unless a scenario has rain");
}
