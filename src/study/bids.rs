//! Tables and sidecars for BIDS (`beh`, version 1.10): tab-separated, `n/a` for missing cells, every column described in JSON with its
//! unit, levels and tags. In: rows. Out: text, and the descriptions of a data set and its derivatives.

use serde_json::{Map, Value, json};

/// Maximum size of a table, bytes.
pub(super) const TABLE_BYTES: u64 = 64 << 20;

/// Column of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TsvColumn {
    pub name: String,
    /// Meaning, for the sidecar.
    pub about: String,
    /// Unit symbol; empty if the column has none.
    pub unit: String,
    /// Values of the column and their meanings.
    pub levels: Vec<(String, String)>,
    /// HED tags: a string with # in place of the value, or an object with one string per level; null for none.
    pub tags: Value,
}

impl TsvColumn {
    /// Creates a column without levels.
    pub fn new(name: &str, about: &str, unit: &str) -> Self {
        Self { name: name.into(), about: about.into(), unit: unit.into(), ..Self::default() }
    }

    /// Returns the column with these levels.
    #[must_use]
    pub fn with(mut self, levels: impl IntoIterator<Item = (String, String)>) -> Self {
        self.levels = levels.into_iter().collect();
        self
    }

    /// Returns the column with these HED tags.
    #[must_use]
    pub fn tagged(mut self, tags: Value) -> Self {
        self.tags = tags;
        self
    }
}

/// Table with described columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TsvTable {
    /// Columns, left to right.
    pub columns: Vec<TsvColumn>,
    /// Rows with one cell per column; an empty cell is written as `n/a`.
    pub rows: Vec<Vec<String>>,
}

impl TsvTable {
    /// Creates a table without rows.
    pub fn new(columns: Vec<TsvColumn>) -> Self {
        Self { columns, rows: Vec::new() }
    }

    /// Returns the table as tab-separated text with a header line.
    pub fn text(&self) -> String {
        let names: Vec<String> = self.columns.iter().map(|c| c.name.clone()).collect();
        let line = |cells: &Vec<String>| {
            let cells: Vec<String> = cells.iter().map(|cell| cell_text(cell)).collect();
            cells.join("\t") + "\n"
        };
        std::iter::once(&names).chain(&self.rows).map(line).collect()
    }

    /// Returns the sidecar of the table; the entries of `more` come first.
    pub fn sidecar(&self, more: Value) -> String {
        let mut out = more.as_object().cloned().unwrap_or_default();
        for column in &self.columns {
            let mut about = Map::new();
            about.insert("Description".into(), column.about.clone().into());
            if !column.unit.is_empty() {
                about.insert("Units".into(), column.unit.clone().into());
            }
            if !column.levels.is_empty() {
                let levels = column.levels.iter().map(|(word, text)| (word.clone(), text.clone().into()));
                about.insert("Levels".into(), Value::Object(levels.collect()));
            }
            if !column.tags.is_null() {
                about.insert("HED".into(), column.tags.clone());
            }
            out.insert(column.name.clone(), about.into());
        }
        format!("{:#}\n", Value::Object(out))
    }
}

/// Checks whether some readers split lines at a character: a control character or a separator of lines.
fn parts_lines(c: char) -> bool {
    c.is_control() || "\u{2028}\u{2029}".contains(c)
}

fn cell_text(cell: &str) -> String {
    if cell.is_empty() { "n/a".into() } else { cell.replace(parts_lines, " ") }
}

/// Escapes a text for use within a line of Markdown, so that it contains no markup.
pub fn markdown(text: &str) -> String {
    let mut plain = String::new();
    for c in text.chars() {
        if "\\`*_[]<>&~|$#".contains(c) {
            plain.push('\\');
        }
        plain.push(if parts_lines(c) { ' ' } else { c });
    }
    plain
}

/// Formats a number as a cell; missing or not finite gives an empty cell.
pub fn number(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or(String::new(), |v| v.to_string())
}

/// Formats a JSON value as a cell: strings without quotes, lists joined by semicolons.
pub fn value(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(word) => word.clone(),
        Value::Array(list) => list.iter().map(self::value).collect::<Vec<_>>().join(";"),
        other => other.to_string(),
    }
}

/// Converts a name of the study to a BIDS label, which has only letters and digits: `ssq-before` becomes `ssqBefore`.
pub fn label(name: &str) -> String {
    let mut parts = name.split('-');
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |label, part| {
        let mut chars = part.chars();
        let head = chars.next().map(|c| c.to_ascii_uppercase());
        label + &head.into_iter().chain(chars).collect::<String>()
    })
}

/// Version of BIDS that data sets follow.
pub const VERSION: &str = "1.10.0";

