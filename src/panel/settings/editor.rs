//! The scenario's settings as widgets. In: the list of settings ([`Scenario::fields`]), whose docs become tooltips and
//! whose limits become the widgets' limits; the words to choose from. Out: an edited [`Scenario`]. Apart from the
//! sections and a few names, nothing here depends on a particular setting.

use std::collections::BTreeMap;

use egui::{ComboBox, DragValue, Response, RichText, TextEdit, Ui};
use serde_json::Value;

use crate::panel::theme;
use crate::{
    scenario::Scenario,
    settings::{Field, SettingKind, SettingsError},
};

/// Sections and their settings, in order; a path that ends in a dot is a whole table. Settings in no section come last.
const SECTIONS: [(&str, &[&str]); 10] = [
    (
        "Road & traffic",
        &[
            "map",
            "vehicles",
            "traffic",
            "traffic_leader",
            "traffic_drivers",
            "lateral_accel_mps2",
            "start",
            "warm_up_s",
        ],
    ),
    ("IDM", &["idm."]),
    ("Advice", &["policy", "policy_speed_mps", "hold_s", "range_mph"]),
    (
        "Display",
        &[
            "units",
            "palette",
            "guidance",
            "dial_full",
            "screen_width_m",
            "eye_distance_m",
            "cockpit",
            "mirror_yaw_deg",
            "mirror_pitch_deg",
            "mirror_fov_deg",
            "mirror_radius_m",
            "quality",
        ],
    ),
    ("Sound", &["sound.", "advice_tone", "spoken_guidance"]),
    ("Rig", &["rev_lamps", "flash_patch", "extra_delay_s"]),
    (
        "Surroundings",
        &[
            "time_h",
            "rain_mmph",
            "visibility_km",
            "wind_mps",
            "trees",
            "ego_colour",
            "traffic_colour",
            "ordinary_paints",
        ],
    ),
    ("Secondary task", &["secondary_task."]),
    ("Automation", &["automation."]),
    ("Run", &[]),
];
/// Setting without a widget: with a window there is always a participant.
const WITHOUT_WIDGET: &str = "participant";
/// Sections that are closed at first: set once for a rig or a study.
const CLOSED: [&str; 6] = ["Display", "Sound", "Rig", "Surroundings", "Secondary task", "Automation"];

/// Words to choose from, for settings that are texts. The schema does not know the maps and policies on this machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SettingChoices(BTreeMap<String, (Vec<String>, Option<String>)>);

impl SettingChoices {
    /// Adds the words for one setting. `other` describes what else may be typed ("path of a net.xml"); `None` if
    /// nothing.
    pub fn with<W: ToString>(mut self, path: &str, words: impl IntoIterator<Item = W>, other: Option<&str>) -> Self {
        let words = words.into_iter().map(|word| word.to_string()).collect();
        self.0.insert(path.into(), (words, other.map(Into::into)));
        self
    }
}

/// Editor of a scenario.
pub struct ScenarioEditor {
    fields: Vec<Field>,
    choices: SettingChoices,
    driving: Value,
    edited: Value,
    /// Name of the policy in use.
    policy: String,
}

impl ScenarioEditor {
    /// Creates an editor that starts from `scenario`.
    pub fn new(scenario: &Scenario, choices: SettingChoices) -> Self {
        let driving = json(scenario);
        let fields = Scenario::fields().into_iter().filter(|field| field.path != WITHOUT_WIDGET).collect();
        Self { fields, choices, edited: driving.clone(), driving, policy: String::new() }
    }

    /// Updates the scenario in use. A different one replaces all edits.
    pub fn follow(&mut self, scenario: &Scenario) {
        let driving = json(scenario);
        if driving != self.driving {
            self.edited = driving.clone();
            self.driving = driving;
        }
    }

    /// Updates the name of the policy in use, which the scenario may leave open (`auto`).
    pub fn follow_policy(&mut self, name: &str) {
        if self.policy != name {
            self.policy = name.into();
        }
    }

