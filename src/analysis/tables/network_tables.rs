//! Tables of drives on networks. In: analysed drives. Out: `trips.csv` (a row per vehicle) and `lines.csv` (a row per line), with
//! their columns.

use super::key::{key, key_columns};
use crate::analysis::{
    columns::{ColumnTexts, TableColumns, cell, columns, line},
    data::{Trip, trips::seconds},
    drives::AnalysedRecording,
};
use crate::metrics::registry::measure;

/// File name of the table of vehicles.
pub const TRIPS_FILE: &str = "trips.csv";
/// File name of the table of lines.
pub const LINES_FILE: &str = "lines.csv";

/// Columns of the table of vehicles.
const TRIPS: [ColumnTexts; 8] = [
    ("vehicle", "Vehicle", "", "number of the vehicle, as in the tables of the recording"),
    ("kind", "Kind", "", "car, van, truck, bus, motorcycle or bicycle"),
    ("departure_s", "Departure", "s", "time of departure; empty if the vehicle was present before the drive began"),
    ("arrival_s", "Arrival", "s", "time of arrival; empty if the vehicle is still present at the end of the drive"),
    ("from_lane", "Departure lane", "", "id of the lane of departure, or of the lane at the start of the drive"),
    ("to_lane", "Arrival lane", "", "id of the lane of arrival; empty without an arrival"),
    ("travel_time_s", "Travel time", "s", "time from departure to arrival; empty if either is outside the drive"),
    (
        "time_loss_s",
        "Time lost",
        "s",
        "travel time minus the time for the same way at the speed limit of each lane; negative for a faster vehicle",
    ),
];
/// Columns of the table of lines.
const LINES: [ColumnTexts; 6] = [
    ("line", "Line", "", "id of the lane or the edge, and metres from its start"),
    (
        "chosen",
        "Choice",
        "",
        "asked: line named in the command; path: line across the street nearest to the middle of the ego vehicle's \
         path",
    ),
    ("passages", "Passages", "", "vehicles whose fronts passed the line, the ego vehicle included"),
    measure("duration_s").texts(),
    ("line_passages_per_h", "Passages an hour", "1/h", "passages an hour"),
    (
        "resolution_s",
        "Resolution",
        "s",
        "longest time between the two rows of a vehicle from which a passage was found",
    ),
];

/// Returns the columns of `trips.csv`.
pub(crate) fn trips_columns(drives: &[AnalysedRecording]) -> TableColumns {
    let columns = key_columns(drives).into_iter().chain(columns(&TRIPS)).collect();
    TableColumns { file: TRIPS_FILE, row: "a vehicle of a drive on a network, other than the ego vehicle", columns }
}

/// Returns the columns of `lines.csv`.
pub(crate) fn lines_columns(drives: &[AnalysedRecording]) -> TableColumns {
    let columns = key_columns(drives).into_iter().chain(columns(&LINES)).collect();
    TableColumns { file: LINES_FILE, row: "a line of a drive on a network", columns }
}

/// Returns `trips.csv`: a row per vehicle of each drive on a network.
pub fn trips(drives: &[AnalysedRecording]) -> String {
    let mut text = trips_columns(drives).head();
    for drive in drives {
        for (vehicle, trip) in drive.network.iter().flat_map(|network| &network.trips) {
            text += &line(key(drive).into_iter().chain(trip_cells(*vehicle, trip)));
        }
    }
    text
}

fn trip_cells(vehicle: u32, trip: &Trip) -> [String; 8] {
    let departure_s = (!trip.was_there_before()).then(|| seconds(trip.departed.tick));
    let arrived = trip.arrived.as_ref();
    [
        vehicle.to_string(),
        trip.kind.clone(),
        cell(departure_s),
        cell(arrived.map(|end| seconds(end.tick))),
        trip.departed.lane.clone(),
        arrived.map(|end| end.lane.clone()).unwrap_or_default(),
        cell(trip.travel_time_s()),
        cell(trip.time_loss_s),
    ]
}

/// Returns `lines.csv`: a row per line of each drive on a network.
pub fn lines(drives: &[AnalysedRecording]) -> String {
    let mut text = lines_columns(drives).head();
    for drive in drives {
        for count in drive.network.iter().flat_map(|network| &network.lines) {
            let hours = drive.duration_s / 3600.0;
            let own = [
                count.line.name.clone(),
                if count.line.is_default { "path" } else { "asked" }.into(),
                count.vehicles.to_string(),
                cell(Some(drive.duration_s)),
                cell((hours > 0.0).then(|| count.vehicles as f64 / hours)),
                cell((count.vehicles > 0).then_some(count.resolution_s)),
            ];
            text += &line(key(drive).into_iter().chain(own));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{
        drives::test_drives::mixed_drives,
        network::{LineCount, LinePlace},
    };
    use crate::map::network::Network;
    use std::path::Path;

    #[test]
    fn a_line_without_vehicles_has_no_time_between_rows() {
        let net = Network::load("tests/data/networks/grid-signals.net.xml").expect("a network");
        let place: LinePlace = "B0B1:30".parse().expect("a place");
        let mut drives = mixed_drives();
        let counted = &mut drives[0].network.as_mut().expect("a network").lines;
        counted.push(LineCount::new(place.resolve(&net, Path::new("p1")).expect("a line")));
        let text = lines(&drives[..1]);
        assert!(text.ends_with(",B0B1:30,asked,0,12,0,\n"), "{text}");
    }
}
