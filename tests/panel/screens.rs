//! The participant's screens and the experimenter's part of a session, used through their labels, by keys and mouse; and pictures of all of
//! them.

use codrive::{
    controls::ControlSource,
    panel::{ParticipantScreen, ScreenPainter, ScreenState},
    study::{FormInput, ParticipantTexts, Questionnaire, QuestionnaireForm},
    units::SpeedUnit,
};
use egui::{Key, accesskit::Role};
use egui_kittest::{Harness, kittest::Queryable};
use serde_json::json;
use std::path::Path;

/// A questionnaire with every kind of question, short enough to be visible at once.
const EVERY_KIND: &str = r#"{ "title": "You and this drive", "pages": [
  { "name": "one", "title": "About you", "elements": [
    { "type": "html", "name": "intro", "html": "<p>There are no wrong answers.</p>" },
    { "type": "boolean", "name": "licence", "title": "Do you hold a driving licence?", "isRequired": true },
    { "type": "radiogroup", "name": "years", "title": "For how long?", "visibleIf": "{licence} = true",
      "choices": ["Up to 2 years", "3 to 10 years", "Longer"] },
    { "type": "rating", "name": "effort", "title": "How hard was it?", "description": "All in all.", "isRequired": true,
      "rateMin": 0, "rateMax": 100, "rateStep": 5, "minRateDescription": "Very easy", "maxRateDescription": "Very hard" }
  ] },
  { "name": "two", "elements": [
    { "type": "matrix", "name": "symptom", "title": "How strong is it now?", "isRequired": true,
      "columns": ["None", "Slight", "Moderate", "Severe"], "rows": ["Headache", "Nausea"] },
    { "type": "rating", "name": "real", "title": "Driving felt real.", "rateMin": 1, "rateMax": 7 },
    { "type": "checkbox", "name": "seen", "title": "What did you see?", "choices": ["Waves", "Calm", "A jam"] }
  ] },
  { "name": "three", "elements": [
    { "type": "text", "name": "car", "title": "Which car do you drive?", "isRequired": true },
    { "type": "comment", "name": "more", "title": "What else?" }
  ] } ] }"#;

/// A participant's screen with the state that the program gives it.
pub struct Desk {
    pub screens: ScreenPainter,
    pub form: Option<QuestionnaireForm>,
    pub page: Option<&'static str>,
    pub rest_s: Option<f64>,
    pub countdown: Option<u32>,
    /// Speed at the start, mph.
    pub rolls: u32,
    pub words: Option<&'static str>,
    pub wheel: bool,
    pub inputs: Vec<FormInput>,
}

impl Desk {
    pub fn new() -> Self {
        Self {
            screens: ScreenPainter::default(),
            form: None,
            page: None,
            rest_s: None,
            countdown: None,
            rolls: 0,
            words: None,
            wheel: false,
            inputs: Vec::new(),
        }
    }

    pub fn questions(text: &str) -> Self {
        let questionnaire = Questionnaire::parse(text, "test.json").unwrap();
        Self { form: Some(QuestionnaireForm::new(&questionnaire, 0.0)), ..Self::new() }
    }

    pub fn shipped(name: &str) -> Self {
        let questionnaire = Questionnaire::find(name, Path::new(".")).unwrap();
        Self { form: Some(QuestionnaireForm::new(&questionnaire, 0.0)), ..Self::new() }
    }

    pub fn form(&self) -> &QuestionnaireForm {
        self.form.as_ref().unwrap()
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        let texts = ParticipantTexts::default();
        let screen = match (&self.form, self.page, self.rest_s, self.countdown) {
            (Some(form), ..) => ParticipantScreen::Questions(form),
            (_, Some(page), ..) => ParticipantScreen::Page(page),
            (_, _, Some(left_s), _) => ParticipantScreen::Rest("Take a rest. Look into the distance.", left_s),
            (_, _, _, Some(left)) => ParticipantScreen::Countdown(left, self.rolls, SpeedUnit::Mph),
            _ => ParticipantScreen::Drive(self.words),
        };
        let source = if self.wheel { ControlSource::Wheel } else { ControlSource::Keyboard };
        let state = ScreenState { screen, texts: &texts, progress: [3, 13], source, spoken: false };
        let inputs = self.screens.show(ui, &state);
        for input in inputs {
            self.inputs.push(input.clone());
            if let Some(form) = &mut self.form {
                form.take(input, 1.0);
            }
        }
    }
}

