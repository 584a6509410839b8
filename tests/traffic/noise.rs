//! Strength of each engine's noise, compared with its closed form (docs/references.md: idm): a change of the acceleration by sqrt(dt) N(0,
//! noise). The standard deviation of the speed change is dt sqrt(dt) noise: 0.00632 m/s per step at 0.2 and 0.1 s.

use super::*;

/// Returns the part of every vehicle's speed changes that the model does not explain, m/s, for a flow in which no vehicle stands.
fn residuals(engine: &EngineChoice, setup: &FixedSetup, steps: usize) -> Vec<f64> {
    let history = run_free(engine, setup.clone(), steps);
    let TrafficDrivers::Alike(idm) = setup.drivers else { panic!("persons differ") };
    let (route, step_s) = (&setup.map.route, setup.step_s);
    let mut out = Vec::new();
    for pair in history.windows(2) {
        let cars = &pair[0];
        for (i, car) in cars.iter().enumerate() {
            let leader = &cars[(i + 1) % cars.len()];
            let gap_m = route.difference(car.s_m, leader.s_m) - CAR_LENGTH_M;
            let [v, ahead] = [car.speed_mps, leader.speed_mps];
            // The model as in the literature, not as the engines compute it.
            let wish = idm.s0 + (v * idm.t + v * (v - ahead) / (2.0 * (idm.a * idm.b).sqrt())).max(0.0);
            let accel = idm.a * (1.0 - (v / idm.v0).powi(4) - (wish / gap_m).powi(2));
            assert!(pair[1][i].speed_mps > 0.5, "nobody stands in this flow");
            out.push(pair[1][i].speed_mps - (v + accel * step_s));
        }
    }
    out
}

#[test]
fn noise_has_the_strength_of_its_closed_form_in_each_engine() {
    let _alone = alone();
    for engine in ENGINES {
        for (noise, step_s) in [(0.2, 0.1), (0.5, 0.1), (0.2, 0.05)] {
            let setup = FixedSetup { step_s, ..ring(noise) };
            let residuals = residuals(&engine, &setup, 500);
            // The limits are four standard errors of n independent draws.
            let n = residuals.len() as f64;
            let wanted = noise * step_s * step_s.sqrt();
            let mean = residuals.iter().sum::<f64>() / n;
            let sd = (residuals.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / n).sqrt();
            let what =
                format!("{engine}, noise {noise}, steps of {step_s} s: mean {mean:e}, sd {sd:e}, wanted {wanted:e}");
            assert!((sd / wanted - 1.0).abs() < 4.0 / (2.0 * n).sqrt(), "{what}");
            assert!(mean.abs() < 4.0 * wanted / n.sqrt(), "{what}");
            // Normal: 68.27 % lie within one standard deviation. Independent: of the same vehicle one step later, and of the next vehicle.
            let within = residuals.iter().filter(|r| r.abs() < wanted).count() as f64 / n;
            assert!((within - 0.682_69).abs() < 4.0 * (0.682_69 * 0.317_31 / n).sqrt(), "{what}: {within}");
            for (lag, of) in [(22, "a step later"), (1, "of the next car")] {
                let product: f64 = residuals.iter().zip(&residuals[lag..]).map(|(a, b)| a * b).sum();
                let correlation = product / (n * wanted * wanted);
                assert!(correlation.abs() < 4.0 / n.sqrt(), "{what}: correlation {correlation} with that {of}");
            }
        }
        // Without noise in the settings there is none: the rest is rounding.
        let most = residuals(&engine, &ring(0.0), 100).into_iter().fold(0.0_f64, |most, r| most.max(r.abs()));
        assert!(most < 1e-9, "{engine}: {most:e}");
    }
}

#[test]
fn the_noise_of_a_car_is_its_own() {
    const STEPS: usize = 100;
    let noise = |n: usize| residuals(&EngineChoice::Native, &even("ring-250", n, model(0.2), 4.0), STEPS);
    // What two rings of different size draw, by step and car, for the cars that both have.
    let (many, few) = (noise(22), noise(20));
    let apart = (0..STEPS).flat_map(|step| (0..20).map(move |car| (step, car)));
    let furthest = apart.map(|(step, car)| (many[step * 22 + car] - few[step * 20 + car]).abs()).fold(0.0, f64::max);
    assert!(furthest < 1e-9, "two cars more change nobody's noise");
    let mut of_car_3 = codrive::rng::stream(1, "vehicle/3");
    let sd_mps = 0.2 * STEP_S * STEP_S.sqrt();
    for (step, found) in many.iter().skip(3).step_by(22).enumerate() {
        let wanted = sd_mps * of_car_3.normal();
        assert!((found - wanted).abs() < 1e-9, "step {step}: {found} instead of {wanted}");
    }
}
