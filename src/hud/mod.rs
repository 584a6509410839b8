//! The speedometer as data. In: speed, advice, unit, scenario. Out: a [`DialView`]: angles, ticks, colours; no GPU, no
//! egui. As in HC22: round gauge with ticks and needle, the number in the centre, the target a red line, the acceptable
//! range a green band, the number green inside the range and white outside.

mod automation_lamp;
mod guidance;
mod letter_forms;
pub mod lettering;
mod number;
mod palette;
mod scale;
mod search_display;
mod speedometer;
mod spoken_guidance;

pub use automation_lamp::{AutomationLamp, LampState};
pub use guidance::DialGuidance;
pub use number::{NumberFilter, RangeTooNarrow, check_range};
pub use palette::{Palette, Rgb};
pub use scale::{SpeedometerScale, expected_top_mps};
pub use search_display::{SEARCH_ROWS, SearchCircle, cells_across, search_circles};
pub use speedometer::Speedometer;
pub use spoken_guidance::SpokenGuidance;

use crate::{
    controls::Indicator,
    map::NextManoeuvre,
    snapshot::{AutomationState, Pictogram, ShownQuestion},
    units::SpeedUnit,
};
use std::sync::Arc;

/// Content of the speedometer in one frame. Speeds are in the dial's unit.
#[derive(Clone, Debug, PartialEq)]
pub struct DialView {
    /// Unit of all numbers.
    pub unit: SpeedUnit,
    /// Full scale, a multiple of `major_step`.
    pub full_scale: f64,
    /// Distance between numbered ticks.
    pub major_step: f64,
    /// Intervals between two numbered ticks: the unnumbered ticks between them plus one.
    pub minor_per_major: u32,
    /// Current speed, not negative.
    pub speed: f64,
    /// Number in the centre. [`DialView::new`] rounds; a [`NumberFilter`] keeps it from flickering.
    pub number: u32,
    /// Advice: target, lower and upper edge of the range.
    pub advice: Option<DialAdvice>,
    /// True if the true speed lies in the range, its edges included: the number is green.
    pub inside: bool,
    /// True in reverse gear.
    pub reverse: bool,
    /// Telltale of the indicators that is lit now.
    pub indicator: Indicator,
    /// True while the telltale of the main beam is lit.
    pub main_beam: bool,
    /// Guidance to the next manoeuvre of the path.
    pub guidance: Option<DialGuidance>,
    /// Sign above the dial.
    pub pictogram: Option<Pictogram>,
    /// Text above the dial, and above its sign.
    pub message: Option<Arc<str>>,
    /// Question above sign and text, with its answers.
    pub question: Option<Arc<ShownQuestion>>,
    /// Lamp of the automation; `None` without one, and in the dark half of its blinking.
    pub automation: Option<AutomationLamp>,
}

/// Advice as the dial shows it, in the dial's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DialAdvice {
    /// Target speed, at the red line.
    pub target: f64,
    /// Lower edge of the green band.
    pub low: f64,
    /// Upper edge of the green band.
    pub high: f64,
}

/// Tick on the scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleMark {
    /// Speed, in the dial's unit.
    pub value: f64,
    /// Angle on the dial, see [`DialView::angle_rad`].
    pub angle_rad: f32,
    /// True for the long ticks that carry their value.
    pub numbered: bool,
    /// True for a tick half-way between two numbered ones.
    pub half: bool,
}

impl DialView {
    /// Angle of zero, degrees clockwise from 12 o'clock: lower left.
    pub const START_DEG: f64 = -135.0;
    /// Angle from zero to full scale, degrees, clockwise.
    pub const SWEEP_DEG: f64 = 270.0;

