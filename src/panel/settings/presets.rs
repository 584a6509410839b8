//! Presets: scenario files in one folder, also for `codrive drive --scenario`. In: a scenario, a name. Out: files,
//! overwritten only on request; scenarios; error messages.

use super::ScenarioEditor;
use crate::panel::theme;
use crate::{
    record::{RecordError, new_private_dir, replace, write_new},
    scenario::Scenario,
    settings::SettingsError,
};
use egui::{ComboBox, RichText, TextEdit, Ui};
use std::path::{Path, PathBuf};

/// Maximum length of a name, characters.
const MOST: usize = 60;

/// Presets in the folder, and the name being typed.
pub struct PresetList {
    folder: PathBuf,
    names: Vec<String>,
    chosen: String,
    typed: String,
    /// Existing name that Replace may overwrite.
    taken: Option<String>,
    /// Last message; true if it is an error.
    message: Option<(String, bool)>,
}

/// Error on saving or loading a preset.
#[derive(Debug, thiserror::Error)]
pub enum PresetError {
    /// A preset of this name exists.
    #[error("{} exists: choose another name, or replace it", _0.display())]
    Taken(PathBuf),
    /// Not a valid name.
    #[error(
        "{_0:?} cannot be a name; allowed: 1 to {MOST} letters, digits, - and _, and no name that Windows reserves"
    )]
    Name(String),
    /// Faulty scenario file, or settings that contradict each other.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Write error of the file system.
    #[error(transparent)]
    File(#[from] RecordError),
}

impl PresetList {
    /// Lists the presets in `folder`, which need not exist yet.
    pub fn in_folder(folder: PathBuf) -> Self {
        let mut presets =
            Self { folder, names: Vec::new(), chosen: String::new(), typed: String::new(), taken: None, message: None };
        presets.read_folder();
        presets
    }

    /// Saves `scenario`; overwrites a preset of the same name only if `replaced` is true. Returns the file.
    ///
    /// # Errors
    /// The name is taken or not valid, or the system refuses.
    pub fn save(&self, name: &str, scenario: &Scenario, replaced: bool) -> Result<PathBuf, PresetError> {
        let path = self.path(name)?;
        new_private_dir(&self.folder)?;
        // Relative paths would be read from the preset's folder; those from the working folder are made absolute.
        let text = scenario.clone().paths_from(&std::env::current_dir().unwrap_or_default()).to_toml();
        if replaced {
            replace(&path, text.as_bytes())?;
        } else if path.exists() {
            return Err(PresetError::Taken(path));
        } else {
            write_new(&path, text.as_bytes())?;
        }
        Ok(path)
    }

    /// Loads the scenario of this name.
    ///
    /// # Errors
    /// There is none, or it is faulty; the message names file, line and what is allowed.
    pub fn load(&self, name: &str) -> Result<Scenario, PresetError> {
        Ok(Scenario::from_file(&self.path(name)?)?)
    }

    fn path(&self, name: &str) -> Result<PathBuf, PresetError> {
        let plain = name.chars().all(|c| c.is_alphanumeric() || c == '-' || c == '_');
        let small = name.to_lowercase();
        let numbered =
            |word: &str| small.strip_prefix(word).is_some_and(|rest| rest.parse::<u8>().is_ok_and(|n| n < 10));
        let device = ["con", "prn", "aux", "nul"].contains(&small.as_str()) || numbered("com") || numbered("lpt");
        if name.is_empty() || name.chars().count() > MOST || !plain || device {
            return Err(PresetError::Name(name.to_owned()));
        }
        Ok(self.folder.join(format!("{name}.toml")))
    }

    /// Reads the folder again.
    fn read_folder(&mut self) {
        let name = |path: &Path| {
            let name = path.file_stem()?.to_str()?.to_owned();
            (path.extension()? == "toml").then_some(name)
        };
        let entries = std::fs::read_dir(&self.folder).into_iter().flatten().flatten();
        self.names = entries.filter_map(|entry| name(&entry.path())).collect();
        self.names.sort();
        if !self.names.contains(&self.chosen) {
            self.chosen = self.names.first().cloned().unwrap_or_default();
        }
    }

