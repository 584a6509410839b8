//! The gate: copies a document from an allow-list. In: the elements of a document, one after the other. Out: the
//! canonical document and what was dropped, or the first element that is refused. The copy has one element per line,
//! indented, and keeps the order of attributes. It has no comments, text, processing instructions or namespaces. A
//! canonical document passes again with the same bytes.

use super::{
    DECLARATION, Vocabulary, first_bad_character, is_plain,
    vocabulary::{PARAMETER, Rule},
    write_escaped,
};
use crate::toml_text::did_you_mean;
use std::{
    borrow::Cow,
    collections::BTreeMap,
    fmt,
    io::{self, Write},
};

/// Largest number of different names of dropped parts that are kept: a hostile file may have a million.
const MOST_DROPPED_NAMES: usize = 1000;
/// Number of names of dropped parts in a message.
const NAMES_SHOWN: usize = 3;
/// Largest length of a name in a message, characters.
const NAME_CHARACTERS: usize = 60;
const REMEDY: &str = "\n  remedy: remove it from the file";
/// Value for no projection.
const NO_PROJECTION: &str = "!";

/// Refused element and the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Element with its id, for example `edgeData "x"`.
    pub element: String,
    /// Problem, allowed values and remedy.
    pub problem: String,
}

/// Error that prevented the copy of a document.
#[derive(Debug)]
pub enum GateError {
    /// An element is refused.
    Refused(Problem),
    /// The copy cannot be written.
    Write(io::Error),
}

impl From<Problem> for GateError {
    fn from(problem: Problem) -> Self {
        Self::Refused(problem)
    }
}

impl From<io::Error> for GateError {
    fn from(error: io::Error) -> Self {
        Self::Write(error)
    }
}

/// Dropped parts without effect on a drive, by name, with their numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Dropped(BTreeMap<String, usize>);

impl Dropped {
    fn add(&mut self, name: impl FnOnce() -> String) {
        let name = if self.0.len() < MOST_DROPPED_NAMES { name() } else { "others".into() };
        *self.0.entry(name).or_default() += 1;
    }

    /// Checks whether nothing was dropped.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns names and numbers of the dropped parts, sorted by name.
    pub fn names(&self) -> impl Iterator<Item = (&str, usize)> {
        self.0.iter().map(|(name, count)| (name.as_str(), *count))
    }
}

impl fmt::Display for Dropped {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let mut names: Vec<(&str, usize)> = self.names().collect();
        names.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let shown: Vec<String> = names.iter().take(NAMES_SHOWN).map(|(name, n)| format!("{n} x {name}")).collect();
        f.write_str(&shown.join(", "))?;
        match names.len().saturating_sub(NAMES_SHOWN) {
            0 => Ok(()),
            more => write!(f, " and {more} other names"),
        }
    }
}

/// Open element of the copy.
struct Open<'v> {
    /// Rule of the element; `None` for a parameter, for an element that is left out, and for all within them.
    rule: Option<&'v Rule>,
    has_children: bool,
    /// True for an element that is left out, and for all within it.
    is_omitted: bool,
}

/// Copier of one document.
pub struct Gate<'v, W> {
    vocabulary: &'v Vocabulary,
    out: W,
    open: Vec<Open<'v>>,
    is_begun: bool,
    /// True to drop parts that name files, outputs or devices of SUMO, or that write; false to refuse the document for them.
    pub is_lenient: bool,
    /// Parts that were dropped so far.
    pub dropped: Dropped,
}

impl<'v, W: Write> Gate<'v, W> {
    /// Creates a gate that writes its copy to `out`.
    pub fn new(vocabulary: &'v Vocabulary, out: W) -> Self {
        Self { vocabulary, out, open: Vec::new(), is_begun: false, is_lenient: false, dropped: Dropped::default() }
    }