pub fn harness(desk: Desk, size: [f32; 2], scale: f32) -> Harness<'static, Desk> {
    crate::harness(desk, size, scale, |ui, desk| desk.show(ui))
}

fn tall(desk: Desk) -> Harness<'static, Desk> {
    harness(desk, [900.0, 600.0], 1.0)
}

pub fn keys<State>(harness: &mut Harness<'static, State>, list: &[Key]) {
    for key in list {
        harness.key_press(*key);
        harness.run();
    }
}

fn click(harness: &mut Harness<'static, Desk>, label: &str) {
    harness.get_by_label(label).click();
    harness.run();
}

pub fn type_in<State>(harness: &mut Harness<'static, State>, text: &str) {
    harness.event(egui::Event::Text(text.into()));
    harness.run();
}

#[test]
fn keys_alone_answer_every_kind_of_question() {
    use Key::{ArrowDown, ArrowLeft, ArrowRight, Backspace, Enter, Space};
    let mut harness = tall(Desk::questions(EVERY_KIND));
    assert!(harness.query_by_label("For how long? *").is_none());
    keys(&mut harness, &[ArrowRight, Enter]);
    harness.get_by_label("For how long?");
    keys(&mut harness, &[ArrowDown, ArrowDown, Enter, ArrowRight, ArrowLeft, Enter, Enter]);
    let form = harness.state().form();
    assert_eq!(form.answer("years"), Some(&json!("3 to 10 years")));
    assert_eq!((form.answer("effort"), form.page().name.as_str()), (Some(&json!(45)), "two"));
    keys(&mut harness, &[ArrowRight, ArrowRight, Enter, ArrowLeft, Enter, Enter]);
    keys(&mut harness, &[ArrowDown, Space, ArrowDown, ArrowDown, Enter, ArrowDown, Enter, Enter]);
    let form = harness.state().form();
    assert_eq!((form.answer("symptom.Headache"), form.answer("real")), (Some(&json!("Slight")), None));
    assert_eq!(
        (form.answer("symptom.Nausea"), form.answer("seen")),
        (Some(&json!("Severe")), Some(&json!(["Waves", "A jam"])))
    );
    // A text field keeps its letters: m sets no mark, and Backspace deletes a letter.
    type_in(&mut harness, "mini");
    keys(&mut harness, &[Backspace, Enter]);
    assert_eq!(harness.state().form().answer("car"), Some(&json!("min")));
    assert!(!harness.state().inputs.contains(&FormInput::Mark));
    type_in(&mut harness, "two");
    keys(&mut harness, &[Enter]);
    // Outside a text field Backspace goes back.
    keys(&mut harness, &[Key::PageUp]);
    assert_eq!(harness.state().form().page().name, "two");
    keys(&mut harness, &[Key::PageDown, Enter, Enter, Enter]);
    assert!(harness.state().form().is_over());
    assert_eq!(harness.state().form().answered().len(), 8);
}

#[test]
fn a_mouse_answers_and_a_missing_answer_is_asked_for_at_its_question() {
    let mut harness = tall(Desk::questions(EVERY_KIND));
    click(&mut harness, "Next");
    let message = ParticipantTexts::default().required;
    assert_eq!(harness.get_all_by_label(&message).count(), 2, "licence and effort");
    let question = harness.get_by_label("Do you hold a driving licence? *").rect();
    let first = harness.get_all_by_label(&message).map(|node| node.rect().top()).fold(f32::INFINITY, f32::min);
    assert!(first > question.bottom() && first - question.bottom() < 60.0, "{first} {question:?}");
    click(&mut harness, "Do you hold a driving licence?: No");
    assert_eq!(harness.get_all_by_label(&message).count(), 1);
    click(&mut harness, "How hard was it?: 80");
    assert!(harness.query_by_label("Back").is_none(), "nothing is before the first page");
    click(&mut harness, "Next");
    for label in ["Headache: None", "Nausea: Moderate", "Driving felt real.: 6", "Waves", "Calm", "Waves"] {
        click(&mut harness, label);
    }
    let chosen = harness.get_by_label("Nausea: Moderate");
    assert!(format!("{chosen:?}").contains("Nausea"), "what is chosen says so to a reader of the screen");
    click(&mut harness, "Next");
    harness.get_by_role(Role::TextInput).click();
    harness.run();
    type_in(&mut harness, "none");
    click(&mut harness, "Back");
    click(&mut harness, "Next");
    click(&mut harness, "Next");
    let form = harness.state().form();
    assert!(form.is_over());
    let answers: Vec<(String, serde_json::Value)> =
        form.answered().into_iter().map(|a| (a.question, a.answer)).collect();
    let expected = [
        ("licence", json!(false)),
        ("effort", json!(80)),
        ("symptom.Headache", json!("None")),
        ("symptom.Nausea", json!("Moderate")),
        ("real", json!(6)),
        ("seen", json!(["Calm"])),
        ("car", json!("none")),
    ];
    assert_eq!(answers, expected.map(|(name, value)| (name.to_owned(), value)));
}

