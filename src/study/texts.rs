//! Texts for a participant, and the names of controls in them. In: `[texts]` of the study file, the device in use. Out: sentences in the
//! participant's language that name the keys of a keyboard, the pedals of a wheel or the triggers of a gamepad.

use crate::controls::ControlSource;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Texts that the program shows to a participant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ParticipantTexts {
    /// Below a page, with a wheel: how to continue. `{button}` stands for the button that confirms.
    pub go_on: String,
    /// Before a drive that begins at a standstill. This and every other text names controls of the device in use by `{steering}`,
    /// `{accelerator}` and `{brake}`.
    pub ready: String,
    /// Before a drive that begins in flowing traffic; `{speed}` stands for the speed with its unit.
    pub rolling: String,
    /// Before a drive that begins at a standstill, while the brake is not pressed.
    pub brake: String,
    /// Shown after a drive.
    pub drive_over: String,
    /// Shown during a break.
    pub rest: String,
    /// At the end of a break.
    pub rest_over: String,
    /// At the end of a complete session.
    pub thanks: String,
    /// After a session that was stopped early.
    pub stopped: String,
    /// After a consent that was declined.
    pub declined: String,
    /// After answers that exclude the participant from the study.
    pub not_eligible: String,
    /// After a score above its limit.
    pub score_limit: String,
    /// Question of the sickness scale, asked while driving.
    pub fms: String,
    /// Label of the lower end of the sickness scale.
    pub fms_low: String,
    /// Label of the upper end of the sickness scale.
    pub fms_high: String,
    /// Label of the control that plays a spoken page again.
    pub again: String,
    /// Notice while the room is recorded.
    pub room: String,
    /// Notice while the experimenter prepares the next step.
    pub wait: String,
    /// Notice while a drive is paused.
    pub paused: String,
    /// After the participant asked to stop.
    pub asked: String,
    /// Notice while the session cannot be saved, as the disk is full.
    pub disk: String,
    /// At a required question without an answer.
    pub required: String,
    /// At a question for a number with another answer; `{low}` and `{high}` stand for the range.
    pub number: String,
    /// Explanation of the star at a required question.
    pub star: String,
    /// First answer of a yes-or-no question.
    pub yes: String,
    /// Second answer of a yes-or-no question.
    pub no: String,
    /// Entry that ends a multiple choice.
    pub no_more: String,
    /// Label of the button for the next page.
    pub next: String,
    /// Label of the button for the previous page.
    pub back: String,
    /// Action of the arrow keys and the wheel.
    pub choose: String,
    /// Action of Enter and the answer button.
    pub answer: String,
    /// Name of the keys that choose.
    pub arrows: String,
    /// Gesture that chooses with the wheel.
    pub wheel: String,
    /// Name of the wheel's pad whose directions change a rating.
    pub dpad: String,
    /// Name of the wheel button that answers.
    pub answer_button: String,
    /// Name of the wheel button that goes back.
    pub back_button: String,
    /// Names of the wheel's `{steering}`, `{accelerator}` and `{brake}`.
    pub steering_wheel: String,
    pub accelerator_pedal: String,
    pub brake_pedal: String,
    /// Names of the keyboard's `{steering}`, `{accelerator}` and `{brake}`.
    pub steering_keys: String,
    pub accelerator_key: String,
    pub brake_key: String,
    /// Names of the gamepad's `{steering}`, `{accelerator}` and `{brake}`, and of its button that answers.
    pub steering_stick: String,
    pub accelerator_trigger: String,
    pub brake_trigger: String,
    pub answer_pad_button: String,
}

impl Default for ParticipantTexts {
    fn default() -> Self {
        Self {
            go_on: "Press {button} on the wheel to continue.".into(),
            ready: "The drive begins soon. Hands on {steering}, ready to press {brake}.".into(),
            rolling: "The drive begins soon, at {speed}. Hands on {steering}, ready to press {accelerator}.".into(),
            brake: "Press {brake} and hold it.".into(),
            drive_over: "This drive is over.".into(),
            rest: "Take a rest.".into(),
            rest_over: "The rest is over.".into(),
            thanks: "You have finished. Thank you!".into(),
            stopped: "We stop here. Thank you for taking part!".into(),
            declined: "You do not take part, and that is fine. There are no more questions. Thank you for coming!"
                .into(),
            not_eligible: "Thank you for your answers. By the rules of this study you cannot drive today, so we stop \
                here. The experimenter will explain the reason. Thank you for coming!"
                .into(),
            score_limit:
                "We stop here for your well-being: your last answers are above the limit of this study. Please tell \
                 the experimenter how you feel. Thank you for taking part!"
                    .into(),
            fms: "How sick do you feel now?".into(),
            fms_low: "0 not at all".into(),
            fms_high: "20 very sick".into(),
            again: "play again".into(),
            room: "the room is recorded".into(),
            wait: "Please wait a moment.".into(),
            paused: "A short pause. The drive will continue soon.".into(),
            asked: "You asked to stop. The experimenter will be with you in a moment.".into(),
            disk: "Please wait. The computer cannot save the data yet; the experimenter is taking care of it.".into(),
            required: "Please answer this question.".into(),
            number: "Please write a number from {low} to {high}.".into(),
            star: "* Please answer".into(),
            yes: "Yes".into(),
            no: "No".into(),
            no_more: "That is all".into(),
            next: "Next".into(),
            back: "Back".into(),
            choose: "choose".into(),
            answer: "answer".into(),
            arrows: "arrow keys".into(),
            wheel: "turn the wheel".into(),
            dpad: "arrow buttons".into(),
            answer_button: "× (cross)".into(),
            back_button: "Δ (triangle)".into(),
            steering_wheel: "the wheel".into(),
            accelerator_pedal: "the accelerator pedal".into(),
            brake_pedal: "the brake pedal".into(),
            steering_keys: "the arrow keys".into(),
            accelerator_key: "the Up arrow key (accelerator)".into(),
            brake_key: "the Down arrow key (brake)".into(),
            steering_stick: "the left stick".into(),
            accelerator_trigger: "the right trigger (accelerator)".into(),
            brake_trigger: "the left trigger (brake)".into(),
            answer_pad_button: "lower button (A)".into(),
        }
    }
}

