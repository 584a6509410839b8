//! The page and its figures, of drives made up by hand.

use super::{super::collect::Found, *};
use crate::analysis::Measures;

/// A trial of a participant whose every measure is `value`, or is not there.
fn drive(participant: &str, condition: &str, rank: usize, value: Option<f64>) -> Analysed {
    let found = Found {
        participant: participant.into(),
        segment: "trial".into(),
        condition: condition.into(),
        rank,
        ..Found::default()
    };
    let measures = Measures { values: vec![value; MEASURES.len()], responses: Vec::new() };
    let per_second_mps = value.map_or(Vec::new(), |v| vec![v; 12]);
    let baseline_per_second_mps = Vec::new();
    Analysed { found, measures, per_second_mps, baseline_per_second_mps, duration_s: 12.0, ended: "duration".into() }
}

/// Two participants in two conditions; one number is missing.
fn drives() -> Vec<Analysed> {
    vec![
        drive("sub-P01", "few & <fast>", 0, Some(2.0)),
        drive("sub-P01", "many", 1, Some(4.0)),
        drive("sub-P02", "few & <fast>", 0, Some(3.0)),
        drive("sub-P02", "many", 1, None),
    ]
}

/// Attributes of all elements of this name in a picture.
fn all(svg: &str, name: &str, attribute: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let found = document.descendants().filter(|node| node.has_tag_name(name));
    found.filter_map(|node| node.attribute(attribute).map(str::to_owned)).collect()
}

#[test]
fn a_distribution_has_a_dot_a_trial_a_line_a_pair_and_a_mean_a_condition() {
    let svg = figures::distribution(&drives(), 0).unwrap();
    let dots = |r: &str| all(&svg, "circle", "r").into_iter().filter(|found| found == r).count();
    // Three trials with a number, two means.
    assert_eq!((dots("3"), dots("4.2")), (3, 2), "{svg}");
    assert_eq!(all(&svg, "polyline", "points").len(), 1, "one participant drove both");
    let heights: Vec<f64> = all(&svg, "circle", "cy").iter().map(|cy| cy.parse().unwrap()).collect();
    // In the order 2 and 3 and their mean 2.5, then 4 and its mean: greater is higher up, evenly.
    let [two, three, mean, four, alone] = heights[..] else { panic!("{heights:?}") };
    assert!((mean - 0.5 * (two + three)).abs() < 0.11 && (four - alone).abs() < 0.11, "{heights:?}");
    assert!((four - (two + 2.0 * (three - two))).abs() < 0.21 && four < three && three < two, "{heights:?}");
    assert!(svg.contains("few &amp; &lt;fast>") || svg.contains("few &amp; &lt;fast&gt;"));
    // One trial is no distribution.
    assert_eq!(figures::distribution(&drives()[..1], 0), None);
}

#[test]
fn speed_over_time_has_a_line_a_condition_at_the_means_of_five_seconds() {
    let svg = figures::over_time(&drives()[..3]).unwrap();
    let lines = all(&svg, "polyline", "points");
    assert_eq!(lines.len(), 2, "{svg}");
    // Twelve seconds: means at 2.5, 7.5 and 11 s, all of one height.
    for line in lines {
        let points: Vec<Vec<f64>> =
            line.split(' ').map(|point| point.split(',').map(|n| n.parse().unwrap()).collect()).collect();
        assert_eq!(points.len(), 3);
        assert!(points.iter().all(|point| point[1] == points[0][1]), "{points:?}");
        let step = |i: usize| points[i + 1][0] - points[i][0];
        assert!((step(0) / step(1) - 5.0 / 3.5).abs() < 0.01, "{points:?}");
    }
}

#[test]
fn the_page_has_every_mean_and_says_where_numbers_are_missing() {
    let mut page = Page { html: String::new(), figures: Vec::new() };
    study(&mut page, &drives());
    let row = page.html.lines().find(|line| line.starts_with("<tr><td>Mean speed of all cars, m/s</td>")).unwrap();
    // 2 and 3 have the mean 2.5; of two trials one has no number.
    assert!(row.contains("<td>2.50 [2.00, 3.00]</td>"), "{row}");
    assert!(row.contains("<td>4.00 [4.00, 4.00] (n = 1)</td>"), "{row}");
    assert!(page.html.contains("<th>few &amp; &lt;fast&gt; (n = 2)</th>") && !page.html.contains("<fast>"));
    assert!(page.figures.iter().any(|(name, _)| name == "by-condition-mean-speed-mps.svg"));

    let mut page = Page { html: String::new(), figures: Vec::new() };
    super::all(&mut page, &drives());
    let rows: Vec<&str> = page.html.lines().filter(|line| line.starts_with("<tr><td>sub-P0")).collect();
    assert_eq!(rows.len(), 4);
    assert!(rows[3].contains("<td>12.0</td>") && rows[3].matches("<td>–</td>").count() == 13, "{}", rows[3]);
    assert!(!rows[0].contains('–'));
    definitions(&mut page);
    for measure in MEASURES {
        assert!(page.html.contains(&format!("<code>{}</code>", measure.name)), "{}", measure.name);
    }
}