    /// Returns the text for a choice: an open policy gets the name of the one in use, unless policy or map has been
    /// edited.
    fn shown(&self, field: &Field, value: &str) -> String {
        let same = |key: &str| self.edited.get(key) == self.driving.get(key);
        let is_open = field.path == "policy" && !self.policy.is_empty() && value != self.policy;
        if is_open && same("policy") && same("map") { format!("{value}: {}", self.policy) } else { value.to_owned() }
    }

    /// Takes over all settings of `scenario` as edits.
    pub fn edit(&mut self, scenario: &Scenario) {
        self.edited = json(scenario);
    }

    /// Returns true if a restart would change something.
    pub fn is_edited(&self) -> bool {
        self.edited != self.driving
    }

    /// Discards all edits: the settings of the drive return.
    pub fn discard(&mut self) {
        self.edited = self.driving.clone();
    }

    /// Returns the edited scenario.
    ///
    /// # Errors
    /// The settings contradict each other; the message names setting, value and what is allowed.
    pub fn scenario(&self) -> Result<Scenario, SettingsError> {
        let all: Vec<(Field, Value)> = self
            .fields
            .iter()
            .filter_map(|field| field.get(&self.edited).map(|value| (field.clone(), value.clone())))
            .collect();
        Scenario::default().with(&all)
    }

    /// Shows all sections with their settings.
    pub fn show(&mut self, ui: &mut Ui) {
        for (section, (title, _)) in SECTIONS.iter().enumerate() {
            let changed = self.in_section(section).any(|field| self.has_changed(field));
            let title = RichText::new(*title).color(if changed { theme::AMBER } else { theme::TEXT }).strong();
            egui::CollapsingHeader::new(title)
                .id_salt(section)
                .default_open(!CLOSED.contains(&SECTIONS[section].0))
                .show(ui, |ui| {
                    let here: Vec<Field> = self.in_section(section).cloned().collect();
                    for field in &here {
                        self.row(ui, field);
                    }
                });
        }
    }

    fn in_section(&self, section: usize) -> impl Iterator<Item = &Field> {
        self.fields.iter().filter(move |field| section_of(&field.path) == section)
    }

    fn has_changed(&self, field: &Field) -> bool {
        field.get(&self.edited) != field.get(&self.driving)
    }

    /// Shows a setting: name on the left, widget on the right, both with a tooltip.
    fn row(&mut self, ui: &mut Ui, field: &Field) {
        let Some(mut value) = field.get(&self.edited).cloned() else { return };
        let colour = if self.has_changed(field) { theme::AMBER } else { theme::TEXT };
        let tip = tooltip(field);
        ui.horizontal(|ui| {
            let label = ui.label(RichText::new(name_of(field)).color(colour)).on_hover_text(&tip);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let widget = self.widget(ui, field, &mut value);
                widget.labelled_by(label.id).on_hover_text(&tip);
            });
        });
        if field.fault(&value).is_none() {
            field.set(&mut self.edited, value);
        }
    }

    fn widget(&self, ui: &mut Ui, field: &Field, value: &mut Value) -> Response {
        match &field.kind {
            SettingKind::Switch => {
                let mut on = value.as_bool().unwrap_or_default();
                let response = ui.checkbox(&mut on, "");
                *value = on.into();
                response
            }
            SettingKind::Whole { min, max } => {
                let mut number = value.as_u64().unwrap_or(*min);
                let drag = DragValue::new(&mut number).range(*min..=*max).speed(0.1);
                let response = ui.add(with_unit(drag, field));
                *value = number.into();
                response
            }
            SettingKind::Number { min, max } => {
                let mut number = value.as_f64().unwrap_or(*min);
                // A drag of a hundred pixels doubles the number.
                let speed = 0.01 * number.abs().max(0.02 * (max - min));
                let drag = DragValue::new(&mut number).range(*min..=*max).speed(speed).max_decimals(3);
                let response = ui.add(with_unit(drag, field));
                *value = number.into();
                response
            }
            SettingKind::Choice(words) => choose(ui, field, words, value, str::to_owned),
            SettingKind::Text => match self.choices.0.get(&field.path) {
                Some((words, None)) => choose(ui, field, words, value, |now| self.shown(field, now)),
                Some((words, Some(other))) => choose_or_type(ui, field, words, other, value),
                None => type_in(ui, field, "", value),
            },
        }
    }
}

