//! Sentences of the report about drives on networks. In: analysed drives. Out: text.

use super::setup_facts::{SetupValue, joined_values};
use crate::analysis::{drives::AnalysedRecording, measures::MEASURES, text::joined_with_and};
use crate::metrics::{MeasuredOn, RoadKinds};

/// Returns the sentence on measures of closed routes that networks lack; empty if there are closed routes.
pub fn not_measured(roads: RoadKinds) -> String {
    if roads.closed || !roads.networks {
        return String::new();
    }
    let on_rings = MEASURES.iter().filter(|measure| matches!(measure.on, MeasuredOn::ClosedRoutes(_)));
    let titles: Vec<String> = on_rings.map(|measure| measure.title.to_owned()).collect();
    format!(
        " Not measured on networks, for reasons given in the <a href=\"#data-dictionary\">data dictionary</a>: {}.",
        joined_with_and(&titles)
    )
}

/// Returns the sentences on road and traffic of drives on networks, for the methods; empty without any.
pub fn traffic(drives: &[&AnalysedRecording]) -> String {
    let drives: Vec<&&AnalysedRecording> = drives.iter().filter(|drive| drive.network.is_some()).collect();
    if drives.is_empty() {
        return String::new();
    }
    let values = |of: &dyn Fn(&AnalysedRecording) -> SetupValue| joined_values(drives.iter().map(|drive| of(drive)));
    let lengths = drives.iter().map(|drive| drive.setup.route_m).filter(|length_m| *length_m > 0.0);
    let lengths = joined_values(lengths.map(|length_m| SetupValue::Number(length_m.round(), "m")));
    let path = if lengths.is_empty() { String::new() } else { format!(", along a path of {lengths}") };
    let mut text = format!(
        "The ego vehicle drove on the road network {}{path}. The traffic was computed by {}; vehicles entered and \
         left, {} in each drive.",
        values(&|drive| SetupValue::Word(drive.setup.road())),
        values(&|drive| SetupValue::Word(drive.setup.manifest.traffic.replace(" in process", ", run within codrive"))),
        values(&|drive| SetupValue::Number(drive.network.as_ref().map_or(0.0, |network| network.vehicles as f64), "")),
    );
    text += &format!(
        " The traffic ran for {} before the drive, and then until there was room for the ego vehicle. All vehicles \
         were recorded once a second; vehicles within 100 m of the ego vehicle were recorded at every step.",
        values(&|drive| SetupValue::Number(drive.setup.scenario.warm_up_s, "s"))
    );
    let lines: Vec<String> = {
        let each = drives.iter().flat_map(|drive| drive.network.iter().flat_map(|network| &network.lines));
        let mut names: Vec<String> = each.map(|count| count.line.name.clone()).collect();
        names.sort();
        names.dedup();
        names
    };
    if !lines.is_empty() {
        text += &format!(
            " Throughput was counted at {} (edge or lane, and metres from its start).",
            joined_with_and(&lines)
        );
    }
    text
}
