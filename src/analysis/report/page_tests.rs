//! The page and its figures, for drives made up by hand.

use super::{
    by_condition::study,
    dictionary::dictionary,
    drive_section::one_by_one,
    drivers_section,
    every_drive::every,
    figures, glossary,
    page::{ReportFigure, ReportPage, STYLE, short},
    scores_section::scores,
    study_report::{FileProof, faults, report, took_part},
    words,
};
use crate::analysis::{
    data::{
        DriveTrajectories, RecordedTrial, SicknessRating, StudyParticipants,
        people::{self},
    },
    drivers::{
        FoundDriver, FoundNumber, ParticipantDriver,
        participants::{self},
    },
    drives::{
        AnalysedRecording,
        test_drives::{drive, drives, mixed_drives},
    },
    measures::{MEASURES, index},
    tables,
};
use crate::metrics::RoadKinds;

/// Returns an attribute of all elements of this name in a picture.
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
    let joins = |d: &&String| d.matches('M').count() == 1 && d.starts_with('M') && d.contains('L');
    assert_eq!(
        all(&svg, "path", "d").iter().filter(joins).count(),
        2,
        "one drove both; one mean has an interval: {svg}"
    );
    let heights: Vec<f64> = all(&svg, "circle", "cy").iter().map(|cy| cy.parse().unwrap()).collect();
    // Order: 2 and 3 and their mean 2.5, then 4 and its mean. Greater values are higher up, evenly.
    let [two, three, mean, four, alone] = heights[..] else { panic!("{heights:?}") };
    assert!((mean - 0.5 * (two + three)).abs() < 0.11 && (four - alone).abs() < 0.11, "{heights:?}");
    assert!((four - (two + 2.0 * (three - two))).abs() < 0.21 && four < three && three < two, "{heights:?}");
    assert!(svg.contains("few &amp; &lt;fast>") || svg.contains("few &amp; &lt;fast&gt;"));
    // One trial is not a distribution.
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
    let mut page = ReportPage::default();
    study(&mut page, &drives());
    let row = page.html.lines().find(|line| line.starts_with("<tr><td>Mean speed of all vehicles, m/s</td>")).unwrap();
    // 2 and 3 have the mean 2.5. One of two participants has no number in "many", and a single number has no interval.
    assert!(row.contains("<td>2.50 [2.00, 3.00]</td>"), "{row}");
    assert!(row.contains("<td>4.00 (N = 1)</td>"), "{row}");
    assert!(page.html.contains("<th>few &amp; &lt;fast&gt; (N = 2)</th>") && !page.html.contains("<fast>"));
    assert!(page.figures.iter().any(|(name, _)| name == "by-condition-mean-speed-mps.svg"));
    // Differences of 1, 2 and 3 m/s: (2.80 x 1 / 2)^2 = 1.96 participants would detect them.
    let mut three = Vec::new();
    for (participant, few, many) in [("sub-P01", 3.0, 4.0), ("sub-P02", 2.0, 4.0), ("sub-P03", 5.0, 8.0)] {
        three.extend([drive(participant, "few", 0, Some(few)), drive(participant, "many", 1, Some(many))]);
    }
    let mut page = ReportPage::default();
    study(&mut page, &three);
    let row = page.html.lines().find(|line| line.contains("few → many"));
    assert!(row.is_some_and(|row| row.ends_with("<td>2</td></tr>")), "{row:?}");
    // Without numbers there is no distribution to refer to.
    let mut page = ReportPage::default();
    study(&mut page, &[drive("sub-P01", "few", 0, None), drive("sub-P02", "many", 1, None)]);
    assert!(page.figures.is_empty() && !page.html.contains("the distribution of one measure"), "{}", page.html);
    for (n, title, what) in
        [(1, "The drive in numbers", "the measures of the drive;"), (2, "All drives", "every drive;")]
    {
        let mut page = ReportPage::default();
        every(&mut page, &drives()[..n]);
        assert!(page.html.starts_with(&format!("<h2>{title}</h2>")) && page.html.contains(what), "{}", page.html);
    }

    // A few drives are columns of one table; more are rows of two tables.
    let mut page = ReportPage::default();
    every(&mut page, &drives());
    let row = page.html.lines().find(|line| line.contains("<td>Minimum gap, m</td>")).unwrap();
    assert!(row.ends_with("<td>2.00</td><td>4.00</td><td>3.00</td><td>–</td></tr>"), "{row}");
    // No drive here has measures of networks.
    let roads = RoadKinds { closed: true, networks: false };
    assert_eq!(page.html.matches("<tr><td>").count(), MEASURES.iter().filter(|measure| measure.is_on(roads)).count());
    let mut page = ReportPage::default();
    every(&mut page, &[drives(), drives()].concat());
    let rows: Vec<&str> = page.html.lines().filter(|line| line.contains("<tr><td>sub-P0")).collect();
    assert_eq!(rows.len(), 16, "eight drives in two tables");
    assert!(rows[3].contains("<td>12.0</td>") && rows[3].matches("<td>–</td>").count() == 6, "{}", rows[3]);
    assert!(!rows[0].contains('–'));
    let mut page = ReportPage::default();
    dictionary(&mut page, &drives());
    for column in glossary::tables(&drives()).iter().flat_map(|table| &table.columns) {
        assert!(page.html.contains(&format!("<code>{}</code>", column.name)), "{}", column.name);
    }
}

