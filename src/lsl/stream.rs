//! Descriptions of streams. In: names, channels and units; or the XML of another device's stream. Out: a description in
//! the library, and a parsed one.

use super::{
    LslError,
    library::{self, Handle, Library, c_text, text},
};
use serde::Serialize;

/// Largest number of channels of a stream that is read: a row of a recording's block holds them.
pub const MOST_CHANNELS: usize = 4096;

/// Returns the XML with a replacement character for each control character, plain or as a numeric reference. XML
/// permits only tabs and line ends, and devices write others into names.
fn printable(xml: &str) -> String {
    let is_bad = |c: char| (c.is_control() && !"\t\n\r".contains(c)) || "\u{fffe}\u{ffff}".contains(c);
    let (mut clean, mut rest) = (String::with_capacity(xml.len()), xml);
    while let Some(at) = rest.find("&#") {
        clean += &rest[..at];
        let number = rest[at + 2..].split_once(';').map(|(number, _)| number).filter(|number| number.len() <= 8);
        let code = number.and_then(|number| match number.strip_prefix(['x', 'X']) {
            Some(hex) => u32::from_str_radix(hex, 16).ok(),
            None => number.parse().ok(),
        });
        match (number, code) {
            (Some(number), Some(code)) => {
                let is_good = char::from_u32(code).is_some_and(|c| !is_bad(c));
                clean += if is_good { &rest[at..at + 3 + number.len()] } else { "\u{fffd}" };
                rest = &rest[at + 3 + number.len()..];
            }
            _ => {
                clean += "&#";
                rest = &rest[at + 2..];
            }
        }
    }
    clean += rest;
    clean.replace(is_bad, "\u{fffd}")
}

/// Format of a stream's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelFormat {
    /// 64-bit floating-point numbers.
    Numbers,
    Texts,
}

impl ChannelFormat {
    /// Returns the format's number in lsl_c.h.
    fn code(self) -> i32 {
        match self {
            Self::Numbers => 2,
            Self::Texts => 3,
        }
    }
}

/// Channel of a stream.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Channel {
    /// Name of the channel.
    pub label: String,
    /// Unit of the values; empty if there is none or it is unknown.
    pub unit: String,
    /// Description of the channel in a sentence.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub about: String,
}

/// Description of a stream of this program.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamDescription {
    /// Name of the stream.
    pub name: String,
    /// Kind of content (`type` in LSL).
    pub content: String,
    /// Samples per second; 0 for irregular samples.
    pub rate_hz: f64,
    /// Format of the values.
    pub format: ChannelFormat,
    /// Identifier that stays the same for the same device, by which a recorder finds the stream again.
    pub source_id: String,
    /// Channels in the order of a sample's values.
    pub channels: Vec<Channel>,
}

/// Description in the library's memory.
pub(super) struct Info {
    pub library: &'static Library,
    pub handle: Handle,
}

// SAFETY: a description is plain data, and one thread at a time uses it.
unsafe impl Send for Info {}

impl Drop for Info {
    fn drop(&mut self) {
        // SAFETY: created by the library and destroyed once.
        unsafe { (self.library.destroy_info)(self.handle) }
    }
}

impl Info {
    pub fn xml(&self) -> String {
        // SAFETY: the handle is valid; the text is owned here until it is freed.
        unsafe {
            let xml = (self.library.info_xml)(self.handle);
            let words = text(xml);
            if !xml.is_null() {
                (self.library.destroy_string)(xml);
            }
            words
        }
    }
}