#[test]
fn pages_and_rests_say_which_key_acts_and_only_then() {
    let mut harness = tall(Desk { page: Some("# Welcome\n\nYou **may** stop."), ..Desk::new() });
    harness.get_by_label_contains("Welcome");
    keys(&mut harness, &[Key::Enter, Key::M, Key::Escape]);
    click(&mut harness, "Next");
    let made = std::mem::take(&mut harness.state_mut().inputs);
    assert_eq!(made, [FormInput::Next, FormInput::Mark, FormInput::Stop, FormInput::Next]);
    harness.state_mut().page = None;
    harness.state_mut().rest_s = Some(75.2);
    harness.run();
    harness.get_by_label("1:16");
    assert!(harness.query_by_label("Next").is_none());
    harness.state_mut().rest_s = Some(0.0);
    harness.run();
    click(&mut harness, "Next");
    assert_eq!(harness.state().inputs, [FormInput::Next]);
}

#[test]
fn the_drive_alone_has_no_pixel_of_a_screen() {
    let picture = |desk: Desk| harness(desk, [320.0, 180.0], 1.0).render().expect("a picture");
    let plain = picture(Desk::new());
    let first = *plain.get_pixel(0, 0);
    assert!(plain.pixels().all(|pixel| *pixel == first));
    let held = picture(Desk { words: Some("A short pause."), ..Desk::new() });
    let changed = held.pixels().zip(plain.pixels()).filter(|(a, b)| a != b).count();
    assert!((300..320 * 180 / 2).contains(&changed), "{changed}: a box, and the rest is the picture's");
}

/// Every line of a page lies within the window, and the focused row is visible.
#[test]
fn questions_fit_all_windows_at_every_scale_and_follow_the_focus() {
    for (size, scale) in [([640.0, 360.0], 1.0), ([320.0, 180.0], 2.0), ([960.0, 540.0], 2.0)] {
        let mut harness = harness(Desk::shipped("ssq"), size, scale);
        let rows = harness.state().form().stops().len();
        assert_eq!(rows, 8);
        for row in 0..rows {
            let name = harness.state().form().stops()[row].row.unwrap().text.clone();
            let rect = harness.get_by_label(&format!("{name}: Slight")).rect();
            let window = egui::Rect::from_min_size(egui::Pos2::ZERO, size.into());
            assert!(window.contains_rect(rect), "{name} at {rect:?} of {size:?}");
            keys(&mut harness, &[Key::ArrowRight, Key::ArrowRight, Key::Enter]);
            harness.run_steps(30);
        }
        let next = harness.get_by_label("Next").rect();
        assert!(next.bottom() < size[1] && next.width() > 20.0, "{next:?}");
    }
}

/// Instruction, meaning of the star and all eight rows of a page of symptoms are visible together, on both pages, and after arriving from
/// the end of the page before.
#[test]
fn a_page_of_symptoms_is_visible_from_its_top_in_windows_of_16_to_9() {
    for size in [[640.0, 360.0], [1280.0, 720.0], [1920.0, 1080.0]] {
        let mut harness = harness(Desk::shipped("ssq"), size, 1.0);
        for page in 0..2 {
            assert_eq!(harness.state().form().progress().0, page);
            harness.run_steps(30);
            let window = egui::Rect::from_min_size(egui::Pos2::ZERO, size.into());
            let stops: Vec<String> =
                harness.state().form().stops().iter().map(|stop| format!("{}: None", stop.row.unwrap().text)).collect();
            assert_eq!(stops.len(), 8);
            let title = harness.state().form().page().title.clone();
            let mut last = harness.get_by_label(&title).rect().bottom();
            assert!(window.contains_rect(harness.get_by_label(&title).rect()) && last > 0.04 * size[1], "{title}");
            harness.get_by_label("* Please answer");
            for name in &stops {
                let rect = harness.get_by_label(name).rect();
                assert!(rect.top() > last && rect.bottom() < size[1] - 0.1 * size[1], "{name} at {rect:?} of {size:?}");
                last = rect.bottom();
            }
            for _ in 0..8 {
                keys(&mut harness, &[Key::ArrowRight, Key::Enter]);
            }
            keys(&mut harness, &[Key::Enter]);
        }
    }
}

