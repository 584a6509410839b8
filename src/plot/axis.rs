//! Axes. In: a quantity and the range shown. Out: positions and texts of ticks: multiples of 1, 2, 2.5 or 5 times a power of
//! ten, all with equally many decimals, as many as have room.

use super::text::{LINE, SIZE, minus, width, wrapped};

/// Scale of an axis.
#[derive(Clone, Debug, PartialEq)]
pub enum AxisScale {
    /// Linear: equal differences have equal lengths.
    Even,
    /// Linear, with ticks at whole numbers only.
    Whole,
    /// Logarithmic: equal ratios have equal lengths.
    Ratios,
    /// Names at 1, 2, 3, ...
    Names(Vec<String>),
}

/// Axis of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit; empty for no label.
    pub label: String,
    /// First and last value shown.
    pub range: [f64; 2],
    /// Scale of the values.
    pub scale: AxisScale,
}

/// A tick of an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AxisTick {
    /// Value at the tick.
    pub at: f64,
    /// Text, line by line.
    pub lines: Vec<String>,
}

/// Side on which an axis is drawn, with the room for a name on the left, in the units of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum AxisSide {
    Bottom,
    Left { names: f64 },
}

impl Axis {
    /// Creates a linear axis.
    pub fn even(label: &str, range: [f64; 2]) -> Self {
        Self { label: label.into(), range: widened(range), scale: AxisScale::Even }
    }

    /// Creates a linear axis of whole numbers, such as ratings and counts.
    pub fn whole(label: &str, range: [f64; 2]) -> Self {
        Self { scale: AxisScale::Whole, ..Self::even(label, range) }
    }

    /// Creates a logarithmic axis with a margin at both ends; `range` is above 0.
    pub fn ratios(label: &str, [low, high]: [f64; 2]) -> Self {
        let margin = (high / low).powf(0.03);
        Self { label: label.into(), range: [low / margin, high * margin], scale: AxisScale::Ratios }
    }

    /// Creates an axis of names.
    pub fn names(names: Vec<String>) -> Self {
        let range = [0.5, names.len() as f64 + 0.5];
        Self { label: String::new(), range, scale: AxisScale::Names(names) }
    }

    /// Returns the position of a value: 0 at the start of the axis, 1 at its end.
    pub(super) fn share(&self, x: f64) -> f64 {
        let of = |x: f64| if self.scale == AxisScale::Ratios { x.max(1e-12).ln() } else { x };
        let [low, high] = self.range.map(of);
        (of(x) - low) / (high - low)
    }

    /// Returns the ticks of an axis `length` units long: as many as have room.
    pub(super) fn ticks(&self, length: f64, side: AxisSide) -> Vec<AxisTick> {
        if let AxisScale::Names(names) = &self.scale {
            let room = match side {
                AxisSide::Bottom => length / names.len().max(1) as f64 - 6.0,
                AxisSide::Left { names } => names,
            };
            let tick = |(i, name): (usize, &String)| AxisTick { at: i as f64 + 1.0, lines: wrapped(name, room, SIZE) };
            return names.iter().enumerate().map(tick).collect();
        }
        let has_room = |ticks: &[AxisTick]| {
            ticks.windows(2).all(|pair| {
                let apart = (self.share(pair[1].at) - self.share(pair[0].at)).abs() * length;
                let least = match side {
                    AxisSide::Bottom => pair.iter().map(|tick| width(&tick.lines[0], SIZE)).sum::<f64>() / 2.0 + 8.0,
                    AxisSide::Left { .. } => 1.4 * LINE,
                };
                apart >= least
            })
        };
        let found = if self.scale == AxisScale::Ratios {
            (0..8).map(|coarser| numbered(&self.ratio_ticks(coarser))).find(|ticks| has_room(ticks))
        } else {
            let is_whole = |step: &f64| self.scale != AxisScale::Whole || *step >= 1.0 && step.fract() == 0.0;
            let steps = steps_from((self.range[1] - self.range[0]) / 8.0).filter(is_whole);
            steps.take(24).map(|step| numbered(&self.even_ticks(step))).find(|ticks| has_room(ticks))
        };
        found.unwrap_or_default()
    }

    fn even_ticks(&self, step: f64) -> Vec<f64> {
        let [low, high] = self.range;
        let first = (low / step - 1e-6).ceil() as i64;
        (first..).map(|i| i as f64 * step).take_while(|x| *x <= high + step * 1e-6).collect()
    }

    /// Returns 1, 2 and 5 times each power of ten; if coarser, each power, every second power, ...
    fn ratio_ticks(&self, coarser: usize) -> Vec<f64> {
        let [low, high] = self.range;
        let powers = (low.log10().floor() as i32..=high.log10().ceil() as i32).step_by(coarser.max(1));
        let parts: &[f64] = if coarser == 0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let all = powers.flat_map(|power| parts.iter().map(move |part| part * 10f64.powi(power)));
        all.filter(|x| *x >= low * (1.0 - 1e-9) && *x <= high * (1.0 + 1e-9)).collect()
    }
}

/// Returns a range with a width above 0.
fn widened([low, high]: [f64; 2]) -> [f64; 2] {
    if !(low.is_finite() && high.is_finite()) {
        [0.0, 1.0]
    } else if high - low < 1e-9 {
        [low - 0.5, low + 0.5]
    } else {
        [low, high]
    }
}

/// Iterates over round steps of at least this size, growing: 1, 2, 2.5 or 5 times a power of ten.
fn steps_from(least: f64) -> impl Iterator<Item = f64> {
    let power = least.log10().floor() as i32;
    let all = (power..).flat_map(|power| [1.0, 2.0, 2.5, 5.0].map(|part| part * 10f64.powi(power)));
    all.skip_while(move |step| *step < least * 0.999)
}