fn json(scenario: &Scenario) -> Value {
    serde_json::to_value(scenario).unwrap_or_default()
}

fn section_of(path: &str) -> usize {
    let holds = |pattern: &&str| *pattern == path || (pattern.ends_with('.') && path.starts_with(*pattern));
    SECTIONS.iter().position(|(_, paths)| paths.iter().any(holds)).unwrap_or(SECTIONS.len() - 1)
}

/// Returns the text before the widget: `Policy speed`; in a table the symbol and its meaning, `T  Desired time gap to
/// the leader`.
fn name_of(field: &Field) -> String {
    if field.table().is_some() {
        let symbol = field.path.rsplit('.').next().unwrap_or_default();
        let meaning = field.doc.split([',', ';', ':']).next().unwrap_or_default();
        // A symbol of the literature is shown before its meaning; a key of several words would only repeat it.
        return if symbol.contains('_') { meaning.to_owned() } else { format!("{symbol}  {meaning}") };
    }
    let flag = field.flag().replace('-', " ");
    let mut letters = flag.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn tooltip(field: &Field) -> String {
    let default = match &field.default {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    match field.kind {
        SettingKind::Switch | SettingKind::Text => format!("{}.\nDefault {default}.", field.doc),
        _ => format!("{}.\nAllowed: {}. Default {default}.", field.doc, field.allowed()),
    }
}

fn with_unit<'a>(drag: DragValue<'a>, field: &Field) -> DragValue<'a> {
    // Applied after typing: on the way to 22 the number is not 2.
    let drag = drag.update_while_editing(false).min_size(egui::vec2(92.0, 0.0)).custom_parser(number_from);
    if field.unit.is_empty() { drag } else { drag.suffix(format!(" {}", field.unit.replace("s2", "s²"))) }
}