pub fn save<State>(harness: &mut Harness<'static, State>, name: &str) {
    let picture = harness.render().expect("a picture");
    let first = *picture.get_pixel(0, 0);
    let other = picture.pixels().filter(|pixel| **pixel != first).count();
    assert!(other > 300, "{name} shows nothing");
    if let Ok(folder) = std::env::var("CODRIVE_PICTURES") {
        picture.save(Path::new(&folder).join(format!("screen-{name}.png"))).expect("saved");
    }
}

/// Pictures for visual checks are written only if the environment names a folder; in any case each must show something.
#[test]
fn every_screen_has_its_picture() {
    use Key::{ArrowRight, Enter};
    let size = [640.0, 360.0];
    let page = "# Welcome\n\nYou will drive a car in traffic, first on a road to get used to it, then three times on a \
                ring.\n\nThe speedometer may show **advice**: a red line at the speed that helps the traffic most, and a \
                green band around it. When the number is green you are in the band.\n\n* Drive safely first.\n* You may \
                stop at any time.";
    save(&mut harness(Desk { page: Some(page), ..Desk::new() }, size, 1.0), "page");
    let wheel = Desk { page: Some("This drive is over."), wheel: true, ..Desk::new() };
    save(&mut harness(wheel, size, 1.0), "page-wheel");
    save(&mut harness(Desk { rest_s: Some(75.0), ..Desk::new() }, size, 1.0), "rest");
    save(&mut harness(Desk { countdown: Some(3), ..Desk::new() }, size, 1.0), "countdown");
    let mut rolling = harness(Desk { countdown: Some(3), rolls: 9, ..Desk::new() }, size, 1.0);
    let ready = "Hands on the arrow keys, ready to press the Up arrow key (accelerator). 3";
    rolling.get_by_label(&format!("The drive begins soon, at 9 mph. {ready}"));
    save(&mut rolling, "countdown-rolling");
    let words = Some("You asked to stop. The experimenter will be with you in a moment.");
    save(&mut harness(Desk { words, ..Desk::new() }, size, 1.0), "held");
    let mut ssq = harness(Desk { wheel: true, ..Desk::shipped("ssq") }, size, 1.0);
    keys(&mut ssq, &[ArrowRight, Enter, ArrowRight, ArrowRight, Enter, ArrowRight, ArrowRight, ArrowRight]);
    save(&mut ssq, "ssq");
    let mut tlx = harness(Desk::shipped("raw-tlx"), [1280.0, 720.0], 1.0);
    keys(&mut tlx, &[ArrowRight, Enter, ArrowRight, ArrowRight]);
    save(&mut tlx, "tlx");
    for name in ["consent", "screening", "sample", "trust", "nasa-tlx", "van-der-laan"] {
        let mut asked = harness(Desk::shipped(name), [1280.0, 720.0], 1.0);
        keys(&mut asked, &[ArrowRight, Enter].repeat(if name == "nasa-tlx" { 8 } else { 2 }));
        save(&mut asked, name);
    }
    let stopped = ParticipantTexts::default().score_limit;
    save(&mut harness(Desk { page: Some(stopped.leak()), ..Desk::new() }, size, 1.0), "stopped-by-limit");
    let mut every = harness(Desk::questions(EVERY_KIND), size, 1.5);
    keys(&mut every, &[ArrowRight, Enter, Key::PageDown]);
    save(&mut every, "every-one");
    let mut every = harness(Desk::questions(EVERY_KIND), [960.0, 540.0], 1.0);
    keys(&mut every, &[ArrowRight, ArrowRight, Enter, ArrowRight, Enter, Enter, ArrowRight, Enter, ArrowRight, Enter]);
    keys(&mut every, &[ArrowRight, Enter, ArrowRight, Enter]);
    save(&mut every, "every-two");
    keys(&mut every, &[ArrowRight, ArrowRight, ArrowRight, ArrowRight, Enter, Enter]);
    type_in(&mut every, "A small one");
    save(&mut every, "every-three");
}
