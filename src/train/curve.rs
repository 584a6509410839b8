//! The learning curve as files. In: the rows of a training. Out: CSV with one line an update, and a picture (SVG) of mean
//! speed, KL divergence and entropy over the updates.

use super::learner::Row;
use std::fmt::Write;

/// Size of the picture and of its margins, in its own units.
const WIDTH: f64 = 760.0;
const PANEL: f64 = 150.0;
const MARGIN: [f64; 2] = [64.0, 28.0];

/// One line an update, with a head; numbers as they are, empty where there is none.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "iteration,env_steps,mean_speed_mps,reward_mps,crashes,kl,entropy_nat,value_error,judged_speed_mps\n",
    );
    for r in rows {
        let judged = r.judged_mps.map_or(String::new(), |x| x.to_string());
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{judged}",
            r.iteration, r.env_steps, r.mean_mps, r.reward, r.crashes, r.kl, r.entropy, r.value_error
        );
    }
    text
}

/// Three panels one above the other: speed, KL divergence, entropy.
pub fn svg(rows: &[Row], title: &str) -> String {
    let panels = [
        ("speed, m/s", vec![("#8aa", line(rows, |r| Some(r.mean_mps))), ("#c33", line(rows, |r| r.judged_mps))]),
        ("KL, nat", vec![("#36c", line(rows, |r| Some(r.kl)))]),
        ("entropy, nat", vec![("#383", line(rows, |r| Some(r.entropy)))]),
    ];
    let height = MARGIN[1] * 2.0 + panels.len() as f64 * (PANEL + MARGIN[1]);
    let last = rows.last().map_or(1.0, |r| f64::from(r.iteration));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n<rect width=\"{WIDTH}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    let _ = writeln!(out, "<text x=\"{}\" y=\"18\" font-size=\"14\">{}</text>", MARGIN[0], escaped(title));
    for (i, (name, lines)) in panels.iter().enumerate() {
        panel(&mut out, MARGIN[1] + i as f64 * (PANEL + MARGIN[1]), name, lines, last);
    }
    let key = "update; grey: batches with the policy's noise; red: judged without noise over whole horizons";
    let _ = writeln!(out, "<text x=\"{}\" y=\"{}\">{key}</text>\n</svg>", MARGIN[0], height - 10.0);
    out
}

type Line = Vec<(f64, f64)>;

fn line(rows: &[Row], of: impl Fn(&Row) -> Option<f64>) -> Line {
    rows.iter().filter_map(|r| of(r).map(|y| (f64::from(r.iteration), y))).collect()
}

fn panel(out: &mut String, top: f64, name: &str, lines: &[(&str, Line)], last: f64) {
    let ys = || lines.iter().flat_map(|(_, line)| line.iter().map(|(_, y)| *y));
    let (mut low, mut high) = (ys().fold(f64::INFINITY, f64::min), ys().fold(f64::NEG_INFINITY, f64::max));
    if low >= high || !low.is_finite() {
        (low, high) = if low.is_finite() { (low - 0.5, low + 0.5) } else { (0.0, 1.0) };
    }
    let x = |value: f64| MARGIN[0] + value / last * (WIDTH - MARGIN[0] - 20.0);
    let y = |value: f64| top + PANEL - (value - low) / (high - low) * (PANEL - 10.0);
    for share in [0.0, 0.5, 1.0] {
        let (value, at) = (low + (high - low) * share, last * share);
        let _ = writeln!(
            out,
            "<path d=\"M{} {y:.1}H{}\" stroke=\"#ddd\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{:.0}</text>",
            MARGIN[0],
            WIDTH - 20.0,
            MARGIN[0] - 6.0,
            y(value) + 4.0,
            short(value),
            x(at),
            top + PANEL + 14.0,
            at,
            y = y(value),
        );
    }
    let _ = writeln!(out, "<text x=\"{}\" y=\"{}\" fill=\"#555\">{name}</text>", MARGIN[0] + 6.0, top + 12.0);
    for (colour, line) in lines {
        let points: Vec<String> = line.iter().map(|(at, value)| format!("{:.1},{:.1}", x(*at), y(*value))).collect();
        let _ = writeln!(
            out,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"/>",
            points.join(" ")
        );
    }
}

/// A number of the axis: three digits that matter.
fn short(x: f64) -> String {
    if x.abs() >= 1.0 { format!("{x:.2}") } else { format!("{x:.4}") }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<Row> {
        let row = |i: u32| Row {
            iteration: i,
            env_steps: u64::from(i) * 100,
            mean_mps: 3.0 + f64::from(i) * 0.1,
            reward: 3.0,
            crashes: 1,
            kl: 0.01,
            entropy: 1.0 - f64::from(i) * 0.01,
            value_error: 0.2,
            judged_mps: i.is_multiple_of(2).then_some(3.5),
        };
        (1..=4).map(row).collect()
    }

    #[test]
    fn the_table_has_a_line_for_each_update() {
        let text = csv(&rows());
        assert_eq!(text.lines().count(), 5);
        assert_eq!(text.lines().nth(1), Some("1,100,3.1,3,1,0.01,0.99,0.2,"));
        assert!(text.ends_with(",3.5\n"));
    }

    #[test]
    fn the_picture_is_well_formed_even_without_rows() {
        for rows in [rows(), Vec::new()] {
            let text = svg(&rows, "a < b & c");
            let picture = roxmltree::Document::parse(&text).unwrap();
            let lines = picture.descendants().filter(|n| n.has_tag_name("polyline")).count();
            assert_eq!(lines, 4);
            assert!(!text.contains("NaN") && !text.contains("inf"));
        }
    }
}
