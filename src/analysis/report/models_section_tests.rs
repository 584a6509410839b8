//! The page of a planned analysis of trials made up by hand.

use super::*;
use crate::analysis::{
    data::StudyParticipants,
    measures::index,
    models::{
        plan::PlanHistory,
        planned::tests::{PLAN, drives, history},
    },
};

#[test]
fn the_page_has_plan_changes_exclusions_models_and_every_person() {
    let mut drives = drives();
    drives[4].measures.values[index("contact_count")] = Some(1.0);
    let begun = history(PLAN).begun;
    let now = history(&PLAN.replace("= 0.2", "= 0.3")).now;
    let found = PlannedAnalysis::of(&PlanHistory { begun, now }, &drives, &StudyParticipants::default()).unwrap();
    let mut page = ReportPage::default();
    section(&mut page, &found);
    for part in [
        "primary outcome Mean speed of all vehicles, m/s",
        "The plan was changed after the first session:",
        "smallest_effect: planned 0.2, now 0.3.",
        "<td class=\"t\">1 contact with other vehicles</td>",
        "<td class=\"t\">b − a</td>",
        "&lt;0.001 *",
        "No model was fitted for Reaction time",
        "Shapiro and Wilk",
    ] {
        assert!(page.html.contains(part), "{part}\n{}", page.html);
    }
    let mut page = ReportPage::default();
    section(&mut page, &PlannedAnalysis { changes: vec!["<hostile>".into()], ..found.clone() });
    assert!(page.html.contains("&lt;hostile&gt;") && !page.html.contains("<hostile>"), "{}", page.html);
    let names: Vec<&str> = page.figures.iter().map(|figure| figure.0.as_str()).collect();
    assert_eq!(
        names,
        [
            "model-mean-speed-mps.svg",
            "normal-mean-speed-mps.svg",
            "model-speed-error-mps.svg",
            "normal-speed-error-mps.svg"
        ]
    );
    // One dot per participant and condition, except for the trial left out; one mean per condition.
    let svg = &page.figures[0].1;
    assert_eq!((svg.matches("r=\"2.4\"").count(), svg.matches("r=\"4.2\"").count()), (35, 3));
    // The 35 residuals lie on both sides of the middle of their plot, from the lowest to the highest.
    let heights = page.figures[1].1.split(" cy=\"").skip(1).take(35);
    let heights: Vec<f64> = heights.map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
    let (low, high) = heights.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), y| (low.min(*y), high.max(*y)));
    assert!((50.0..150.0).contains(&(high - low)), "of the 150 units of its height: {heights:?}");
}