    /// Processes the start of an element: its name, and the names and values of its attributes.
    ///
    /// # Errors
    /// The element is refused, or cannot be written.
    pub fn open<'a>(
        &mut self,
        name: &str,
        attributes: impl Iterator<Item = (&'a str, &'a str)> + Clone,
    ) -> Result<(), GateError> {
        let is_within_omitted = self.is_omitting();
        let is_omitted = self.open.len() == 1 && self.vocabulary.omits(name) || self.is_lenient && is_writer(name);
        if is_within_omitted || is_omitted && self.vocabulary.rule(name).is_none() {
            if !is_within_omitted {
                self.dropped.add(|| short(name));
            }
            self.open.push(Open { rule: None, has_children: false, is_omitted: true });
            return Ok(());
        }
        let parent = self.open.last().map_or("", |open| open.rule.map_or(PARAMETER, |rule| rule.name));
        if name == PARAMETER && parent != PARAMETER && !parent.is_empty() {
            return self.parameter(attributes);
        }
        let vocabulary = self.vocabulary;
        let is_root = self.open.is_empty() && vocabulary.other_roots.contains(&name);
        let rule = vocabulary.rule(if is_root { vocabulary.root } else { name });
        let Some(rule) = rule.filter(|rule| rule.may_stand_in(parent) && !(parent.is_empty() && self.is_begun)) else {
            return Err(misplaced(vocabulary, name, parent, attributes).into());
        };
        self.begin(rule.name)?;
        for (key, value) in attributes.clone() {
            match passes(rule, key, value) {
                Pass::Value(kept) => {
                    if !is_plain(&kept) && first_bad_character(&kept).is_some() {
                        let problem = format!("{key} contains a control character, which XML does not allow{REMEDY}");
                        return Err(Problem { element: label(name, attributes), problem }.into());
                    }
                    for piece in [" ", key, "=\""] {
                        self.out.write_all(piece.as_bytes())?;
                    }
                    write_escaped(&mut self.out, &kept)?;
                    self.out.write_all(b"\"")?;
                    if kept != value {
                        self.dropped.add(|| format!("{key} with grids or files of {name}"));
                    }
                }
                Pass::Dropped => self.dropped.add(|| format!("{} of {name}", short(key))),
                Pass::Refused if self.is_lenient => self.dropped.add(|| format!("{} of {name}", short(key))),
                Pass::Refused => {
                    let problem = format!(
                        "attribute {} names a file, an output or a device of SUMO; codrive passes none to SUMO{REMEDY}",
                        short(key)
                    );
                    return Err(Problem { element: label(name, attributes), problem }.into());
                }
            }
        }
        self.open.push(Open { rule: Some(rule), has_children: false, is_omitted: false });
        Ok(())
    }

    /// Processes the end of the element that was opened last.
    ///
    /// # Errors
    /// The copy cannot be written.
    pub fn close(&mut self) -> Result<(), GateError> {
        let Some(Open { rule: Some(rule), has_children, .. }) = self.open.pop() else { return Ok(()) };
        if !has_children {
            return Ok(self.out.write_all(b"/>\n")?);
        }
        for piece in [indent(self.open.len()), "</", rule.name, ">\n"] {
            self.out.write_all(piece.as_bytes())?;
        }
        Ok(())
    }

    /// Returns the number of open elements: 1 within the outermost one.
    pub fn depth(&self) -> usize {
        self.open.len()
    }

    /// Returns the writer of the copy.
    pub fn writer(&mut self) -> &mut W {
        &mut self.out
    }

    /// Returns true within an element that is left out.
    pub fn is_omitting(&self) -> bool {
        self.open.last().is_some_and(|open| open.is_omitted)
    }

    /// Returns the writer and the dropped parts, at the end of the document.
    pub fn into_inner(self) -> (W, Dropped) {
        (self.out, self.dropped)
    }

    /// Writes the start of an element up to its attributes.
    fn begin(&mut self, name: &str) -> io::Result<()> {
        if !self.is_begun {
            self.out.write_all(DECLARATION.as_bytes())?;
            self.is_begun = true;
        }
        if let Some(parent) = self.open.last_mut().filter(|parent| !parent.has_children) {
            parent.has_children = true;
            self.out.write_all(b">\n")?;
        }
        for piece in [indent(self.open.len()), "<", name] {
            self.out.write_all(piece.as_bytes())?;
        }
        Ok(())
    }

    fn parameter<'a>(&mut self, attributes: impl Iterator<Item = (&'a str, &'a str)> + Clone) -> Result<(), GateError> {
        let rule = self.open.last().and_then(|open| open.rule);
        let value = |name: &str| attributes.clone().find(|(key, _)| *key == name).map_or("", |(_, value)| value);
        let (key, value) = (value("key"), value("value"));
        if rule.is_some_and(|rule| rule.has_key(key))
            && first_bad_character(key).or(first_bad_character(value)).is_none()
        {
            self.begin(PARAMETER)?;
            self.out.write_all(b" key=\"")?;
            write_escaped(&mut self.out, key)?;
            self.out.write_all(b"\" value=\"")?;
            write_escaped(&mut self.out, value)?;
            self.out.write_all(b"\"/>\n")?;
        } else if speaks_of_files(key) && !self.is_lenient {
            let problem =
                "the parameter names a file, an output or a device of SUMO, which can write to any file; codrive \
                 passes none to SUMO"
                    .to_owned()
                    + REMEDY;
            return Err(Problem { element: label(PARAMETER, attributes), problem }.into());
        } else {
            let parent = rule.map_or(PARAMETER, |rule| rule.name);
            self.dropped.add(|| format!("param {} of {parent}", short(key)));
        }
        self.open.push(Open { rule: None, has_children: false, is_omitted: false });
        Ok(())
    }
}

/// Returns the spaces before an element.
fn indent(depth: usize) -> &'static str {
    const SPACES: &str = "                                        ";
    &SPACES[..SPACES.len().min(4 * depth)]
}