#[test]
fn drives_one_by_one_of_a_study_are_those_of_its_first_participant() {
    let mut drives = drives();
    // A drive of the second participant with a baseline: to show it, the baseline would have to be read.
    drives[2].found.baseline = Some("no such drive".into());
    let mut page = ReportPage::default();
    one_by_one(&mut page, &drives, true).unwrap();
    assert_eq!(page.html, "");
}

#[test]
fn networks_and_closed_routes_share_a_page_that_names_missing_measures() {
    let head = |drives: &[AnalysedRecording]| tables::trials(drives).lines().next().unwrap().to_owned();
    let [rings, mixed] = [drives(), mixed_drives()];
    assert!(!head(&rings).contains("travel_time_s") && head(&mixed).contains(",passages_per_h,"));
    assert!(head(&mixed).contains(",travel_time_s,") && head(&mixed).starts_with(&head(&rings)));
    let about = |drives: &[AnalysedRecording], name: &str| {
        let tables = glossary::tables(drives);
        let column = tables[0].columns.iter().find(|column| column.name == name);
        column.map(|column| column.about.clone())
    };
    let why = "not on networks: no point is passed by all vehicles";
    assert!(about(&mixed, "passages_per_h").unwrap().contains(why));
    assert!(about(&mixed[..2], "passages_per_h").unwrap().contains(why));
    assert!(!about(&rings, "passages_per_h").unwrap().contains("network"));
    assert!(about(&mixed, "trips").unwrap().contains("; on networks alone"));
    assert!(!about(&mixed[..2], "trips").unwrap().contains("alone") && about(&rings, "trips").is_none());
    // With networks only, the page has no rows of measures of closed routes, and names these.
    let page_of = |drives: &[AnalysedRecording]| {
        let mut page = ReportPage::default();
        every(&mut page, drives);
        page.html
    };
    let title = "Standard deviation of speed over vehicles";
    let [of_rings, of_mixed, of_networks] = [&rings[..], &mixed, &mixed[..2]].map(page_of);
    assert!(of_rings.contains(&format!("<td>{title}, m/s</td>")) && !of_rings.contains("Not measured on networks"));
    assert!(of_mixed.contains(&format!("<td>{title}, m/s</td>")) && of_mixed.contains("<td>Red lights passed</td>"));
    assert!(!of_networks.contains(&format!("<td>{title}, m/s</td>")));
    assert!(of_networks.contains("Not measured on networks") && of_networks.contains(title), "{of_networks}");
    // A page of many drives has one table more.
    let many = page_of(&[mixed_drives(), mixed_drives()].concat());
    assert_eq!(many.matches("<table").count(), 3);
    assert!(many.contains("Measures of every drive: road networks. N = 8 drives of 2 participants."), "{many}");
}

/// Returns the text of a page outside the style, without markup.
fn read(html: &str) -> String {
    let mut text = String::new();
    let body = html.find("<body>").map_or(html, |at| &html[at..]);
    for part in body.split('<').skip(1) {
        text.push_str(part.split_once('>').map_or("", |(_, text)| text));
        text.push(' ');
    }
    text
}

/// Returns a participant with a fitted bias and no other number.
fn driver() -> ParticipantDriver {
    let bias = FoundNumber { value: -0.2, interval: [-0.3, -0.1], rests_on_s: 120.0 };
    let found = FoundDriver { speed_bias_mps: Some(bias), ..FoundDriver::default() };
    ParticipantDriver { participant: "sub-P01".into(), found }
}

