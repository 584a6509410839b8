//! How many vehicles a demand sends until a time. In: its flows and `rou.xml` files. Out: a number, of random flows the expected one. With it a
//! drive says how many found no room where they come: SUMO lets them wait beside the road, where nothing is seen of them.

use super::Demand;
use crate::file;
use quick_xml::{
    Reader, XmlVersion,
    events::{BytesStart, Event},
};
use std::{io::BufReader, path::Path};

impl Demand {
    /// How many vehicles are to depart before `until_s` seconds; `None` where a file does not say it in numbers, or cannot be read.
    pub fn due(&self, until_s: f64) -> Option<f64> {
        let of_flows: f64 = self.flows.iter().map(|flow| flow.per_hour * until_s / 3600.0).sum();
        self.files.iter().try_fold(of_flows, |sum, file| Some(sum + due_of_file(file, until_s)?))
    }
}

fn due_of_file(file: &Path, until_s: f64) -> Option<f64> {
    let mut reader = Reader::from_reader(BufReader::new(file::open_regular(file).ok()?));
    let (mut buffer, mut sum) = (Vec::new(), 0.0);
    loop {
        buffer.clear();
        match reader.read_event_into(&mut buffer).ok()? {
            Event::Eof => return Some(sum),
            Event::Start(tag) | Event::Empty(tag) => sum += due_of_element(&tag, until_s)?,
            _ => {}
        }
    }
}

fn due_of_element(tag: &BytesStart, until_s: f64) -> Option<f64> {
    match tag.name().as_ref() {
        b"trip" | b"vehicle" => Some(f64::from(u8::from(number(tag, "depart")?? < until_s))),
        b"flow" => due_of_flow(tag, until_s),
        _ => Some(0.0),
    }
}

/// The first departs at the flow's begin, those after it at even times, or at random ones with as many on average.
fn due_of_flow(tag: &BytesStart, until_s: f64) -> Option<f64> {
    let (begin_s, end_s) = (number(tag, "begin")?.unwrap_or(0.0), number(tag, "end")?.unwrap_or(f64::INFINITY));
    let from_begin_s = (until_s.min(end_s) - begin_s).max(0.0);
    let period = text(tag, "period")?;
    let random_per_s =
        period.as_deref().and_then(|text| text.strip_prefix("exp(")?.strip_suffix(')')?.parse::<f64>().ok());
    if let Some(per_s) = random_per_s.or(number(tag, "probability")?) {
        return Some(per_s * from_begin_s);
    }
    let of_number = number(tag, "number")?.map(|n| (end_s - begin_s) / n).filter(|period_s| period_s.is_finite());
    let of_rate = number(tag, "vehsPerHour")?.or(number(tag, "perHour")?).map(|per_hour| 3600.0 / per_hour);
    let of_period = period.and_then(|text| text.trim().parse().ok());
    let period_s: f64 = of_rate.or(of_period).or(of_number)?;
    Some((from_begin_s / period_s).ceil())
}

/// An attribute; the outer `None` where the file is broken.
fn text(tag: &BytesStart, name: &str) -> Option<Option<String>> {
    let Some(found) = tag.try_get_attribute(name).ok()? else { return Some(None) };
    Some(Some(found.normalized_value(XmlVersion::Implicit1_0).ok()?.into()))
}

/// The same as a number; the outer `None` where it is none.
fn number(tag: &BytesStart, name: &str) -> Option<Option<f64>> {
    text(tag, name)?.map(|text| text.trim().parse().ok()).map_or(Some(None), |number: Option<f64>| number.map(Some))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::Flow;

    fn due(elements: &str, until_s: f64) -> Option<f64> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("x.rou.xml");
        std::fs::write(&file, format!("<routes><vType id=\"a\"/>{elements}</routes>")).unwrap();
        Demand { files: vec![file], flows: Vec::new() }.due(until_s)
    }

    #[test]
    fn vehicles_that_are_due_are_counted_as_by_hand() {
        // Each 1.8 s from 0 on: at 0 and 1.8, and at 3.6 not yet.
        let even = "<flow id=\"f\" begin=\"0\" end=\"9999\" vehsPerHour=\"2000\"/>";
        assert_eq!([0.0, 1.0, 3.6, 3.7].map(|until_s| due(even, until_s)), [0.0, 1.0, 2.0, 3.0].map(Some));
        assert_eq!(due("<flow id=\"f\" begin=\"10\" end=\"20\" number=\"5\"/>", 15.0), Some(3.0), "at 10, 12 and 14");
        assert_eq!(due("<flow id=\"f\" begin=\"10\" end=\"20\" period=\"4\"/>", 99.0), Some(3.0), "at 10, 14 and 18");
        assert_eq!(due("<flow id=\"f\" begin=\"0\" period=\"exp(0.5)\"/>", 30.0), Some(15.0));
        assert_eq!(due("<flow id=\"f\" begin=\"0\" end=\"50\" probability=\"0.2\"/>", 100.0), Some(10.0));
        assert_eq!(due("<trip id=\"t\" depart=\"3\"/><vehicle id=\"v\" depart=\"5\"/>", 4.0), Some(1.0));
        assert_eq!(due("<trip id=\"t\" depart=\"triggered\"/>", 4.0), None);
        assert_eq!(due("<flow id=\"f\" begin=\"0\"/>", 4.0), None, "no rate");
        let flow = Flow { from: "a".into(), to: "b".into(), per_hour: 720.0, mix: Vec::new() };
        assert_eq!(Demand { files: Vec::new(), flows: vec![flow] }.due(10.0), Some(2.0));
        assert_eq!(Demand { files: vec!["no.rou.xml".into()], flows: Vec::new() }.due(1.0), None);
    }
}
