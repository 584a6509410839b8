//! The learning curve as files. In: the rows of a training. Out: CSV with one line per update, and a picture (SVG) of mean speed, KL
//! divergence and entropy over the updates.

use super::learner::LearningCurveRow;
use crate::plot::{Axis, COLOURS, Chart, LineStyle, PlotLine, picture};
use std::fmt::Write;

/// Returns the CSV with a header and one line per update; missing numbers are empty.
pub fn csv(rows: &[LearningCurveRow]) -> String {
    let mut text = String::from(
        "iteration,env_steps,batch_mean_speed_mps,reward_mps,crashes,kl_nat,entropy_nat,value_error,judged_speed_mps,estimator_loss_nat\n",
    );
    for r in rows {
        let optional = |x: Option<f64>| x.map_or(String::new(), |x| x.to_string());
        let (judged, loss) = (optional(r.judged_mps), optional(r.estimator_loss));
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{judged},{loss}",
            r.iteration, r.env_steps, r.mean_mps, r.reward, r.crashes, r.kl, r.entropy, r.value_error
        );
    }
    text
}

/// Returns the SVG with three panels from top to bottom: speed, KL divergence, entropy.
pub fn svg(rows: &[LearningCurveRow], title: &str) -> String {
    let noisy = line("batches, with the policy's noise", "#9aa5ad", rows, |r| Some(r.mean_mps));
    let judged = line("evaluated without noise over whole horizons", COLOURS[1], rows, |r| r.judged_mps);
    let panels = [
        panel(title, "mean speed, m/s", vec![noisy, judged]),
        panel("", "KL divergence, nat", vec![line("", COLOURS[0], rows, |r| Some(r.kl))]),
        panel("", "entropy, nat", vec![line("", COLOURS[2], rows, |r| Some(r.entropy))]),
    ];
    picture(&panels, "")
}

fn line(
    name: &str,
    colour: &'static str,
    rows: &[LearningCurveRow],
    of: impl Fn(&LearningCurveRow) -> Option<f64>,
) -> PlotLine {
    let points = rows.iter().filter_map(|r| of(r).map(|y| [f64::from(r.iteration), y])).collect();
    PlotLine {
        name: name.into(),
        style: LineStyle { width: 1.4, ..LineStyle::solid(colour) },
        points,
        band: Vec::new(),
    }
}

fn panel(title: &str, label: &str, lines: Vec<PlotLine>) -> Chart {
    let range = |k: usize| {
        let values = || lines.iter().flat_map(move |line| line.points.iter().map(move |p| p[k]));
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    };
    let x = Axis::even("update", [0.0, range(0)[1].max(1.0)]);
    let y = Axis::even(label, range(1));
    Chart { lines, ..Chart::new(title, x, y, 150.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<LearningCurveRow> {
        let row = |i: u32| LearningCurveRow {
            iteration: i,
            env_steps: u64::from(i) * 100,
            mean_mps: 3.0 + f64::from(i) * 0.1,
            reward: 3.0,
            crashes: 1,
            kl: 0.01,
            entropy: 1.0 - f64::from(i) * 0.01,
            value_error: 0.2,
            judged_mps: i.is_multiple_of(2).then_some(3.5),
            estimator_loss: (i > 2).then_some(0.5),
        };
        (1..=4).map(row).collect()
    }

    #[test]
    fn the_table_has_a_line_for_each_update() {
        let text = csv(&rows());
        assert_eq!(text.lines().count(), 5);
        assert_eq!(text.lines().nth(1), Some("1,100,3.1,3,1,0.01,0.99,0.2,,"));
        assert!(text.ends_with(",3.5,0.5\n"));
    }

    #[test]
    fn the_picture_is_well_formed_even_without_rows() {
        for (rows, drawn) in [(rows(), 4), (Vec::new(), 0)] {
            let text = svg(&rows, "a < b & c");
            let picture = roxmltree::Document::parse(&text).unwrap();
            let lines = picture.descendants().filter(|n| n.has_tag_name("polyline")).count();
            assert_eq!(lines, drawn);
            assert!(!text.contains("NaN") && !text.contains("inf"));
        }
    }
}