#[test]
fn a_driver_has_the_fitted_numbers_and_no_others() {
    let (html, _, methods) = whole_page();
    let row = "<tr><td>sub-P01</td><td>–</td><td>−0.200 [−0.300, −0.100]</td><td>–</td><td>–</td></tr>";
    assert!(html.contains(row) && html.contains("N = 1 participant."), "{html}");
    assert!(methods.contains("Each participant was described by the parameters of codrive's simulated driver"));
    let csv = tables::drivers(&[driver()]);
    assert!(csv.ends_with("\nsub-P01,,,,,-0.2,-0.3,-0.1,120,,,,,,,,\n"), "{csv}");
    let file = participants::drivers_toml("A study", &[driver()]);
    assert!(
        file.contains("participant = \"sub-P01\"\nspeed_bias_mps = -0.2\n") && !file.contains("reaction_s"),
        "{file}"
    );
    // A participant without numbers is not mentioned.
    let without_numbers = ParticipantDriver { found: FoundDriver::default(), ..driver() };
    let mut page = ReportPage::default();
    drivers_section::section(&mut page, std::slice::from_ref(&without_numbers));
    assert_eq!((page.html.as_str(), drivers_section::paragraph(&[without_numbers]).as_str()), ("", ""));
}

/// Returns the page of a study of two participants with negative numbers, and a questionnaire.
fn whole_page() -> (String, Vec<(String, String)>, String) {
    let mut drives = drives();
    drives.iter_mut().for_each(|drive| drive.measures.values[index("speed_gain_mps")] = Some(-0.25));
    drives[0].measures.values[index("speed_bias_mps")] = Some(-1.5);
    let score = people::ScoreColumn {
        questionnaire: "ssq_after".into(),
        name: "total".into(),
        condition: String::new(),
        values: vec![-1.0, 3.0],
    };
    let rating = SicknessRating { participant: "sub-P01".into(), time_s: 60.0, value: Some(3.0), ..Default::default() };
    let ratings = vec![rating.clone(), SicknessRating { value: None, ..rating }];
    let participants = StudyParticipants { scores: vec![score], ratings, ..StudyParticipants::default() };
    let made = report("A study", &drives, &participants, &FileProof::default(), &[driver()], None).unwrap();
    (made.html, made.figures, made.methods)
}

#[test]
fn changed_files_come_first_then_the_signature_both_escaped() {
    let proof = FileProof { changed: vec!["<b>a</b>".into()], signature: Some("authentic: signed by <i>".into()) };
    let html = report("<u>", &drives(), &StudyParticipants::default(), &proof, &[], None).unwrap().html;
    let at = |part: &str| html.find(part).unwrap_or_else(|| panic!("{part}"));
    let parts =
        ["<h1>&lt;u&gt;", "<li>&lt;b&gt;a&lt;/b&gt;</li>", "Files: authentic: signed by &lt;i&gt;.", "<h2>"].map(at);
    assert!(parts.is_sorted(), "{parts:?}");
    assert!(["<b>a</b>", "by <i>", "<u>"].iter().all(|markup| !html.contains(markup)));
}

#[test]
fn figures_and_tables_are_numbered_captioned_and_referred_to() {
    let (html, figures, _) = whole_page();
    let [n_figures, n_tables] = ["<figure ", "<table "].map(|tag| html.matches(tag).count());
    assert!(n_figures == figures.len() && n_figures > 8 && n_tables == 13, "{n_figures} {n_tables}");
    for (kind, name, n) in [("figure", "Figure", n_figures), ("table", "Table", n_tables)] {
        let mut from = 0;
        for i in 1..=n {
            let at = html.find(&format!("<b>{name} {i}.</b> ")).unwrap_or_else(|| panic!("{name} {i}"));
            assert!(at > from, "{name} {i} comes after the one before");
            from = at;
            assert!(html.contains(&format!("<{kind} id=\"{kind}-{i}\"")), "{name} {i}");
            let caption = html[at..].split_once("</").and_then(|(_, rest)| rest.split_once("caption>")).unwrap().0;
            let counts = caption.contains("N ") || caption.contains("Columns of");
            assert!(counts && caption.trim_end_matches("</fig").trim_end_matches("</").ends_with('.'), "{caption}");
        }
    }
    let interval = "95 % confidence interval of the mean (percentile bootstrap over participants, 2,000 resamples)";
    assert!(html.matches(interval).count() > n_figures, "each interval says what it is");
    // Every number is referred to: alone, or within "Figures 2 to 10".
    for (kind, n) in [("figure", n_figures), ("table", n_tables)] {
        let mut referred = vec![false; n + 1];
        for paragraph in html.split("<p class=\"lead\">").skip(1).map(|rest| rest.split_once("</p>").unwrap().0) {
            for part in paragraph.split(", ").flat_map(|part| part.split(". ")) {
                let link = format!("href=\"#{kind}-");
                let of: Vec<usize> =
                    part.split(&link).skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
                if let [first, .., last] = of[..] {
                    (first..=last).for_each(|i| referred[i] = true);
                } else if let [one] = of[..] {
                    referred[one] = true;
                }
            }
        }
        assert!(referred[1..].iter().all(|is| *is), "{kind}: {referred:?}\n{html}");
    }
}