/// Returns the smallest round step of at least this size.
pub fn round_step(least: f64) -> f64 {
    steps_from(least).next().unwrap_or(least)
}

/// Returns ticks with these numbers, all with the decimals of the number that needs most.
fn numbered(numbers: &[f64]) -> Vec<AxisTick> {
    let decimals = decimals(numbers);
    numbers.iter().map(|at| AxisTick { at: *at, lines: vec![number(*at, decimals)] }).collect()
}

/// Returns the number of decimals that all these numbers need.
pub fn decimals(numbers: &[f64]) -> usize {
    let size = numbers.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    let is_whole = |x: f64| (x - x.round()).abs() <= 1e-7 * size.max(1e-300);
    let needed = |d: &usize| {
        let scale = 10f64.powi(*d as i32);
        numbers.iter().all(|x| is_whole((x * scale - (x * scale).round()) / scale))
    };
    (0..12).find(needed).unwrap_or(12)
}

/// Formats a number with so many decimals and a true minus sign.
pub fn number(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    let is_zero = text.chars().all(|sign| "-0.".contains(sign));
    if is_zero { text.trim_start_matches('-').to_owned() } else { minus(&text) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn label_texts(ticks: &[AxisTick]) -> Vec<&str> {
        ticks.iter().map(|tick| tick.lines[0].as_str()).collect()
    }

    #[test]
    fn ticks_are_even_round_within_the_axis_and_have_as_many_decimals() {
        for range in
            [[0.0, 10.0], [-0.34, 0.07], [3.98, 4.41], [0.0, 4.87], [0.0, 59.4], [0.96, 1.003], [0.0, 86_400.0]]
        {
            for (length, side) in
                [(210.0, AxisSide::Left { names: 0.0 }), (300.0, AxisSide::Bottom), (700.0, AxisSide::Bottom)]
            {
                let ticks = Axis::even("", range).ticks(length, side);
                assert!((2..=9).contains(&ticks.len()), "{range:?} {length}: {ticks:?}");
                let step = ticks[1].at - ticks[0].at;
                let part = step / 10f64.powf((step * 1.000_001).log10().floor());
                assert!([1.0, 2.0, 2.5, 5.0].iter().any(|p| (part - p).abs() < 1e-3), "{range:?}: step {step}");
                for pair in ticks.windows(2) {
                    assert!((pair[1].at - pair[0].at - step).abs() < 1e-6 * step, "{range:?}");
                }
                let slack = 1e-5 * step;
                assert!(ticks[0].at >= range[0] - slack && ticks[ticks.len() - 1].at <= range[1] + slack, "{ticks:?}");
                let decimals = |word: &str| word.split_once('.').map_or(0, |(_, after)| after.len());
                assert!(label_texts(&ticks).iter().all(|w| decimals(w) == decimals(&ticks[0].lines[0])), "{ticks:?}");
                for tick in &ticks {
                    let read: f64 = tick.lines[0].replace('−', "-").parse().unwrap();
                    assert!((read - tick.at).abs() < slack && !tick.lines[0].contains('-'), "{tick:?}");
                }
            }
        }
        let ticks = Axis::even("", [-0.3, 0.1]).ticks(110.0, AxisSide::Left { names: 0.0 });
        assert_eq!(label_texts(&ticks), ["−0.3", "−0.2", "−0.1", "0.0", "0.1"]);
        assert_eq!(Axis::even("", [3.0, 3.0]).range, [2.5, 3.5]);
    }

    #[test]
    fn ticks_of_whole_numbers_are_whole() {
        // Nineteen questions, and ratings of 0 to 20; an even axis would have ticks at 2.5, 5.0 and so on.
        let of = |range: [f64; 2], length: f64, side: AxisSide| {
            label_texts(&Axis::whole("", range).ticks(length, side)).into_iter().map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(of([0.5, 19.5], 640.0, AxisSide::Bottom), ["5", "10", "15"]);
        assert_eq!(of([0.0, 20.0], 180.0, AxisSide::Left { names: 0.0 }), ["0", "5", "10", "15", "20"]);
        assert_eq!(of([0.5, 3.5], 640.0, AxisSide::Bottom), ["1", "2", "3"]);
    }

    #[test]
    fn ticks_of_even_ratios_are_1_2_and_5_and_fewer_where_there_is_no_room() {
        let axis = Axis::ratios("", [0.1, 30.0]);
        assert_eq!(
            label_texts(&axis.ticks(700.0, AxisSide::Bottom)),
            ["0.1", "0.2", "0.5", "1.0", "2.0", "5.0", "10.0", "20.0"]
        );
        assert_eq!(label_texts(&axis.ticks(120.0, AxisSide::Bottom)), ["0.1", "1.0", "10.0"]);
        assert!((axis.share(3f64.sqrt()) - 0.5).abs() < 1e-9);
    }

    #[test]
    fn names_stand_evenly_at_whole_numbers_within_their_room() {
        let axis = Axis::names(vec!["few-vehicles-on-the-road".into(), "many".into()]);
        let ticks = axis.ticks(200.0, AxisSide::Bottom);
        assert_eq!((ticks[0].at, ticks[1].at, axis.range), (1.0, 2.0, [0.5, 2.5]));
        assert!(ticks[0].lines.len() > 1 && ticks[0].lines.iter().all(|line| width(line, SIZE) <= 94.0));
    }
}