    /// Shows the lines for loading and saving, above the settings.
    pub(in crate::panel) fn show(&mut self, ui: &mut Ui, editor: &mut ScenarioEditor) {
        ui.horizontal(|ui| {
            let label = ui.label("Preset").on_hover_text(format!("Scenario files in {}", self.folder.display()));
            let shown = if self.names.is_empty() { "none saved yet" } else { &self.chosen };
            let list = ComboBox::from_id_salt("preset").selected_text(shown).width(150.0);
            let list = list.show_ui(ui, |ui| {
                for name in &self.names {
                    ui.selectable_value(&mut self.chosen, name.clone(), name);
                }
            });
            list.response.labelled_by(label.id);
            let may = !self.chosen.is_empty();
            let load = ui.add_enabled(may, egui::Button::new("Load"));
            if load.on_hover_text("Load its settings; they apply after a restart").clicked() {
                let chosen = self.chosen.clone();
                self.message = Some(match self.load(&chosen) {
                    Ok(scenario) => {
                        editor.edit(&scenario);
                        (format!("{chosen} is loaded"), false)
                    }
                    Err(why) => (why.to_string(), true),
                });
            }
        });
        ui.horizontal(|ui| {
            let label = ui.label("Save as").on_hover_text("Name for the settings below");
            let line =
                TextEdit::singleline(&mut self.typed).id_salt("preset name").hint_text("name").desired_width(150.0);
            let line = ui.add(line).labelled_by(label.id);
            if line.changed() {
                self.taken = None;
            }
            let entered = line.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            let ready = !self.typed.trim().is_empty();
            if (ui.add_enabled(ready, egui::Button::new("Save")).clicked() || entered) && ready {
                self.try_saving(editor, false);
            }
            if self.taken.is_some() && ui.button("Replace").on_hover_text("Replace the preset of this name").clicked() {
                self.try_saving(editor, true);
            }
        });
        if let Some((words, wrong)) = &self.message {
            let colour = if *wrong { theme::RED } else { theme::DIM };
            ui.add(egui::Label::new(RichText::new(words).color(colour).size(12.5)).wrap());
        }
    }

    fn try_saving(&mut self, editor: &ScenarioEditor, replaced: bool) {
        let name = self.typed.trim().to_owned();
        let saved = match editor.scenario() {
            Ok(scenario) => self.save(&name, &scenario, replaced),
            Err(fault) => Err(fault.into()),
        };
        self.taken = None;
        self.message = Some(match saved {
            Ok(path) => {
                self.read_folder();
                self.chosen = name;
                self.typed.clear();
                (format!("saved as {}", path.display()), false)
            }
            Err(why) => {
                self.taken = matches!(why, PresetError::Taken(_)).then_some(name);
                (why.to_string(), true)
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preset_comes_back_as_it_was_and_is_not_overwritten_unasked() {
        let folder = tempfile::tempdir().unwrap();
        let presets = PresetList::in_folder(folder.path().join("scenarios"));
        let dense = Scenario { vehicles: 24, range_mph: 2.0, ..Scenario::default() };
        let path = presets.save("dense", &dense, false).unwrap();
        assert_eq!(presets.load("dense").unwrap(), dense);
        assert_eq!(Scenario::from_file(&path).unwrap(), dense, "an ordinary scenario file");
        let again = presets.save("dense", &Scenario::default(), false);
        assert!(matches!(again, Err(PresetError::Taken(taken)) if taken == path));
        assert_eq!(presets.load("dense").unwrap(), dense);
        presets.save("dense", &Scenario::default(), true).unwrap();
        assert_eq!(presets.load("dense").unwrap(), Scenario::default());
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
            assert_eq!(mode(&folder.path().join("scenarios")), 0o700);
            assert_eq!(mode(&folder.path().join("scenarios/dense.toml")), 0o600);
        }
    }

    #[test]
    fn names_that_leave_the_folder_or_are_reserved_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let presets = PresetList::in_folder(folder.path().into());
        let long = "a".repeat(MOST + 1);
        for name in ["", "../dense", "a/b", "a b", ".hidden", "nul", "COM1", "a\0b", &long] {
            let why = presets.save(name, &Scenario::default(), false).unwrap_err().to_string();
            assert!(why.contains("letters, digits"), "{why}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_wrong_file_and_an_unwritable_folder_are_named() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("bad.toml"), "vehicles = 1\n").unwrap();
        let why = PresetList::in_folder(folder.path().into()).load("bad").unwrap_err().to_string();
        assert!(why.contains("bad.toml:1") && why.contains("vehicles"), "{why}");
        let file = folder.path().join("bad.toml");
        let why = PresetList::in_folder(file).save("x", &Scenario::default(), false).unwrap_err().to_string();
        assert!(why.contains("bad.toml"), "{why}");
    }
}