/// Parses a finite number with a decimal point or comma; `None` keeps the old one.
fn number_from(text: &str) -> Option<f64> {
    let text = text.trim().replace(',', ".").replace('−', "-");
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

const CHOICE_WIDTH: f32 = 150.0;
/// Height of an open list, points: shows the shipped maps up to the default, which is the eighth.
const LIST_HEIGHT: f32 = 280.0;

fn choose(ui: &mut Ui, field: &Field, words: &[String], value: &mut Value, shown: impl Fn(&str) -> String) -> Response {
    let now = value.as_str().unwrap_or_default().to_owned();
    ComboBox::from_id_salt(&field.path)
        .selected_text(shown(&now))
        .width(CHOICE_WIDTH)
        .height(LIST_HEIGHT)
        .show_ui(ui, |ui| {
            for word in words {
                if ui.selectable_label(*word == now, word).clicked() {
                    *value = word.as_str().into();
                }
            }
        })
        .response
}

fn type_in(ui: &mut Ui, field: &Field, hint: &str, value: &mut Value) -> Response {
    let mut text = value.as_str().unwrap_or_default().to_owned();
    let edit = TextEdit::singleline(&mut text).id_salt(&field.path).hint_text(hint).desired_width(CHOICE_WIDTH);
    let response = ui.add(edit);
    *value = text.into();
    response
}

/// Shows a list whose last entry opens a text line; the line stays while the text is none of the words.
fn choose_or_type(ui: &mut Ui, field: &Field, words: &[String], other: &str, value: &mut Value) -> Response {
    let now = value.as_str().unwrap_or_default().to_owned();
    if words.contains(&now) {
        let response = ComboBox::from_id_salt(&field.path)
            .selected_text(&now)
            .width(CHOICE_WIDTH)
            .height(LIST_HEIGHT)
            .show_ui(ui, |ui| {
                for word in words {
                    if ui.selectable_label(*word == now, word).clicked() {
                        *value = word.as_str().into();
                    }
                }
                if ui.selectable_label(false, format!("{other} …")).clicked() {
                    *value = "".into();
                }
            })
            .response;
        return response;
    }
    if ui.small_button("list").on_hover_text("Choose from the list again").clicked() {
        *value = words.first().cloned().unwrap_or_default().into();
    }
    let mut text = value.as_str().unwrap_or_default().to_owned();
    let width = CHOICE_WIDTH - 30.0;
    let edit = TextEdit::singleline(&mut text).id_salt((&field.path, "other")).hint_text(other).desired_width(width);
    let response = ui.add(edit);
    *value = text.into();
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_name_only_settings_that_exist() {
        let all = Scenario::fields();
        for (title, paths) in SECTIONS {
            for path in paths.iter().chain([&WITHOUT_WIDGET]) {
                assert!(all.iter().any(|field| field.path.starts_with(path)), "{title}: {path}");
            }
        }
    }

    #[test]
    fn an_edit_is_noticed_taken_back_and_replaced_by_a_new_drive() {
        let mut editor = ScenarioEditor::new(&Scenario::default(), SettingChoices::default());
        assert!(!editor.is_edited());
        assert_eq!(editor.scenario().unwrap(), Scenario::default());
        let vehicles = editor.fields.iter().find(|field| field.path == "vehicles").unwrap().clone();
        vehicles.set(&mut editor.edited, 18.into());
        assert!(editor.is_edited());
        editor.follow(&Scenario::default());
        assert_eq!(editor.scenario().unwrap().vehicles, 18, "the same drive goes on: the edit stays");
        editor.discard();
        assert!(!editor.is_edited());
        vehicles.set(&mut editor.edited, 18.into());
        editor.follow(&Scenario { vehicles: 12, ..Scenario::default() });
        assert_eq!(editor.scenario().unwrap().vehicles, 12);
        assert!(!editor.is_edited());
    }

    #[test]
    fn an_open_policy_is_shown_with_the_name_of_the_one_in_use() {
        let mut editor = ScenarioEditor::new(&Scenario::default(), SettingChoices::default());
        let field = |path: &str| Scenario::fields().into_iter().find(|field| field.path == path).unwrap();
        let (policy, map) = (field("policy"), field("map"));
        assert_eq!(editor.shown(&policy, "auto"), "auto", "before there is a world");
        editor.follow_policy("ring-250-speed");
        assert_eq!(editor.shown(&policy, "auto"), "auto: ring-250-speed");
        assert_eq!(editor.shown(&map, "ring-250"), "ring-250");
        map.set(&mut editor.edited, "ring-641".into());
        assert_eq!(editor.shown(&policy, "auto"), "auto", "on another road it is another one");
        editor.discard();
        policy.set(&mut editor.edited, "pi".into());
        assert_eq!(editor.shown(&policy, "pi"), "pi", "edited, not yet driving");
    }

    #[test]
    fn only_finite_numbers_are_numbers() {
        assert_eq!(number_from(" 1,5 "), Some(1.5));
        assert_eq!(number_from("−3"), Some(-3.0));
        for text in ["nan", "inf", "-infinity", "1e999", "", "many"] {
            assert_eq!(number_from(text), None, "{text}");
        }
    }

    #[test]
    fn names_are_words_without_units() {
        let names: Vec<String> = Scenario::fields().iter().map(name_of).collect();
        for name in [
            "Vehicles",
            "Policy speed",
            "Hold",
            "Range",
            "Screen width",
            "Lateral accel",
            "T  Desired time gap to the leader",
        ] {
            assert!(names.iter().any(|n| n == name), "no {name} among {names:?}");
        }
        for unit in [" mps", " mph", " deg", " m", " s"] {
            assert!(!names.iter().any(|name| name.contains(&format!("{unit}2")) || name.ends_with(unit)), "{names:?}");
        }
    }
}
