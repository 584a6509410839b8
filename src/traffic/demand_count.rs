//! The number of vehicles, persons and containers that a demand brings. In: its flows and the elements of its `rou.xml` files, one after the
//! other. Out: how many depart until a time, of random flows the expected number; or what is wrong with an attribute that says so.
//!
//! A drive is refused before SUMO has the files where they are too many: SUMO keeps each vehicle that waits. And a drive says how
//! many found no room where they come: SUMO lets them wait beside the road, where nothing is seen of them.

use super::{Demand, demand_file::MOST_VEHICLES};
use crate::file;
use quick_xml::{
    Reader, XmlVersion,
    events::{BytesStart, Event},
};
use std::{io::BufReader, path::Path};

/// The most vehicles that one flow may bring within a second: SUMO tries to find room for each in every step. A lane carries one in two
/// seconds.
pub const MOST_PER_S: f64 = 1000.0;
/// The most edges of one route with its repetitions, and of all routes that are repeated together: SUMO writes each out.
pub const MOST_ROUTE_EDGES: f64 = 100_000.0;
const MOST_REPEATED_EDGES: f64 = 10_000_000.0;
/// The most types of vehicles, and the most members of a distribution. A file by SUMO's `createVehTypeDistribution.py` has 100.
pub const MOST_TYPES: usize = 20_000;
/// The most elements inside one another. SUMO's own nest five deep, and it takes a call of a function for each.
pub const MOST_DEPTH: usize = 32;
/// The remedy of a rate that is too high.
const LOWER: &str = "\n  remedy: state a rate that roads carry; a lane takes some 2,000 vehicles an hour";
/// Length for which a drive without an end is counted, s.
pub const ENDLESS_S: f64 = 3600.0;
/// Length of a flow without an end in SUMO, s.
const OPEN_FLOW_S: f64 = 86_400.0;
/// Attributes that state a number an hour.
const PER_HOUR: [&str; 4] = ["vehsPerHour", "personsPerHour", "containersPerHour", "perHour"];

/// Text of an attribute of an element by its name.
pub(super) type Attributes<'a> = &'a dyn Fn(&str) -> Option<String>;

impl Demand {
    /// Time until which a demand is counted, s: the length of the drive and of what comes before it.
    pub fn horizon_s(duration_s: f64, before_s: f64) -> f64 {
        before_s + if duration_s > 0.0 { duration_s } else { ENDLESS_S }
    }

    /// Vehicles that its own flows bring until a time, s.
    pub(super) fn due_of_flows(&self, until_s: f64) -> f64 {
        self.flows.iter().map(|flow| flow.per_hour * until_s / 3600.0).sum()
    }

    /// How many vehicles are to depart before `until_s` seconds; `None` where a file does not say it in numbers, or cannot be read.
    pub fn due(&self, until_s: f64) -> Option<f64> {
        let of_flows = self.due_of_flows(until_s);
        self.files.iter().try_fold(of_flows, |sum, file| Some(sum + due_of_file(file, until_s)?))
    }
}

fn due_of_file(file: &Path, until_s: f64) -> Option<f64> {
    let mut reader = Reader::from_reader(BufReader::new(file::open_regular(file).ok()?));
    let (mut buffer, mut sum, mut times) = (Vec::new(), 0.0, FlowTimes::default());
    loop {
        buffer.clear();
        match reader.read_event_into(&mut buffer).ok()? {
            Event::Eof => return Some(sum),
            Event::Start(tag) | Event::Empty(tag) => sum += due_of_element(&tag, until_s, &mut times)?,
            Event::End(tag) if tag.name().as_ref() == b"interval" => times = FlowTimes::default(),
            _ => {}
        }
    }
}

fn due_of_element(tag: &BytesStart, until_s: f64, times: &mut FlowTimes) -> Option<f64> {
    let attribute = |name: &str| text_of(tag, name);
    match tag.name().as_ref() {
        b"trip" | b"vehicle" => Some(f64::from(u8::from(seconds(&attribute("depart")?)? < until_s))),
        b"flow" => Some(FlowRate::of(&attribute, times).ok()?.until(until_s)),
        b"interval" => {
            *times = FlowTimes::of(&attribute).ok()?;
            Some(0.0)
        }
        _ => Some(0.0),
    }
}

/// Text of an attribute; `None` where there is none, or the file is broken.
pub(super) fn text_of(tag: &BytesStart, name: &str) -> Option<String> {
    let found = tag.try_get_attribute(name).ok()??;
    Some(found.normalized_value(XmlVersion::Implicit1_0).ok()?.into())
}

/// Sums of all files of a demand.
pub(super) struct DemandCount {
    until_s: f64,
    times: FlowTimes,
    depth: usize,
    vehicles: f64,
    types: usize,
    repeated_edges: f64,
}

