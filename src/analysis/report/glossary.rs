//! Definitions of all columns, as the tables declare them. In: analysed drives. Out: for each column of each table the quantity
//! in words, its unit and its definition; the data dictionary.

use crate::analysis::{
    columns::{ColumnDefinition, TableColumns},
    drives::{AnalysedRecording, road_kinds},
    tables as csv,
};
use serde_json::{Map, Value, json};

/// Returns all tables with their columns, for these drives.
pub fn tables(drives: &[AnalysedRecording]) -> Vec<TableColumns> {
    let mut tables = vec![
        csv::trials_columns(drives),
        csv::advice_columns(drives),
        csv::response_times_columns(),
        csv::speed_columns(drives),
        csv::by_condition_columns(),
        csv::drivers_columns(),
        csv::scores_columns(),
        csv::sickness_columns(),
    ];
    if csv::have_events(drives) {
        tables.push(csv::event_columns(drives));
    }
    if road_kinds(drives).networks {
        tables.extend([csv::trips_columns(drives), csv::lines_columns(drives)]);
    }
    tables
}

/// Returns the data dictionary as JSON: the columns of each table, with the keys of BIDS.
pub fn dictionary(drives: &[AnalysedRecording]) -> String {
    let table = |table: TableColumns| {
        let columns: Map<String, Value> = table.columns.into_iter().map(ColumnDefinition::entry).collect();
        (table.file.to_owned(), json!({ "Row": table.row, "Columns": columns }))
    };
    let all: Map<String, Value> = tables(drives).into_iter().map(table).collect();
    format!("{:#}\n", Value::Object(all))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{data::StudyParticipants, drives::test_drives::mixed_drives, responses::ScriptedResponse};

    #[test]
    fn every_column_has_a_title_and_a_definition_in_the_dictionary() {
        let mut drives = mixed_drives();
        drives[0].scripted_responses.push(ScriptedResponse::default());
        let written = [
            ("trials.csv", csv::trials(&drives)),
            ("advice.csv", csv::advice(&drives)),
            ("reactions.csv", csv::response_times(&drives)),
            (csv::EVENTS_FILE, csv::events(&drives)),
            ("speed.csv", csv::speed(&drives)),
            ("conditions.csv", csv::by_condition(&drives)),
            ("drivers.csv", csv::drivers(&[])),
            ("scores.csv", csv::scores(&StudyParticipants::default())),
            ("fms.csv", csv::sickness(&StudyParticipants::default())),
            ("trips.csv", csv::trips(&drives)),
            ("lines.csv", csv::lines(&drives)),
        ];
        let dictionary: Value = serde_json::from_str(&dictionary(&drives)).unwrap();
        assert_eq!(dictionary.as_object().unwrap().len(), written.len());
        let tables = tables(&drives);
        for (file, text) in written {
            let head: Vec<&str> = text.lines().next().unwrap().split(',').collect();
            assert!(head.len() >= 6, "{file}: {head:?}");
            let of = tables.iter().find(|table| table.file == file).unwrap();
            assert_eq!(of.columns.iter().map(|column| column.name.as_str()).collect::<Vec<_>>(), head, "{file}");
            for column in &of.columns {
                let entry = &dictionary[file]["Columns"][&column.name];
                assert_eq!(entry["LongName"], column.title.as_str());
                assert_eq!(entry.get("Units").and_then(Value::as_str).unwrap_or_default(), column.unit);
                // Words, not the name again, and no other column's name within a definition.
                assert!(column.title.chars().next().is_some_and(|sign| !sign.is_lowercase()), "{column:?}");
                assert!(
                    column.about.len() > 5 && !column.about.contains('_') && !column.title.contains('_'),
                    "{column:?}"
                );
                let has_unit =
                    column.name.ends_with("_s") || column.name.ends_with("_mps") || column.name.ends_with("_m");
                assert!(!has_unit || !column.unit.is_empty(), "{column:?}");
            }
        }
    }

    #[test]
    fn the_page_of_results_is_the_dictionary() {
        let mut drives = mixed_drives();
        drives[0].scripted_responses.push(ScriptedResponse::default());
        let mut page = "# Tables of an analysis\n\n**Goal:** look up each column of the tables that `codrive analyse` writes, with unit and definition.\n\n\
            Tables are CSV files; `columns.json` beside them has these definitions for the drives of the analysis. Columns that only some drives have are \
            listed, too: of networks, of secondary tasks, of takeover requests. [Measures](../measures.md) names the sources.\n"
            .to_owned();
        for table in tables(&drives) {
            page += &format!(
                "\n## `{}`\n\nOne row for {}.\n\n| column | quantity | unit | definition |\n|---|---|---|---|\n",
                table.file, table.row
            );
            for column in table.columns {
                page += &format!(
                    "| `{}` | {} | {} | {} |\n",
                    column.name,
                    column.title,
                    column.unit,
                    column.about.replace('|', "\\|")
                );
            }
        }
        expect_test::expect_file!["../../../docs/reference/analysis-tables.md"].assert_eq(&page);
    }
}
