//! Marks and notes of the experimenter. In: a key or a button, a line of text. Out: commands to record them; the last
//! few stay in sight.

use super::ExperimenterCommand;
use crate::panel::{readout::time, theme};
use egui::{Key, RichText, TextEdit, Ui};

/// Number of entries that are kept.
const KEPT: usize = 50;

/// Marks and notes of this session.
#[derive(Clone, Debug, Default)]
pub struct SessionNotes {
    text: String,
    /// Newest first: time of the drive, s, and the text.
    written: Vec<(f64, String)>,
    marks: u32,
    /// True if the next pass focuses the text line.
    wants_focus: bool,
}

impl SessionNotes {
    /// Adds an entry to the list only, e.g. for a wheel unplugged or a recording that begins.
    pub fn add_note(&mut self, time_s: f64, words: &str) {
        self.written.insert(0, (time_s, words.to_owned()));
        self.written.truncate(KEPT);
    }

    /// Marks this moment and asks to record the mark.
    pub fn mark(&mut self, time_s: f64, commands: &mut Vec<ExperimenterCommand>) {
        commands.push(ExperimenterCommand::Mark(self.number(time_s)));
    }

    /// Lists a mark at this time, set here or elsewhere. Returns its number, from 1.
    pub fn number(&mut self, time_s: f64) -> u32 {
        self.marks += 1;
        self.add_note(time_s, &format!("mark {}", self.marks));
        self.marks
    }

    /// Focuses the line for notes in the next pass.
    pub fn focus(&mut self) {
        self.wants_focus = true;
    }

    /// Shows buttons, line and list.
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
            // Keep the focus for the next note.
            response.request_focus();
        }
        ui.add_space(4.0);
        self.list(ui);
    }

    /// Shows all entries, newest first.
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
        self.add_note(time_s, &text);
        commands.push(ExperimenterCommand::Note(text));
    }
}