#[test]
fn tables_for_programs_keep_their_hyphens() {
    let mut drives = drives();
    drives.iter_mut().for_each(|drive| drive.measures.values[index("speed_gain_mps")] = Some(-0.25));
    for table in [tables::trials(&drives), tables::by_condition(&drives)] {
        assert!(table.is_ascii() && table.contains(",-0.25,"), "{table}");
    }
}

#[test]
fn column_names_stay_in_the_dictionary_and_minus_signs_are_no_hyphens() {
    let (html, figures, methods) = whole_page();
    let (page, dictionary) = html.split_once("<section id=\"data-dictionary\">").unwrap();
    let text = read(page) + &methods;
    assert!(text.contains("−0.250") && read(dictionary).contains("mean_speed_mps"));
    for column in glossary::tables(&drives()).iter().flat_map(|table| &table.columns) {
        assert!(!column.name.contains('_') || !text.contains(&column.name), "{}", column.name);
    }
    for svg in figures.iter().map(|figure| &figure.1) {
        let document = roxmltree::Document::parse(svg).unwrap();
        for words in document.descendants().filter(|node| node.has_tag_name("text")).filter_map(|node| node.text()) {
            assert!(!words.contains('_') && !words.starts_with('-'), "{words}");
        }
    }
    let signs: Vec<char> = text.chars().collect();
    for (i, three) in signs.windows(3).enumerate() {
        let is_minus = " [(>".contains(three[0]) && three[1] == '-' && three[2].is_ascii_digit();
        assert!(!is_minus, "{}", signs[i.saturating_sub(30)..(i + 10).min(signs.len())].iter().collect::<String>());
    }
}

#[test]
fn on_paper_no_figure_is_cut_and_no_heading_stands_alone() {
    let (html, figures, _) = whole_page();
    for rule in [
        "@page{size:A4;margin:15mm 13mm}",
        "figure{margin:0 0 1.2em;break-inside:avoid}",
        "figure,tr,.whole{break-inside:avoid}",
        "h1,h2,h3,caption{break-after:avoid}",
        ".lead{break-after:avoid}",
        "thead{display:table-header-group}",
        "svg{max-width:100%;height:auto",
    ] {
        assert!(STYLE.contains(rule) && html.contains(rule), "{rule}");
    }
    // Every picture is in a block of its own with its caption.
    let body = &html[html.find("<body>").unwrap()..];
    for figure in body.split("<figure ").skip(1) {
        let inside = figure.split_once("</figure>").unwrap().0;
        assert!(inside.matches("<svg ").count() == 1 && inside.matches("<figcaption>").count() == 1);
    }
    assert_eq!(body.matches("<svg ").count(), figures.len());
    // Width of a journal's column or page, which is at most the sheet between its margins.
    for (name, svg) in &figures {
        assert!(svg.contains("width=\"89mm\"") || svg.contains("width=\"183mm\""), "{name}");
    }
    // After a heading comes the text that introduces what follows.
    for after in body.split("</h2>\n").skip(1) {
        let is_led = after.starts_with("<p class=\"lead\">") || after.starts_with("<p class=\"note lead\">");
        assert!(is_led || after.starts_with("<h3>"), "{}", &after[..60]);
    }
}

#[test]
fn the_page_says_at_its_top_which_drives_were_seen_in_slow_motion() {
    let mut trials = drives();
    let k = index("dropped_s");
    for drive in &mut trials {
        drive.measures.values[index("contact_count")] = None;
        drive.measures.values[k] = Some(0.1);
    }
    let mut page = ReportPage::default();
    faults(&mut page, &trials);
    assert_eq!(page.html, "");
    // 3 of 12 s.
    trials[1].measures.values[k] = Some(3.0);
    faults(&mut page, &trials);
    let said = "more than 1 % of the time was seen in slow motion in 1 of 4 drives: sub-P01 trial many (25 %).";
    assert!(page.html.contains(said), "{}", page.html);
}