impl DemandCount {
    /// A count until a time, s, that begins with those that the demand's own flows bring.
    pub fn new(demand: &Demand, until_s: f64) -> Self {
        let vehicles = demand.due_of_flows(until_s);
        Self { until_s, times: FlowTimes::default(), depth: 0, vehicles, types: 0, repeated_edges: 0.0 }
    }

    /// Vehicles, persons and containers until now.
    pub fn vehicles(&self) -> u64 {
        self.vehicles.ceil() as u64
    }

    /// Adds an element that begins, and those below it after that. The error says what is wrong and what is allowed.
    pub fn begin(&mut self, kind: &str, attribute: Attributes<'_>) -> Result<(), String> {
        self.depth += 1;
        if self.depth > MOST_DEPTH {
            return Err(format!("{} elements lie inside one another; allowed: at most {MOST_DEPTH}", self.depth));
        }
        match kind {
            "trip" | "vehicle" | "person" | "container" => {
                if let Some(text) = attribute("depart") {
                    departure("depart", &text)?;
                }
                self.vehicles += 1.0;
            }
            "flow" | "personFlow" | "containerFlow" => self.flow(attribute)?,
            "interval" => self.times = FlowTimes::of(attribute)?,
            "route" => self.route(attribute)?,
            "vType" => {
                self.types += 1;
                if self.types > MOST_TYPES {
                    return Err(format!("this is type {} of the demand; allowed: at most {MOST_TYPES}", self.types));
                }
            }
            "vTypeDistribution" | "routeDistribution" => {
                for name in ["vTypes", "routes", "probabilities"] {
                    let count = attribute(name).map_or(0, |text| text.split_whitespace().count());
                    if count > MOST_TYPES {
                        return Err(format!("{name} has {count} members; allowed: at most {MOST_TYPES}"));
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// An element ends.
    pub fn end(&mut self, kind: &str) {
        self.depth = self.depth.saturating_sub(1);
        if kind == "interval" {
            self.times = FlowTimes::default();
        }
    }

    fn flow(&mut self, attribute: Attributes<'_>) -> Result<(), String> {
        let rate = FlowRate::of(attribute, &self.times)?;
        let per_s = rate.most_within_a_second();
        if per_s > MOST_PER_S {
            let said = rate.said;
            return Err(format!("{said}, that is {per_s} within a second; allowed: at most {MOST_PER_S}{LOWER}"));
        }
        let brings = rate.until(self.until_s);
        if brings > MOST_VEHICLES as f64 {
            return Err(format!(
                "{} brings {} until {} s; allowed: at most {MOST_VEHICLES} of all flows and vehicles together{LOWER}",
                rate.said,
                brings.ceil(),
                self.until_s
            ));
        }
        self.vehicles += brings;
        Ok(())
    }

    fn route(&mut self, attribute: Attributes<'_>) -> Result<(), String> {
        let Some(repeat) = whole("repeat", attribute)? else { return Ok(()) };
        let edges = attribute("edges").map_or(0, |text| text.split_whitespace().count()) as f64 * (repeat + 1.0);
        self.repeated_edges += edges;
        if edges > MOST_ROUTE_EDGES {
            return Err(format!(
                "repeat is {repeat}, with which the route has {edges} edges; allowed: at most {MOST_ROUTE_EDGES}"
            ));
        }
        if self.repeated_edges > MOST_REPEATED_EDGES {
            return Err(format!(
                "repeated routes have {} edges up to here; allowed: at most {MOST_REPEATED_EDGES}",
                self.repeated_edges
            ));
        }
        Ok(())
    }
}

/// Times of flows that state none of their own, s: those of the interval around them.
#[derive(Clone, Copy, Default)]
struct FlowTimes {
    begin_s: Option<f64>,
    end_s: Option<f64>,
}

impl FlowTimes {
    fn of(attribute: Attributes<'_>) -> Result<Self, String> {
        Ok(Self { begin_s: time("begin", attribute)?, end_s: time("end", attribute)? })
    }
}

/// When the vehicles of a flow depart.
struct FlowRate {
    begin_s: f64,
    end_s: f64,
    /// Vehicles a second on average.
    per_s: f64,
    /// At random times, and not at even ones.
    is_random: bool,
    /// The most, where the flow states it.
    number: Option<f64>,
    /// The rate as the file has it.
    said: String,
}

impl FlowRate {
    fn of(attribute: Attributes<'_>, times: &FlowTimes) -> Result<Self, String> {
        let begin = attribute("begin").map(|text| departure("begin", &text)).transpose()?;
        let begin_s = begin.map_or(times.begin_s, |at| at.or(Some(0.0))).unwrap_or(0.0);
        let end_s = time("end", attribute)?.or(times.end_s).unwrap_or(begin_s + OPEN_FLOW_S);
        let number = whole("number", attribute)?;
        let flow =
            |(per_s, is_random): (f64, bool), said: String| Self { begin_s, end_s, per_s, is_random, number, said };
        if let Some(text) = attribute("period") {
            return Ok(flow(of_period(&text)?, format!("period is \"{text}\"")));
        }
        for name in PER_HOUR {
            let Some(text) = attribute(name) else { continue };
            let per_hour = text.trim().parse().ok().filter(|n: &f64| n.is_finite() && *n > 0.0);
            let per_hour = per_hour.ok_or_else(|| not_allowed(name, &text, "a number above 0"))?;
            return Ok(flow((per_hour / 3600.0, false), format!("{name} is \"{text}\"")));
        }
        if let Some(text) = attribute("probability") {
            let chance = text.trim().parse().ok().filter(|n: &f64| *n > 0.0 && *n <= 1.0);
            let chance = chance.ok_or_else(|| not_allowed("probability", &text, "a number above 0, at most 1"))?;
            return Ok(flow((chance, true), format!("probability is \"{text}\"")));
        }
        let Some(count) = number else {
            let names = "period, probability, vehsPerHour, perHour or number";
            return Err(format!("it states no rate; allowed: {names}"));
        };
        // All at once where it has no length.
        let per_s = if end_s > begin_s { count / (end_s - begin_s) } else { f64::INFINITY };
        Ok(flow((per_s, false), format!("number is \"{count}\"")))
    }

    /// Departures before a time, s. The first of even ones is at the flow's begin.
    fn until(&self, until_s: f64) -> f64 {
        let most = self.number.unwrap_or(f64::INFINITY);
        let until_s = if self.per_s.is_infinite() { until_s } else { until_s.min(self.end_of_rate_s()) };
        let length_s = until_s - self.begin_s;
        if length_s <= 0.0 {
            return 0.0;
        }
        let count = length_s * self.per_s;
        // 1/1.8 of 3.6 s is a hair more than 2.
        let count = if self.is_random { count } else { (count - 1e-9).ceil() };
        count.min(most)
    }

    /// End of its departures, s: SUMO lets a number at a stated rate go on beyond all ends.
    fn end_of_rate_s(&self) -> f64 {
        self.number.map_or(self.end_s, |number| self.begin_s + number / self.per_s)
    }

    fn most_within_a_second(&self) -> f64 {
        self.number.map_or(self.per_s, |number| number.min(self.per_s))
    }
}

/// Vehicles a second of a period, and if they come at random.
fn of_period(text: &str) -> Result<(f64, bool), String> {
    let wrong = || not_allowed("period", text, "seconds above 0, or exp(NUMBER A SECOND)");
    let above = |number: &str| number.trim().parse().ok().filter(|n: &f64| n.is_finite() && *n > 0.0);
    if let Some(rest) = text.trim().strip_prefix("exp(") {
        return rest.strip_suffix(')').and_then(above).map(|per_s| (per_s, true)).ok_or_else(wrong);
    }
    seconds(text).filter(|period_s| *period_s > 0.0).map(|period_s| (1.0 / period_s, false)).ok_or_else(wrong)
}

/// Seconds of a time as SUMO writes it: `90`, `0:01:30` or `0:00:01:30`.
fn seconds(text: &str) -> Option<f64> {
    let parts: Vec<f64> = text.trim().split(':').map(str::parse).collect::<Result<_, _>>().ok()?;
    let seconds = match parts[..] {
        [s] => s,
        [h, m, s] => (h * 60.0 + m) * 60.0 + s,
        [d, h, m, s] => ((d * 24.0 + h) * 60.0 + m) * 60.0 + s,
        _ => return None,
    };
    seconds.is_finite().then_some(seconds)
}

/// A time at which something departs, s; `None` of one that waits for another vehicle.
fn departure(name: &str, text: &str) -> Result<Option<f64>, String> {
    match text.trim() {
        "triggered" | "containerTriggered" | "split" | "now" | "begin" => Ok(None),
        other => match seconds(other).filter(|seconds| *seconds >= 0.0) {
            Some(seconds) => Ok(Some(seconds)),
            None => Err(not_allowed(name, text, "seconds from 0, h:mm:ss, triggered")),
        },
    }
}

fn time(name: &str, attribute: Attributes<'_>) -> Result<Option<f64>, String> {
    let Some(text) = attribute(name) else { return Ok(None) };
    let found = seconds(&text).filter(|seconds| *seconds >= 0.0);
    found.map(Some).ok_or_else(|| not_allowed(name, &text, "seconds from 0, or h:mm:ss"))
}

/// A whole number from 0 that SUMO can hold.
fn whole(name: &str, attribute: Attributes<'_>) -> Result<Option<f64>, String> {
    let Some(text) = attribute(name) else { return Ok(None) };
    let number = text.trim().parse::<u32>().ok().filter(|n| *n <= i32::MAX as u32);
    number.map(|n| Some(f64::from(n))).ok_or_else(|| not_allowed(name, &text, "a whole number from 0"))
}

fn not_allowed(name: &str, text: &str, allowed: &str) -> String {
    format!("{name} is \"{text}\"; allowed: {allowed}")
}

#[cfg(test)]
#[path = "demand_count_tests.rs"]
mod tests;
