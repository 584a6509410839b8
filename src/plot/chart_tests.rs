//! Charts: drawing, and enough room for every text.

use super::{super::png::texts, *};

fn unit_chart() -> Chart {
    Chart::new("", Axis::even("", [0.0, 1.0]), Axis::even("", [0.0, 1.0]), 100.0)
}

/// Asserts that no text of the picture is cut by its edge or overlaps another.
fn assert_texts_have_room(svg: &str) {
    let (texts, [width, height]) = texts(svg);
    for (i, (words, [left, top, right, bottom])) in texts.iter().enumerate() {
        let inside = *left >= 0.0 && *top >= 0.0 && *right <= width && *bottom <= height;
        assert!(inside, "\"{words}\" leaves {width} x {height}: {left} {top} {right} {bottom}");
        for (other, [l, t, r, b]) in &texts[i + 1..] {
            // Boxes are as high as the font: a small overlap is not an overlap of ink.
            let apart = *left >= r - 0.5 || *right <= l + 0.5 || *top >= b - 4.0 || *bottom <= t + 4.0;
            assert!(apart, "\"{words}\" and \"{other}\" overlap: {left} {top} {right} {bottom}, {l} {t} {r} {b}");
        }
    }
}

#[test]
fn a_line_or_a_band_without_length_is_not_drawn() {
    let chart = |points: Vec<[f64; 2]>, band: Vec<[f64; 2]>| {
        let mut chart = unit_chart();
        chart.lines.push(PlotLine { name: String::new(), style: LineStyle::solid(COLOURS[0]), points, band });
        let text = picture(&[chart], "");
        (text.contains("<polyline"), text.contains("<polygon"))
    };
    assert_eq!(chart(vec![[0.1, 0.5], [0.9, 0.5]], vec![[0.4, 0.6]; 2]), (true, true));
    assert_eq!(chart(vec![[0.1, 0.5]], vec![[0.5, 0.5]]), (false, false));
    assert_eq!(chart(vec![[0.5, 0.5], [0.500_01, 0.5]], vec![]), (false, false), "a hair's breadth");
    assert_eq!(chart(vec![[0.5, 0.5]], vec![[0.2, 0.7]]), (false, true), "an interval alone is one");
    assert_eq!(chart(vec![], vec![]), (false, false));
    let mut chart = unit_chart();
    let colour = "#123456".to_owned();
    chart.shapes.push(PlotShape::Pieces { pieces: vec![[[0.5, 0.5], [0.5, 0.5]]], colour, width: 1.0 });
    assert!(!picture(&[chart], "").contains("#123456"));
}

#[test]
fn a_picture_is_well_formed_and_points_lie_where_they_should() {
    let mut chart = Chart::new("a < b", Axis::ratios("s", [0.1, 10.0]), Axis::even("y", [0.0, 1.0]), 100.0);
    let points = vec![[0.1, 0.0], [10.0, 1.0]];
    let band = vec![[0.0, 0.1], [0.9, 1.0]];
    chart.lines.push(PlotLine { name: "one & two".into(), style: LineStyle::solid(COLOURS[0]), points, band });
    let layout = ChartLayout::of(&chart, 40.0, 240.0);
    let [x, y] = layout.place([1.0, 0.5]);
    assert!((x - layout.field[0] / 2.0).abs() < 1e-9 && y == 50.0);
    let text = picture(&[chart.clone(), chart], "a note\nof two lines");
    let document = roxmltree::Document::parse(&text).unwrap();
    assert_eq!(document.descendants().filter(|n| n.has_tag_name("polyline")).count(), 2);
    assert!(!text.contains("NaN") && !text.contains("inf"));
    assert!(text.contains("width=\"183mm\""), "{text}");
    assert_texts_have_room(&text);
}

#[test]
fn texts_of_any_length_and_number_stay_inside_and_do_not_overlap() {
    let long = "a-narrow-range-of-half-a-mile-per-hour+many-vehicles-on-the-road";
    let names = |n: usize| -> Vec<String> {
        let name = |i: usize| {
            if i.is_multiple_of(2) { format!("{long}-{i}") } else { format!("verylongwordwithoutanybreakatall{i}") }
        };
        (0..n).map(name).collect()
    };
    for width in [PrintWidth::Column, PrintWidth::Page] {
        for n in [1, 3, 8, 30] {
            let mut chart = Chart::new(
                "A title that is far too long for a single line of a figure as wide as a column of a journal is",
                Axis::even(
                    "time since the start of the drive, which has a very long label for such a narrow figure, s",
                    [0.0, 123_456.0],
                ),
                Axis::even("Gain of mean speed over no advice, over the whole drive, m/s", [-0.0123, 0.0456]),
                110.0,
            );
            for name in names(n) {
                let (style, points) = (LineStyle::solid(COLOURS[0]), vec![[0.0, 0.0], [123_456.0, 0.04]]);
                chart.lines.push(PlotLine { name, style, points, band: vec![[0.0, 0.01]; 2] });
            }
            for i in 0..3 {
                chart.marks.push(PlotMark { at: [120_000.0, 0.045], text: format!("{i} of 20 crashed") });
            }
            let key = ColourKey::up_to("speed, m/s", 8.7);
            let note = "a note that is longer than the picture is wide, by a good deal, and so is broken, ".repeat(3);
            let charts = [chart.clone(), chart];
            assert_texts_have_room(&ChartSheet { charts: &charts, width, key: Some(&key), note: &note }.svg());

            let y = Axis::even("Mean absolute speed error of the participant, m/s", [-4.0, 12_345.0]);
            let by_name = Chart::new("", Axis::names(names(n)), y, 150.0).transposed();
            assert_texts_have_room(
                &ChartSheet { charts: &[by_name], width: PrintWidth::Page, key: None, note: "" }.svg(),
            );
        }
        let three = ["narrow", "few-cars", "wide"].map(str::to_owned).to_vec();
        let chart = Chart::new("", Axis::names(three), Axis::even("s", [0.0, 3.0]), 100.0);
        let svg = ChartSheet { charts: &[chart], width, key: None, note: "" }.svg();
        assert_texts_have_room(&svg);
        // Width in print, in pixels of CSS.
        assert!((f64::from(texts(&svg).1[0]) - width.mm() / 25.4 * 96.0).abs() < 0.5);
    }
}

#[test]
fn a_transposed_chart_has_names_downwards_and_numbers_to_the_right() {
    let mut chart = Chart::new("", Axis::names(vec!["a".into(), "b".into()]), Axis::even("m", [0.0, 10.0]), 100.0);
    let dot = |at| PlotShape::Dot { at, radius: 3.0, colour: "#000000".into(), has_edge: false };
    chart.shapes = vec![dot([1.0, 2.0]), dot([2.0, 8.0])];
    let svg = picture(&[chart.transposed()], "");
    let document = roxmltree::Document::parse(&svg).unwrap();
    let dots = document.descendants().filter(|node| node.has_tag_name("circle"));
    let at = |node: roxmltree::Node, name: &str| node.attribute(name).unwrap().parse::<f64>().unwrap();
    let places: Vec<[f64; 2]> = dots.map(|node| [at(node, "cx"), at(node, "cy")]).collect();
    assert!(places[0][0] < places[1][0] && places[0][1] < places[1][1], "{places:?}");
}