    /// Creates the dial for an ego speed of `speed_mps` (negative when rolling backwards) under the advice (target,
    /// lowest and highest acceptable speed), all in m/s. Acceptance is decided here, in m/s and before any rounding, by
    /// the rule of [`Advice::accepts`](crate::policy::Advice::accepts).
    pub fn new(
        speed_mps: f64,
        advice: Option<(f64, f64, f64)>,
        unit: SpeedUnit,
        scale: SpeedometerScale,
        reverse: bool,
    ) -> Self {
        let speed = unit.from_mps(speed_mps.abs());
        Self {
            unit,
            full_scale: scale.full,
            major_step: scale.major_step,
            minor_per_major: scale.minor_per_major,
            speed,
            number: speed.round() as u32,
            advice: advice.map(|(target, low, high)| DialAdvice {
                target: unit.from_mps(target),
                low: unit.from_mps(low),
                high: unit.from_mps(high),
            }),
            inside: advice.is_some_and(|(_, low, high)| (low..=high).contains(&speed_mps)),
            reverse,
            indicator: Indicator::Off,
            main_beam: false,
            guidance: None,
            pictogram: None,
            message: None,
            question: None,
            automation: None,
        }
        .agreeing()
    }

    /// Returns this dial with a telltale lit.
    pub fn indicating(self, indicator: Indicator) -> Self {
        Self { indicator, ..self }
    }

    /// Returns this dial with the telltale of the main beam lit or dark.
    pub fn with_main_beam(self, main_beam: bool) -> Self {
        Self { main_beam, ..self }
    }

    /// Returns this dial with a sign above it.
    pub fn with_pictogram(self, pictogram: Option<Pictogram>) -> Self {
        Self { pictogram, ..self }
    }

    /// Returns this dial with a text above it.
    pub fn saying(self, message: Option<Arc<str>>) -> Self {
        Self { message, ..self }
    }

    /// Returns this dial with a question above it.
    pub fn asking(self, question: Option<Arc<ShownQuestion>>) -> Self {
        Self { question, ..self }
    }

    /// Returns this dial with the automation's lamp, and the text of a takeover request in place of another text.
    pub fn automated(self, automation: &AutomationState, time_s: f64) -> Self {
        let message = automation_lamp::request_text(automation).map(Arc::from).or(self.message);
        Self { automation: AutomationLamp::at(automation, time_s), message, ..self }
    }

    /// Returns this dial with guidance to the next manoeuvre.
    pub fn guiding(self, next: Option<NextManoeuvre>) -> Self {
        let guidance = next.and_then(|next| DialGuidance::to(next, self.unit));
        Self { guidance, ..self }
    }

    /// Returns this dial with its number steadied by `filter`, which must see every frame.
    pub fn steadied(self, filter: &mut NumberFilter) -> Self {
        let number = filter.show(self.speed);
        Self { number, ..self }.agreeing()
    }

    /// Makes the number agree with its colour, which follows the true speed: within one advice a number is green or
    /// white, never both. Near an edge of the range the number is the next whole one on the speed's side of the edge.
    /// In a range without a whole number, and in reverse, the number stays as it was rounded.
    fn agreeing(mut self) -> Self {
        let Some(advice) = self.advice else { return self };
        let [first, last] = [advice.low.ceil(), advice.high.floor()];
        if first > last || last < 0.0 || self.reverse {
            return self;
        }
        let (first, last) = (first.max(0.0) as u32, last as u32);
        self.number = match self.number {
            number if self.inside => number.clamp(first, last),
            number if self.speed > advice.high => number.max(last + 1),
            number if self.speed < advice.low => number.min(first.saturating_sub(1)),
            number => number,
        };
        self
    }

    /// Returns the scale for a scenario with expected speeds up to `max_expected_mps`, chosen once for all of it (see
    /// [`SpeedometerScale::fitting`], [`expected_top_mps`]).
    pub fn scale_for(max_expected_mps: f64, unit: SpeedUnit) -> SpeedometerScale {
        SpeedometerScale::fitting(max_expected_mps, unit)
    }

    /// Returns the angle of a speed on the dial: radians clockwise from 12 o'clock, linear in speed, clamped at both
    /// ends of the scale.
    pub fn angle_rad(&self, speed: f64) -> f32 {
        let share = (speed / self.full_scale).clamp(0.0, 1.0);
        (Self::START_DEG + share * Self::SWEEP_DEG).to_radians() as f32
    }

    /// Returns the angle of the needle.
    pub fn needle_rad(&self) -> f32 {
        self.angle_rad(self.speed)
    }

    /// Returns the angle of the red line.
    pub fn target_rad(&self) -> Option<f32> {
        self.advice.map(|advice| self.angle_rad(advice.target))
    }

