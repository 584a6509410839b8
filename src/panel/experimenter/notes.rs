//! Marks and notes of the experimenter. In: a key or a button, a line of text. Out: what is to be recorded; the last few stay
//! in sight.

use super::ExperimenterCommand;
use crate::panel::{readout::time, theme};
use egui::{Key, RichText, TextEdit, Ui};

/// Lines that stay in sight.
const KEPT: usize = 50;

/// What was written down in this session.
#[derive(Clone, Debug, Default)]
pub struct SessionNotes {
    text: String,
    /// Newest first: time of the drive, words.
    written: Vec<(f64, String)>,
    marks: u32,
    /// The next pass puts the cursor into the line.
    wants_focus: bool,
}

impl SessionNotes {
    /// Shows what happened, beside what was written here: a wheel unplugged, a recording that begins.
    pub fn say(&mut self, time_s: f64, words: &str) {
        self.written.insert(0, (time_s, words.to_owned()));
        self.written.truncate(KEPT);
    }

    /// Marks this moment.
    pub fn mark(&mut self, time_s: f64, commands: &mut Vec<ExperimenterCommand>) {
        commands.push(ExperimenterCommand::Mark(self.number(time_s)));
    }

    /// A mark was set at this time, whoever sets it. Returns its number, from 1.
    pub fn number(&mut self, time_s: f64) -> u32 {
        self.marks += 1;
        self.say(time_s, &format!("mark {}", self.marks));
        self.marks
    }

    /// The next pass puts the cursor into the line for notes.
    pub fn focus(&mut self) {
        self.wants_focus = true;
    }

    /// Buttons, line and list.
    pub fn show(&mut self, ui: &mut Ui, time_s: f64, commands: &mut Vec<ExperimenterCommand>) {
        ui.horizontal(|ui| {
            if ui.button("Mark").on_hover_text("Mark this moment in the recording (Ctrl+M)").clicked() {
                self.mark(time_s, commands);
            }
            let may = !self.text.trim().is_empty();
            let button = ui.add_enabled(may, egui::Button::new("Write note"));
            if button.on_disabled_hover_text("Type something below (Ctrl+N)").clicked() {
                self.write(time_s, commands);
            }
        });
        let label = ui.label(RichText::new("Note").color(theme::DIM).size(12.5));
        let line =
            TextEdit::singleline(&mut self.text).hint_text("Ctrl+N, then Enter writes it").desired_width(f32::INFINITY);
        let response = ui.add(line).labelled_by(label.id);
        if std::mem::take(&mut self.wants_focus) {
            response.request_focus();
        }
        if response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)) && !self.text.trim().is_empty() {
            self.write(time_s, commands);
            // Ready for the next one.
            response.request_focus();
        }
        ui.add_space(4.0);
        self.list(ui);
    }

    /// What was written down, newest first.
    pub fn list(&self, ui: &mut Ui) {
        egui::ScrollArea::vertical().id_salt("notes").auto_shrink([false, true]).show(ui, |ui| {
            for (at_s, words) in &self.written {
                ui.horizontal_wrapped(|ui| {
                    ui.label(RichText::new(time(*at_s)).monospace().size(12.0).color(theme::DIM));
                    ui.label(RichText::new(words).size(13.0));
                });
            }
        });
    }

    fn write(&mut self, time_s: f64, commands: &mut Vec<ExperimenterCommand>) {
        let text = std::mem::take(&mut self.text).trim().to_owned();
        self.say(time_s, &text);
        commands.push(ExperimenterCommand::Note(text));
    }
}
