//! Kinds of files, so that a file of one kind is not read as another. In: a document, a message of serde on an unknown key. Out: the message
//! that names the kind of the file and the command that reads it.

use super::tree::{self, KeyPart, Node};

/// Keys by which a kind of file is known, with its name and its use.
const KINDS: [(&str, &str, &str); 11] = [
    ("segment", "a study", "codrive study check FILE"),
    ("layer", "a policy", "--policy FILE"),
    ("vehicles_min", "the configuration of a training", "codrive train --config FILE"),
    ("drives", "the plan of a sweep", "codrive sweep FILE"),
    ("trainings", "the plan of a sweep", "codrive sweep FILE"),
    ("rehearsals", "the plan of a sweep", "codrive sweep FILE"),
    ("accelerator", "the profile of a wheel", "codrive drive --wheel FILE"),
    ("piece", "the shape of a circuit", "codrive map circuit FILE"),
    ("description", "the description of a map", "--map FOLDER"),
    ("map", "a scenario", "codrive run --scenario FILE"),
    ("vehicles", "a scenario", "codrive run --scenario FILE"),
];

/// Beginnings of the key `format` by which a kind of file is known, with its name and its use.
pub(super) const FORMATS: [(&str, &str, &str); 4] = [
    ("codrive benchmark ", "a benchmark", "codrive evaluate --benchmark FILE"),
    ("codrive policy ", "a policy", "--policy FILE"),
    ("codrive controller ", "a policy", "--policy FILE"),
    ("codrive drivers ", "the drivers of an analysis", "codrive study rehearse STUDY --drivers FILE"),
];

/// Returns the message on an unknown key of a document that is a file of another kind; `message` is that of serde.
pub(super) fn kind_of(document: &Node<'_>, message: &str) -> Option<String> {
    let (key, rest) = message.strip_prefix("unknown field `")?.split_once('`')?;
    let has = |key: &str| tree::span_of(document, &[key.to_owned()], KeyPart::Key).1;
    let is_known = |mark: &str| rest.contains(&format!("`{mark}`"));
    let (_, what, way) = KINDS.iter().find(|(mark, ..)| has(mark) && has(key) && !is_known(mark))?;
    Some(format!("unknown key `{key}`: the file is {what}\n  remedy: {way}"))
}
