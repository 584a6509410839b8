//! The scenario's settings in the panel: the `editor`, and its `presets`. In: a scenario. Out: an edited one.

mod editor;
mod presets;

pub use editor::{ScenarioEditor, SettingChoices};
pub use presets::{PresetError, PresetList};