/// Decision on an attribute.
pub enum Pass<'a> {
    /// The attribute passes, possibly with another value.
    Value(Cow<'a, str>),
    /// The attribute is dropped.
    Dropped,
    /// The document is refused.
    Refused,
}

/// Decides on an attribute of an element.
pub fn passes<'a>(rule: &Rule, name: &str, value: &'a str) -> Pass<'a> {
    match () {
        () if rule.has_attribute(name) => Pass::Value(match name {
            "projParameter" if !is_plain_projection(value) => NO_PROJECTION.into(),
            _ => value.into(),
        }),
        // A calibrator counts its vehicles into this file, and reads nothing from it.
        () if rule.name == "calibrator" && name == "output" => Pass::Dropped,
        () if speaks_of_files(name) => Pass::Refused,
        () => Pass::Dropped,
    }
}

/// Checks whether a key or an attribute names a file, an output or a device. Any other unknown one has no effect.
fn speaks_of_files(key: &str) -> bool {
    const WORDS: [&str; 6] = ["device", "devices", "file", "files", "output", "outputs"];
    words_of(key).iter().any(|word| WORDS.contains(&word.as_str()))
}

/// Splits a key into words in small letters, at characters that are not alphanumeric and before capital letters.
fn words_of(key: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    for c in key.chars() {
        if !c.is_alphanumeric() || c.is_uppercase() && words.last().is_some_and(|word| !word.is_empty()) {
            words.push(String::new());
        }
        if let (true, Some(word)) = (c.is_alphanumeric(), words.last_mut()) {
            word.extend(c.to_lowercase());
        }
    }
    words
}

/// Checks whether a projection consists of numbers and plain words. Grids, `+init` and others name files, which the
/// projection library reads.
fn is_plain_projection(value: &str) -> bool {
    const PARAMETERS: &str = "proj zone south ellps datum units no_defs type lat_0 lat_1 lat_2 lat_ts lon_0 lon_1 lon_2 lonc k k_0 x_0 y_0 a b rf f \
                              R gamma alpha towgs84 vunits axis pm over to_meter";
    let plain = |c: char| c.is_ascii_alphanumeric() || "._,+-".contains(c);
    let parameter = |word: &str| {
        let (name, value) = word.split_once('=').unwrap_or((word, ""));
        name.strip_prefix('+').is_some_and(|name| PARAMETERS.split_whitespace().any(|known| known == name))
            && value.chars().all(plain)
    };
    matches!(value.trim(), "!" | "-" | ".") || value.split_whitespace().all(parameter)
}

fn misplaced<'a>(
    vocabulary: &Vocabulary,
    name: &str,
    parent: &str,
    attributes: impl Iterator<Item = (&'a str, &'a str)>,
) -> Problem {
    let element = label(name, attributes);
    let within = vocabulary.within(parent);
    let allowed = match within.as_slice() {
        [] => "nothing but param".to_owned(),
        names => names.join(", "),
    };
    let place = if parent.is_empty() { "as the outermost element".to_owned() } else { format!("in <{parent}>") };
    let problem = match vocabulary.rule(name) {
        Some(_) => format!("the element is in the wrong place; allowed {place}: {allowed}{REMEDY}"),
        None if is_writer(name) => {
            format!(
                "SUMO writes or reads files for this element, or changes the traffic by it; codrive does not pass it \
                 to SUMO{REMEDY}"
            )
        }
        None => {
            let near = did_you_mean(name, &within);
            format!("unknown element in {}{near}; allowed {place}: {allowed}{REMEDY}", vocabulary.title)
        }
    };
    Problem { element, problem }
}

/// Checks for elements of SUMO's additional files that write, read or control the traffic.
fn is_writer(name: &str) -> bool {
    const WRITERS: &str = "edgeData laneData timedEvent e1Detector inductionLoop e2Detector laneAreaDetector e3Detector entryExitDetector \
                           instantInductionLoop vTypeProbe routeProbe calibrator rerouter variableSpeedSign vaporizer include WAUT \
                           wautJunction chargingStation overheadWireSegment overheadWire tractionSubstation";
    WRITERS.split_whitespace().any(|writer| writer == name)
}

/// Returns an element's name with its id, key or file.
pub fn label<'a>(name: &str, mut attributes: impl Iterator<Item = (&'a str, &'a str)>) -> String {
    let by = if name == PARAMETER { "key" } else { "id" };
    let known = attributes.find(|(key, _)| *key == by || *key == "href");
    known.map_or_else(|| short(name), |(_, value)| format!("{} \"{}\"", short(name), short(value)))
}

/// Shortens a name for a message, without control characters.
fn short(name: &str) -> String {
    let mut text: String = name.chars().filter(|c| !c.is_control()).take(NAME_CHARACTERS).collect();
    if name.chars().count() > NAME_CHARACTERS {
        text.push_str("...");
    }
    text
}
