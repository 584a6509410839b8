//! The picture of traces along a path, for vehicles made up by hand.

use super::*;

#[test]
fn the_picture_has_the_outlined_ego_on_top_and_bars_at_signals() {
    let piece = |from_s: f64, s_m: f64| TracePiece { ends: [[from_s, s_m], [from_s + 1.0, s_m + 5.0]], speed_mps: 5.0 };
    let lights = [([0.0, 4.0], SignalLight::Red), ([4.0, 10.0], SignalLight::GreenMinor)];
    let traces = PathTraces {
        span_s: [0.0, 10.0],
        shown_m: [0.0, 100.0],
        others: vec![piece(1.0, 20.0)],
        ego: vec![piece(1.0, 10.0), piece(2.0, 15.0)],
        signals: vec![SignalBar { s_m: 50.0, spans: lights.to_vec() }],
        top_speed_mps: 5.0,
        ..PathTraces::default()
    };
    let svg = space_time("", &traces, None);
    let document = roxmltree::Document::parse(&svg).expect("a picture");
    let paths: Vec<_> = document.descendants().filter(|node| node.has_tag_name("path")).collect();
    let of_width = |width: &str| -> Vec<String> {
        let of = paths.iter().filter(|path| path.attribute("stroke-width") == Some(width));
        // Lines of the legend are horizontal with a fixed length.
        of.map(|path| path.attribute("d").unwrap_or_default().to_owned()).filter(|d| !d.contains('h')).collect()
    };
    assert_eq!((of_width("1.2").len(), of_width("5.4").len(), of_width("3").len()), (1, 1, 1));
    assert_eq!(of_width("5.4")[0].matches('M').count(), 2, "two pieces of the ego");
    // Both bars are level in the middle of the field, red for 4 of 10 s.
    let ends = |d: &str| -> Vec<f64> {
        d.split(['M', 'L', ' ']).filter(|part| !part.is_empty()).map(|part| part.parse().expect("a number")).collect()
    };
    let (red, green) = (ends(&of_width("3.4")[0]), ends(&of_width("1.4")[0]));
    assert!(red[1] == red[3] && green[1] == green[3] && red[1] == green[1] && (red[1] - 150.0).abs() < 0.2, "{red:?}");
    assert!(((red[2] - red[0]) / (green[2] - red[0]) - 0.4).abs() < 0.01, "{red:?} {green:?}");
    for words in
        [">signal red<", ">signal green<", "position along the ego vehicle", "time since the start of the drive, s"]
    {
        assert!(svg.contains(words), "{words}: {svg}");
    }
    assert!(!svg.contains(">signal yellow<"), "it was never shown");
    // Without signals there is no entry about them.
    let none = space_time("", &PathTraces { signals: Vec::new(), ..traces }, None);
    assert!(!none.contains("signal"));
}