/// Control that a participant uses, whatever the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NamedControl {
    Steering,
    Accelerator,
    Brake,
    /// Chooses an answer of a page.
    Choose,
    /// Changes the rating of the sickness scale while driving.
    Rate,
    /// Answers, and goes to the next page.
    Answer,
    Back,
    /// Plays a spoken page again.
    Again,
}

/// Controls that texts name by a placeholder.
const PLACEHOLDERS: [(&str, NamedControl); 3] = [
    ("{steering}", NamedControl::Steering),
    ("{accelerator}", NamedControl::Accelerator),
    ("{brake}", NamedControl::Brake),
];

impl ParticipantTexts {
    /// Returns the name of a control on this device.
    pub fn control(&self, control: NamedControl, source: ControlSource) -> &str {
        let [keyboard, pad, wheel]: [&str; 3] = match control {
            NamedControl::Steering => [&self.steering_keys, &self.steering_stick, &self.steering_wheel],
            NamedControl::Accelerator => [&self.accelerator_key, &self.accelerator_trigger, &self.accelerator_pedal],
            NamedControl::Brake => [&self.brake_key, &self.brake_trigger, &self.brake_pedal],
            NamedControl::Choose => [&self.arrows, &self.dpad, &self.wheel],
            NamedControl::Rate => ["+ \u{2212}", &self.dpad, &self.dpad],
            NamedControl::Answer => ["Enter", &self.answer_pad_button, &self.answer_button],
            NamedControl::Back => ["Backspace", &self.brake_trigger, &self.back_button],
            NamedControl::Again => ["R", &self.brake_trigger, &self.back_button],
        };
        match source {
            ControlSource::Keyboard => keyboard,
            ControlSource::Pad => pad,
            ControlSource::Wheel => wheel,
        }
    }

    /// Lists the keys of own texts that name no control where codrive's own text names one, each with the missing placeholder.
    /// With such a text a keyboard's keys are not named.
    pub fn without_controls(&self) -> Vec<(&'static str, &'static str)> {
        let own = [
            ("ready", &self.ready, "{brake}"),
            ("rolling", &self.rolling, "{accelerator}"),
            ("brake", &self.brake, "{brake}"),
        ];
        let names_none = |text: &str| PLACEHOLDERS.iter().all(|(placeholder, _)| !text.contains(placeholder));
        own.into_iter().filter(|(_, text, _)| names_none(text)).map(|(key, _, missing)| (key, missing)).collect()
    }

    /// Returns a text with the names of this device's controls in place of the placeholders.
    pub fn with_controls<'a>(&self, text: &'a str, source: ControlSource) -> Cow<'a, str> {
        PLACEHOLDERS.iter().fold(Cow::Borrowed(text), |text, (placeholder, control)| {
            if text.contains(placeholder) {
                Cow::Owned(text.replace(placeholder, self.control(*control, source)))
            } else {
                text
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn own_texts_without_a_placeholder_are_listed_with_the_missing_one() {
        assert_eq!(ParticipantTexts::default().without_controls(), []);
        let own = ParticipantTexts {
            ready: "Hands on {steering}.".into(),
            rolling: "It begins at {speed}.".into(),
            brake: "Press the pedal.".into(),
            ..ParticipantTexts::default()
        };
        assert_eq!(own.without_controls(), [("rolling", "{accelerator}"), ("brake", "{brake}")]);
    }

    #[test]
    fn texts_name_keys_with_a_keyboard_and_pedals_with_a_wheel() {
        let texts = ParticipantTexts::default();
        let brake = |source| texts.with_controls(&texts.brake, source).into_owned();
        assert_eq!(brake(ControlSource::Keyboard), "Press the Down arrow key (brake) and hold it.");
        assert_eq!(brake(ControlSource::Wheel), "Press the brake pedal and hold it.");
        assert_eq!(brake(ControlSource::Pad), "Press the left trigger (brake) and hold it.");
        for text in [&texts.ready, &texts.rolling, &texts.brake] {
            let keys = texts.with_controls(text, ControlSource::Keyboard);
            assert!(!keys.contains("wheel") && !keys.contains("pedal") && keys.contains("key"), "{keys}");
        }
        assert!(matches!(texts.with_controls("Take a rest.", ControlSource::Keyboard), Cow::Borrowed(_)));
    }
}
