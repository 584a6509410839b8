//! Cells of the tables of an evaluation, and names of its figures.

use super::*;

#[test]
fn commas_and_quotes_of_a_policys_file_stay_in_its_cell() {
    let case = |policy: &str| EvaluationCase {
        policy: policy.into(),
        hold_s: 1.0,
        driver: super::super::plan::default_driver().expect("a preset"),
        advised: Default::default(),
        ignores_advice: false,
    };
    assert_eq!(key(&case("runs/pi"), &Engine::FastRing), r#"pi,1,"follow",ring"#);
    assert_eq!(key(&case(r#"runs/a "b",c.toml"#), &Engine::FastRing), r#""a ""b"",c.toml",1,"follow",ring"#);
}

#[test]
fn a_title_becomes_a_file_name() {
    assert_eq!(
        slug("pi, hold 0.1 s, driver reaction 1 s, error 0.5 m/s"),
        "pi-hold-0.1-s-driver-reaction-1-s-error-0.5-mps"
    );
}