/// Returns the facts of a task for a sidecar.
pub fn task(name: &str, description: &str, instructions: &str, institution: Option<&str>) -> Value {
    let mut facts = json!({
        "TaskName": name,
        "TaskDescription": description,
        "Instructions": if instructions.is_empty() { "none" } else { instructions },
        "StimulusPresentation": {
            "SoftwareName": "codrive",
            "SoftwareVersion": env!("CARGO_PKG_VERSION"),
        },
    });
    if let Some(institution) = institution {
        facts["InstitutionName"] = institution.into();
    }
    facts
}

/// Returns name and text of the files that make the folder of an analysis a BIDS derivative. `title` is the study's.
pub fn derived(title: &str) -> [(&'static str, String); 3] {
    let about = json!({
        "Name": format!("{title}: measures by codrive"),
        "BIDSVersion": VERSION,
        "DatasetType": "derivative",
        "GeneratedBy": [{
            "Name": "codrive",
            "Version": env!("CARGO_PKG_VERSION"),
            "Description": "codrive analyse: measures of every drive (columns.json defines them), figures, report",
        }],
        // Data set that contains this folder.
        "SourceDatasets": [{ "URL": "../../" }],
    });
    let title = markdown(title);
    let readme = format!(
        "# {title}: measures by codrive\n\n\
         Results of `codrive analyse` for the data set two folders above. Run it again to renew them.\n\n\
         * `trials.csv`: one row per drive. `columns.json` defines the columns of all tables.\n\
         * `report.html`, `methods.txt`, `figures/`: the report.\n"
    );
    // CSV tables, figures and the report are not BIDS files.
    let ignored = "*.csv\n*.html\n*.txt\n*.toml\n*.svg\n*.png\ncolumns.json\nmodels.json\nfigures\n";
    [("dataset_description.json", format!("{about:#}\n")), ("README.md", readme), (".bidsignore", ignored.into())]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_stay_on_one_line_and_missing_cells_are_n_a() {
        let mut table = TsvTable::new(vec![TsvColumn::new("a", "first", "s"), TsvColumn::new("b", "second", "")]);
        table.rows.push(vec!["1\t2\n3\u{2028}\u{b}4".into(), String::new()]);
        assert_eq!(table.text(), "a\tb\n1 2 3  4\tn/a\n");
        let sidecar: Value = serde_json::from_str(&table.sidecar(json!({ "TaskName": "x" }))).unwrap();
        assert_eq!(
            sidecar,
            json!({"TaskName": "x", "a": {"Description": "first", "Units": "s"}, "b": {"Description": "second"}})
        );
        assert_eq!((label("ssq-before"), label("trial")), ("ssqBefore".into(), "trial".into()));
        assert_eq!(value(&json!(["a", 2])), "a;2");
    }

    #[test]
    fn no_character_of_a_text_is_markup_of_markdown() {
        assert_eq!(markdown("Driving in Zürich, 5 to 7: why?"), "Driving in Zürich, 5 to 7: why?");
        assert_eq!(
            markdown("<b>*x*</b> [a](http://b) `c` #d\n\u{1b}"),
            "\\<b\\>\\*x\\*\\</b\\> \\[a\\](http://b) \\`c\\` \\#d  "
        );
        assert_eq!(markdown("a - b_c! 1. | ~x &amp;"), "a - b\\_c! 1. \\| \\~x \\&amp;");
    }

    #[test]
    fn missing_numbers_are_empty_and_strings_have_no_quotes() {
        assert_eq!(number(Some(2.5)), "2.5");
        for none in [None, Some(f64::NAN), Some(f64::INFINITY)] {
            assert_eq!(number(none), "");
        }
        assert_eq!([Value::Null, json!("a b"), json!(true), json!(2.5)].map(|v| value(&v)), ["", "a b", "true", "2.5"]);
        let with = TsvColumn::new("a", "first", "").with([("x".to_owned(), "an x".to_owned())]);
        let sidecar: Value = serde_json::from_str(&TsvTable::new(vec![with]).sidecar(Value::Null)).unwrap();
        assert_eq!(sidecar, json!({"a": {"Description": "first", "Levels": {"x": "an x"}}}));
        let sidecar = task("trial", "Driving", "", None);
        assert_eq!((&sidecar["TaskName"], &sidecar["Instructions"]), (&json!("trial"), &json!("none")));
        assert_eq!(task("trial", "Driving", "Go.", None)["Instructions"], "Go.");
        assert!(sidecar["InstitutionName"].is_null());
        assert_eq!(task("trial", "Driving", "", Some("A laboratory"))["InstitutionName"], "A laboratory");
        assert_eq!(sidecar["StimulusPresentation"]["SoftwareName"], "codrive");
    }
}