    /// Returns the angles of the green band's two ends, the lower first.
    pub fn band_rad(&self) -> Option<(f32, f32)> {
        self.advice.map(|advice| (self.angle_rad(advice.low), self.angle_rad(advice.high)))
    }

    /// Returns all ticks, from zero to full scale.
    pub fn marks(&self) -> impl Iterator<Item = ScaleMark> + '_ {
        let majors = (self.full_scale / self.major_step).round() as u32;
        let parts = self.minor_per_major;
        (0..=majors * parts).map(move |i| {
            let value = self.major_step * f64::from(i) / f64::from(parts);
            let numbered = i.is_multiple_of(parts);
            ScaleMark { value, angle_rad: self.angle_rad(value), numbered, half: 2 * (i % parts) == parts }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        policy::{Action, Advice},
        time::Tick,
    };

    fn dial(speed_mps: f64, advice: Option<(f64, f64, f64)>) -> DialView {
        DialView::new(speed_mps, advice, SpeedUnit::Mph, DialView::scale_for(9.6, SpeedUnit::Mph), false)
    }

    #[test]
    fn angles_are_linear_and_clamped_at_the_ends() {
        let dial = dial(0.0, None);
        assert_eq!(dial.full_scale, 25.0);
        assert!((dial.angle_rad(0.0).to_degrees() + 135.0).abs() < 1e-4);
        assert!(dial.angle_rad(12.5).abs() < 1e-6);
        assert!((dial.angle_rad(5.0).to_degrees() + 81.0).abs() < 1e-4);
        assert_eq!(dial.angle_rad(25.0), dial.angle_rad(90.0));
        assert_eq!(dial.angle_rad(0.0), dial.angle_rad(-3.0));
    }

    #[test]
    fn every_fifth_tick_of_the_ring_dial_is_numbered() {
        let dial = dial(0.0, None);
        let marks: Vec<ScaleMark> = dial.marks().collect();
        assert_eq!(marks.len(), 26);
        let numbered: Vec<f64> = marks.iter().filter(|mark| mark.numbered).map(|mark| mark.value).collect();
        assert_eq!(numbered, [0.0, 5.0, 10.0, 15.0, 20.0, 25.0]);
    }

    #[test]
    fn the_number_is_green_exactly_where_the_advice_accepts() {
        let advice = Advice {
            issued: Tick(0),
            hold: crate::policy::Hold::of_steps(10, 0.1),
            action: Action::Speed(4.362),
            target_mps: 4.362,
            range_mps: 0.447_04,
            is_fallback: false,
            driver: None,
            observed: None,
        };
        let (low, high) = advice.band_mps();
        for speed in [low.next_down(), low, low.next_up(), 4.4, high.next_down(), high, high.next_up(), -low, 0.0, 9.0]
        {
            let dial = dial(speed, Some((advice.target_mps, low, high)));
            assert_eq!(dial.inside, advice.accepts(speed), "{speed}");
        }
    }

    #[test]
    fn a_number_has_one_colour_and_is_less_than_one_off() {
        for (target, half) in [(4.362, 0.447_04), (4.362, 0.223_52), (4.0, 0.894_08), (9.3, 0.223_52), (0.3, 0.447_04)]
        {
            let advice = Some((target, f64::max(target - half, 0.0), target + half));
            let (mut filter, mut green, mut white) = (NumberFilter::default(), Vec::new(), Vec::new());
            // Up, down and up again, so that the steadied number comes from both sides.
            let up = (0..2400).map(|i| f64::from(i) * 0.005);
            for speed in up.clone().chain(up.clone().rev()).chain(up) {
                let shown = dial(speed, advice).steadied(&mut filter);
                assert!((f64::from(shown.number) - shown.speed).abs() < 1.0, "{} for {}", shown.number, shown.speed);
                if shown.inside { green.push(shown.number) } else { white.push(shown.number) }
            }
            let both: Vec<&u32> = green.iter().filter(|number| white.contains(number)).collect();
            assert!(both.is_empty() && !green.is_empty(), "{target} +- {half}: {both:?} are green and white");
        }
    }

    #[test]
    fn speed_is_shown_without_its_sign() {
        let dial = dial(-2.235_2, None);
        assert!((dial.speed - 5.0).abs() < 1e-12);
        assert_eq!(dial.number, 5);
    }
}