#[test]
fn the_page_says_which_drives_had_contacts_and_the_figure_shows_when() {
    let mut trials = drives();
    let k = index("contact_count");
    for drive in &mut trials {
        drive.measures.values[index("dropped_s")] = None;
        drive.measures.values[k] = Some(0.0);
    }
    let mut page = ReportPage::default();
    faults(&mut page, &trials);
    assert_eq!(page.html, "");
    trials[1].measures.values[k] = Some(3.0);
    faults(&mut page, &trials);
    assert!(
        page.html.contains("Contacts with other vehicles in 1 of 4 drives: sub-P01 trial many (3)."),
        "{}",
        page.html
    );

    let times_s: Vec<f64> = (0..40).map(f64::from).collect();
    let ring = crate::metrics::Trajectories {
        circumference_m: 250.0,
        way_m: vec![vec![0.0, -10.0]; 40],
        speed_mps: vec![vec![4.0, 5.0]; 40],
        shown_mps: vec![None; 40],
        time_s: times_s,
        ..crate::metrics::Trajectories::default()
    };
    let traces = DriveTrajectories {
        ways: ring.clone(),
        ways_end_s: None,
        speeds: ring,
        median_speed_mps: Some(4.0),
        range_mps: 0.0,
    };
    let svg = |trial: &RecordedTrial| figures::speeds("one", &traces, trial);
    let quiet = svg(&RecordedTrial::default());
    assert!(!quiet.contains("contact") && !quiet.contains("mark</text>"));
    let contacts_at = vec![[12.0, 3.5], [30.0, 1.0]];
    let hit = svg(&RecordedTrial { contacts: 2, contacts_at, marks_at: vec![20.0], ..RecordedTrial::default() });
    let red = all(&hit, "polyline", "stroke").iter().filter(|colour| *colour == "#cc0000").count();
    assert_eq!((red, hit.matches(">contact<").count(), hit.matches(">mark<").count()), (2, 1, 1), "{hit}");
}

#[test]
fn the_page_names_participants_rehearsal_and_scores() {
    use crate::analysis::data::{StudyParticipant, people::ScoreColumn};
    let person = |id: &str, state: &str| StudyParticipant {
        id: id.into(),
        is_simulated: true,
        state: state.into(),
        ..StudyParticipant::default()
    };
    let all = vec![person("sub-R01", "complete"), person("sub-R02", "excluded")];
    let score = ScoreColumn {
        questionnaire: "ssq_after".into(),
        name: "total".into(),
        condition: String::new(),
        values: vec![10.0, 30.0],
    };
    let mut page = ReportPage::default();
    let people = StudyParticipants { all, scores: vec![score], ..StudyParticipants::default() };
    took_part(&mut page, &people);
    scores(&mut page, &people);
    for part in [
        "all participants are simulated; no person drove",
        "Participants: 1 complete, 1 excluded (sub-R02); drives and answers of excluded participants are left out.",
        "<td>ssq after</td><td class=\"t\">total</td><td>2</td><td>20.0 [10.0, 30.0]</td><td>10.0</td><td>30.0</td>",
    ] {
        assert!(page.html.contains(part), "{part}\n{}", page.html);
    }
    let mut page = ReportPage::default();
    took_part(&mut page, &StudyParticipants::default());
    scores(&mut page, &StudyParticipants::default());
    assert_eq!(page.html, "", "a drive outside of a study has no participants");
}

#[test]
fn numbers_have_three_significant_digits() {
    for (value, text) in [
        (123.456, "123"),
        (-45.678, "−45.7"),
        (9.996, "10.00"),
        (1.0, "1.00"),
        (0.1234, "0.123"),
        (-0.0001, "0"),
        (0.0, "0"),
        (99.96, "100.0"),
    ] {
        assert_eq!(short(value), text, "{value}");
    }
    assert_eq!(crate::plot::escaped(r#"a<b> & "c""#), "a&lt;b&gt; &amp; &quot;c&quot;");
    assert_eq!(words::estimate(&[]), None);
}

#[test]
fn ids_within_a_figure_are_unique_on_the_page() {
    let mut page = ReportPage::default();
    let svg = r##"<svg><clipPath id="f0"/><g clip-path="url(#f0)"/></svg>"##;
    for name in ["one", "two"] {
        page.figure(ReportFigure { name: name.into(), svg: svg.into(), caption: String::new() });
    }
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