impl StreamDescription {
    pub(super) fn info(&self) -> Result<Info, LslError> {
        let library = library::open()?;
        let count = i32::try_from(self.channels.len()).unwrap_or(i32::MAX);
        let (name, content, source) = (c_text(&self.name), c_text(&self.content), c_text(&self.source_id));
        // SAFETY: the texts are valid for the call, which copies them.
        let handle = unsafe {
            let [name, content, source] = [&name, &content, &source].map(|text| text.as_ptr());
            (library.create_info)(name, content, count, self.rate_hz, self.format.code(), source)
        };
        if handle.is_null() {
            return Err(library.refused(&format!("the stream {}", self.name)));
        }
        let info = Info { library, handle };
        let add = |node: Handle, key: &str, value: &str| {
            let (key, value) = (c_text(key), c_text(value));
            // SAFETY: the node belongs to the description above.
            unsafe { (library.append_value)(node, key.as_ptr(), value.as_ptr()) };
        };
        // SAFETY: as above; an element of a description is never null.
        let desc = unsafe { (library.desc)(info.handle) };
        add(desc, "manufacturer", "codrive");
        add(desc, "version", env!("CARGO_PKG_VERSION"));
        let channels = unsafe { (library.append_child)(desc, c"channels".as_ptr()) };
        for channel in &self.channels {
            let node = unsafe { (library.append_child)(channels, c"channel".as_ptr()) };
            add(node, "label", &channel.label);
            add(node, "unit", &channel.unit);
            add(node, "type", &self.content);
            add(node, "description", &channel.about);
        }
        Ok(info)
    }
}

/// Description of a stream of another device.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FoundStream {
    /// Name of the stream.
    pub name: String,
    /// Kind of content (`type` in LSL).
    #[serde(rename = "type")]
    pub content: String,
    /// Samples per second; 0 for irregular samples.
    pub nominal_srate: f64,
    /// Format of the values as LSL names it: float32, double64, string, int32, int16, int8, int64.
    pub channel_format: String,
    /// Identifier that the device gives itself; may be empty.
    pub source_id: String,
    /// Name of the computer that sends the stream.
    pub hostname: String,
    /// Identifier of this run of the device's program.
    pub uid: String,
    /// Time of the stream's creation, s on the clock of its computer.
    pub created_at: f64,
    /// Channels of the stream; without names if the device gives none.
    pub channels: Vec<Channel>,
    /// Complete description as XML.
    pub xml: String,
}

impl std::fmt::Display for FoundStream {
    /// Writes a short description by which a person can identify the stream.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let rate = if self.nominal_srate > 0.0 { format!("{} Hz", self.nominal_srate) } else { "irregular".into() };
        write!(
            f,
            "name='{}' type='{}' source_id='{}' ({} channels, {rate}, on {})",
            self.name,
            self.content,
            self.source_id,
            self.channels.len(),
            self.hostname
        )
    }
}

impl FoundStream {
    /// Parses a description.
    ///
    /// # Errors
    /// The text is no XML of a stream, or the stream has too many channels.
    pub fn parse(xml: &str) -> Result<Self, LslError> {
        let bad = |why: String| LslError::Refused { what: "the description of a stream".into(), why };
        let xml = printable(xml);
        let document = roxmltree::Document::parse(&xml).map_err(|error| bad(error.to_string()))?;
        let root = document.root_element();
        let child = |node: roxmltree::Node, key: &str| {
            let found = node.children().find(|child| child.has_tag_name(key));
            found.and_then(|child| child.text()).unwrap_or_default().trim().to_owned()
        };
        let field = |key: &str| child(root, key);
        let count: usize = field("channel_count").parse().map_err(|_| bad("it has no channel_count".into()))?;
        let named = root.descendants().find(|node| node.has_tag_name("channels"));
        let mut channels: Vec<Channel> = named
            .into_iter()
            .flat_map(|node| node.children().filter(|child| child.has_tag_name("channel")))
            .map(|node| Channel { label: child(node, "label"), unit: child(node, "unit"), about: String::new() })
            .take(count)
            .collect();
        if count > MOST_CHANNELS {
            return Err(LslError::TooWide { name: field("name"), channels: count, most: MOST_CHANNELS });
        }
        channels.resize_with(count, Channel::default);
        let found = Self {
            name: field("name"),
            content: field("type"),
            nominal_srate: field("nominal_srate").parse().unwrap_or(0.0),
            channel_format: field("channel_format"),
            source_id: field("source_id"),
            hostname: field("hostname"),
            uid: field("uid"),
            created_at: field("created_at").parse().unwrap_or(0.0),
            channels,
            xml: String::new(),
        };
        Ok(Self { xml, ..found })
    }

    /// Checks whether the values are texts.
    pub fn is_text(&self) -> bool {
        self.channel_format == "string"
    }
}