#[test]
fn the_page_says_which_drives_had_contacts_and_the_figure_shows_when() {
    let mut trials = drives();
    let k = index("contacts");
    trials.iter_mut().for_each(|drive| drive.measures.values[k] = Some(0.0));
    let mut page = Page { html: String::new(), figures: Vec::new() };
    contacts(&mut page, &trials);
    assert_eq!(page.html, "");
    trials[1].measures.values[k] = Some(3.0);
    contacts(&mut page, &trials);
    assert!(page.html.contains("Contacts with other cars in 1 of 4 drives: sub-P01 trial many (3)."), "{}", page.html);

    let times_s: Vec<f64> = (0..40).map(f64::from).collect();
    let ring = crate::train::Trace {
        circumference_m: 250.0,
        way_m: vec![vec![0.0, -10.0]; 40],
        speed_mps: vec![vec![4.0, 5.0]; 40],
        shown_mps: vec![None; 40],
        time_s: times_s,
        ..crate::train::Trace::default()
    };
    let traces =
        DriveTraces { ways: ring.clone(), ways_end_s: None, speeds: ring, median_speed_mps: Some(4.0), range_mps: 0.0 };
    let svg = |trial: &Trial| figures::speeds("one", &traces, trial);
    let quiet = svg(&Trial::default());
    assert!(!quiet.contains("contact") && !quiet.contains("mark</text>"));
    let contacts_at = vec![[12.0, 3.5], [30.0, 1.0]];
    let hit = svg(&Trial { contacts: 2, contacts_at, marks_at: vec![20.0], ..Trial::default() });
    let red = all(&hit, "polyline", "stroke").iter().filter(|colour| *colour == "#cc0000").count();
    assert_eq!((red, hit.matches(">contact<").count(), hit.matches(">mark<").count()), (2, 1, 1), "{hit}");
}

#[test]
fn the_page_says_who_took_part_that_nobody_drove_and_how_they_scored() {
    use crate::analysis::people::{Person, Score};
    let person = |id: &str, state: &str| Person { id: id.into(), is_simulated: true, state: state.into() };
    let all = vec![person("sub-R01", "complete"), person("sub-R02", "excluded")];
    let score = Score { questionnaire: "ssq_after".into(), name: "total".into(), values: vec![10.0, 30.0] };
    let mut page = Page { html: String::new(), figures: Vec::new() };
    let people = People { all, scores: vec![score] };
    participants(&mut page, &people);
    scores(&mut page, &people);
    for part in [
        "all participants are simulated, nobody drove",
        "Participants: 1 complete, 1 excluded (sub-R02); drives and answers of excluded ones are left out.",
        "<td>ssq_after</td><td class=\"t\">total</td><td>2</td><td>20.0 [10.0, 30.0]</td><td>10.0</td><td>30.0</td>",
    ] {
        assert!(page.html.contains(part), "{part}\n{}", page.html);
    }
    let mut page = Page { html: String::new(), figures: Vec::new() };
    participants(&mut page, &People::default());
    scores(&mut page, &People::default());
    assert_eq!(page.html, "", "a drive outside of a study has no participants");
}

#[test]
fn numbers_have_three_digits_that_count() {
    for (value, text) in [
        (123.456, "123"),
        (-45.678, "-45.7"),
        (9.996, "10.00"),
        (1.0, "1.00"),
        (0.1234, "0.123"),
        (-0.0001, "0"),
        (0.0, "0"),
        (99.96, "100.0"),
    ] {
        assert_eq!(short(value), text, "{value}");
    }
    assert_eq!(escaped(r#"a<b> & "c""#), "a&lt;b&gt; &amp; &quot;c&quot;");
}

#[test]
fn names_within_a_figure_are_its_own_on_the_page() {
    let mut page = Page { html: String::new(), figures: Vec::new() };
    let svg = r##"<svg><clipPath id="f0"/><g clip-path="url(#f0)"/></svg>"##;
    page.figure("one", Some(svg.into()));
    page.figure("none", None);
    page.figure("two", Some(svg.into()));
    assert_eq!(page.figures.iter().map(|f| f.0.as_str()).collect::<Vec<_>>(), ["one.svg", "two.svg"]);
    for own in ["id=\"p0f0\"", "url(#p0f0)", "id=\"p1f0\"", "url(#p1f0)"] {
        assert_eq!(page.html.matches(own).count(), 1, "{own}: {}", page.html);
    }
    assert!(page.figures.iter().all(|figure| figure.1 == svg), "files keep theirs");
}

#[test]
fn the_line_of_a_week_has_no_more_points_than_a_picture_can_show() {
    let mut week = drive("sub-P01", "few", 0, None);
    week.per_second_mps = (0..7 * 86_400).map(|second| f64::from(second % 5)).collect();
    let points = |svg: &str| all(svg, "polyline", "points")[0].split(' ').count();
    let drawn = points(&figures::gain("a week", &week));
    assert!((1000..=1440).contains(&drawn), "{drawn}");
    assert_eq!(points(&figures::over_time(&[week]).unwrap()), drawn);
}
