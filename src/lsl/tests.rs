//! The library from both sides: descriptions, settings and errors. Python's own outlets and recorders are in
//! `tests/lsl`.

use super::*;

/// Description as written by liblsl 1.16, from its documentation's example of an EEG.
const XML: &str = r#"<?xml version="1.0"?>
<info>
	<name>BioSemi</name><type>EEG</type><channel_count>2</channel_count><channel_format>float32</channel_format>
	<source_id>myuid34234</source_id><nominal_srate>100.000000000000</nominal_srate><version>1.100000000000000</version>
	<created_at>812.5</created_at><uid>c1</uid><session_id>default</session_id><hostname>lab</hostname>
	<desc><channels><channel><label>C3</label><unit>microvolts</unit><type>EEG</type></channel></channels></desc>
</info>"#;

#[test]
fn a_description_is_parsed_with_unnamed_channels_included() {
    let found = FoundStream::parse(XML).unwrap();
    assert_eq!((found.name.as_str(), found.content.as_str(), found.nominal_srate), ("BioSemi", "EEG", 100.0));
    assert_eq!((found.source_id.as_str(), found.created_at, found.is_text()), ("myuid34234", 812.5, false));
    let labels: Vec<_> = found.channels.iter().map(|c| (c.label.as_str(), c.unit.as_str())).collect();
    assert_eq!(labels, [("C3", "microvolts"), ("", "")]);
    assert_eq!(found.to_string(), "name='BioSemi' type='EEG' source_id='myuid34234' (2 channels, 100 Hz, on lab)");
    assert!(FoundStream::parse("<info/>").is_err() && FoundStream::parse("no").is_err());
}

#[test]
fn control_characters_in_names_and_labels_are_replaced() {
    // pugixml, with which liblsl writes XML, writes such a character as a numeric reference.
    for bad in ["\u{1}", "&#1;", "&#01;", "&#x1B;", "\u{9b}", "\u{fffe}"] {
        let found =
            FoundStream::parse(&XML.replace("C3", &format!("C{bad}3")).replace("BioSemi", &format!("Bio{bad}")));
        let found = found.unwrap_or_else(|e| panic!("{bad:?}: {e}"));
        assert_eq!((found.name.as_str(), found.channels[0].label.as_str()), ("Bio\u{fffd}", "C\u{fffd}3"), "{bad:?}");
    }
    let found =
        FoundStream::parse(&XML.replace("C3", "C&amp;&#51;&#x41; &#bad")).map(|found| found.channels[0].label.clone());
    assert!(found.is_err(), "what is no XML stays none: {found:?}");
    let found = FoundStream::parse(&XML.replace("C3", "C&amp;&#51;&#x41;")).unwrap();
    assert_eq!(found.channels[0].label, "C&3A");
}

#[test]
fn a_stream_with_too_many_channels_is_refused_by_name() {
    let of = |count: usize| FoundStream::parse(&XML.replace("<channel_count>2", &format!("<channel_count>{count}")));
    assert_eq!(of(4096).unwrap().channels.len(), 4096);
    let message = of(20_000).unwrap_err().to_string();
    assert!(message.starts_with("the LSL stream BioSemi has 20000 channels; allowed: 4096"), "{message}");
}

#[test]
fn errors_about_missing_things_give_the_remedy() {
    let none = LslError::NotFound { predicate: "type='EEG'".into(), seconds: 2.0, seen: Vec::new() }.to_string();
    assert!(none.contains("type='EEG' was found within 2 s. There is no stream.\n  remedy: start"), "{none}");
    let seen = vec!["name='eyes'".into(), "name='heart'".into()];
    let some = LslError::NotFound { predicate: "x".into(), seconds: 2.0, seen }.to_string();
    assert!(some.contains("Streams found: name='eyes'; name='heart'."), "{some}");
    assert!(LslError::Absent("nowhere".into()).to_string().ends_with("pip install pylsl brings one"));
}

#[test]
fn invalid_settings_are_refused() {
    let with = |text: &str| toml::from_str::<LslSettings>(text).unwrap();
    let full = with("outlets = true\nrecord = [\"type='EEG'\"]\nwait_s = 3.0");
    assert!(full.check().is_ok() && full.wait_s == 3.0);
    assert!(with("").check().is_ok());
    assert_eq!(with("wait_s = 0").check(), Err(LslSettingsFault::Wait(0.0)));
    assert_eq!(with("record = [' ']").check(), Err(LslSettingsFault::EmptyPredicate));
    assert_eq!(with("interface = ''").check(), Err(LslSettingsFault::EmptyInterface));
    assert_eq!(OutletInterface::of(&with("").interface), OutletInterface::Loopback, "nothing else is asked for");
    assert!(toml::from_str::<LslSettings>("outlet = true").is_err());
}

#[test]
fn the_clock_is_the_systems_monotonic_one() {
    let uptime =
        || -> f64 { std::fs::read_to_string("/proc/uptime").unwrap().split(' ').next().unwrap().parse().unwrap() };
    let (before, now) = (uptime(), local_clock_s());
    // CLOCK_MONOTONIC stops while the computer sleeps, and uptime does not: it is ahead of uptime by the last digit at
    // most.
    assert!(now > 0.0 && now < before + 60.0, "{now} {before}");
    assert!(local_clock_s() >= now);
}

#[test]
fn a_wait_for_a_silent_stream_ends_on_interruption() {
    // lsl_timeout_error, as for a device that accepts connections and sends nothing.
    let mut asked = 0;
    let ended = inlet::answered(5.0, &|| true, |_, code| {
        (*code, asked) = (-1, asked + 1);
    });
    assert!(matches!(ended, Err(LslError::Interrupted)) && asked == 1, "asked {asked} times");
}
