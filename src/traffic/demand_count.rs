//! Number of vehicles, persons and containers in a demand. In: its flows and the elements of its `rou.xml` files, in order. Out: the number
//! of departures before a time, for random flows the expected number; or the fault in an attribute that determines it.
//!
//! A drive with too many vehicles is refused before SUMO gets the files, because SUMO keeps every waiting vehicle in memory. A drive also
//! reports how many vehicles found no room to enter: SUMO keeps them waiting off the road, where they are not visible.

use super::{Demand, demand_file::MOST_VEHICLES};
use crate::sumo_xml::{
    self, Vocabulary,
    stream::{self, Tag},
};
use std::{io, ops::Range, path::Path};

/// Maximum number of vehicles of one flow within a second: SUMO tries to insert each of them in every step. A lane carries one in two
/// seconds.
pub const MOST_PER_S: f64 = 1000.0;
/// Maximum number of edges of one route with its repetitions; the next constant is the maximum of all repeated routes together. SUMO writes
/// each edge out.
pub const MOST_ROUTE_EDGES: f64 = 100_000.0;
const MOST_REPEATED_EDGES: f64 = 10_000_000.0;
/// Maximum number of vehicle types, and of members of a distribution. A file by SUMO's `createVehTypeDistribution.py` has 100.
pub const MOST_TYPES: usize = 20_000;
/// Remedy for a rate that is too high.
const LOWER: &str = "\n  remedy: state a realistic rate; a lane carries about 2,000 vehicles per hour";
/// Counted duration of a drive without an end, s.
pub const ENDLESS_S: f64 = 3600.0;
/// Duration of a flow without an end in SUMO, s.
const OPEN_FLOW_S: f64 = 86_400.0;
/// Attributes with a rate per hour.
const PER_HOUR: [&str; 4] = ["vehsPerHour", "personsPerHour", "containersPerHour", "perHour"];

impl Demand {
    /// Returns the time until which a demand is counted, s: `before_s` plus the duration of the drive, or `ENDLESS_S` if that is 0.
    pub fn horizon_s(duration_s: f64, before_s: f64) -> f64 {
        before_s + if duration_s > 0.0 { duration_s } else { ENDLESS_S }
    }

    /// Returns the number of vehicles of the demand's own flows before a time, s.
    pub(super) fn due_of_flows(&self, until_s: f64) -> f64 {
        self.flows.iter().map(|flow| flow.per_hour * until_s / 3600.0).sum()
    }

    /// Returns the number of vehicles due to depart before `until_s`, s; `None` if a file cannot be read or does not state the number.
    pub fn due(&self, until_s: f64) -> Option<f64> {
        let (of_flows, drive) = (self.due_of_flows(until_s), self.begin_s..self.begin_s + until_s);
        let files = self.additional_files.iter().map(|file| (file, sumo_xml::additional()));
        let mut files = files.chain(self.files.iter().map(|file| (file, sumo_xml::demand())));
        files.try_fold(of_flows, |sum, (file, vocabulary)| Some(sum + due_of_file(file, vocabulary, &drive)?))
    }
}

fn due_of_file(file: &Path, vocabulary: &Vocabulary, drive: &Range<f64>) -> Option<f64> {
    let (mut sum, mut times) = (Some(0.0), IntervalTimes::default());
    let mut look = |tag: &Tag| {
        times.leave(tag);
        sum = sum.and_then(|sum| Some(sum + due_of_element(tag, drive, &mut times)?));
        Ok(())
    };
    stream::copy(file, vocabulary, io::sink(), &mut look).ok()?;
    sum
}

fn due_of_element(tag: &Tag, drive: &Range<f64>, times: &mut IntervalTimes) -> Option<f64> {
    match tag.name.as_str() {
        // A calibrator inserts the vehicles that are missing, whose number is not known before the drive.
        "calibrator" => None,
        "trip" | "vehicle" | "person" => Some(f64::from(u8::from(drive.contains(&seconds(tag.attribute("depart")?)?)))),
        "flow" | "personFlow" => Some(FlowRate::of(tag, &times.of_flows).ok()?.within(drive)),
        "interval" => {
            times.enter(tag).ok()?;
            Some(0.0)
        }
        _ => Some(0.0),
    }
}

/// First and last departures of a demand's files, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Departures {
    /// True if a vehicle, person or container departs within the drive.
    pub is_some_due: bool,
    /// Earliest departure at or after the begin of the drive.
    pub first_s: Option<f64>,
    /// Latest departure before the begin of the drive.
    pub last_s: Option<f64>,
}

impl Departures {
    /// Adds departures from `from_s` to `to_s`, of which `due` are within the drive.
    fn add(&mut self, (from_s, to_s): (f64, f64), due: f64, begin_s: f64) {
        self.is_some_due |= due > 0.0;
        if to_s >= begin_s {
            let from_s = from_s.max(begin_s);
            self.first_s = Some(self.first_s.map_or(from_s, |first_s| first_s.min(from_s)));
        } else {
            self.last_s = Some(self.last_s.map_or(to_s, |last_s| last_s.max(to_s)));
        }
    }
}

/// Running totals over all files of a demand.
pub(super) struct DemandCount {
    /// Begin and end of the drive in the files, s.
    drive: Range<f64>,
    departures: Departures,
    times: IntervalTimes,
    /// Depth of the calibrator that encloses the elements being read.
    calibrator: Option<usize>,
    vehicles: f64,
    types: usize,
    repeated_edges: f64,
}

impl DemandCount {
    /// Creates a count until a time, s, that starts with the vehicles of the demand's own flows.
    pub fn new(demand: &Demand, until_s: f64) -> Self {
        let (begin_s, vehicles) = (demand.begin_s, demand.due_of_flows(until_s));
        Self {
            drive: begin_s..begin_s + until_s,
            departures: Departures { is_some_due: !demand.flows.is_empty(), ..Departures::default() },
            times: IntervalTimes::default(),
            calibrator: None,
            vehicles,
            types: 0,
            repeated_edges: 0.0,
        }
    }

    /// Returns the first and last departures so far.
    pub fn departures(&self) -> Departures {
        self.departures
    }

    /// Returns the number of vehicles, persons and containers so far, rounded up.
    pub fn vehicles(&self) -> u64 {
        self.vehicles.ceil() as u64
    }

    /// Adds an element at its start tag. The error states the fault and the allowed values.
    pub fn add(&mut self, tag: &Tag) -> Result<(), String> {
        self.times.leave(tag);
        if self.calibrator.is_some_and(|depth| tag.depth <= depth) {
            self.calibrator = None;
        }
        match tag.name.as_str() {
            "trip" | "vehicle" | "person" | "container" => {
                let depart_s = tag.attribute("depart").map_or(Ok(None), |text| departure("depart", text))?;
                if let Some(at_s) = depart_s {
                    let due = f64::from(u8::from(self.drive.contains(&at_s)));
                    self.departures.add((at_s, at_s), due, self.drive.start);
                }
                self.vehicles += 1.0;
            }
            "calibrator" => self.calibrator = Some(tag.depth),
            // A calibrator may set a speed only.
            "flow" if self.calibrator.is_some() && !PER_HOUR.iter().any(|name| tag.attribute(name).is_some()) => {}
            "flow" | "personFlow" | "containerFlow" => self.flow(tag)?,
            "interval" => self.times.enter(tag)?,
            "route" => self.route(tag)?,
            "vType" => {
                self.types += 1;
                if self.types > MOST_TYPES {
                    return Err(format!("this is type {} of the demand; allowed: at most {MOST_TYPES}", self.types));
                }
            }
            "vTypeDistribution" | "routeDistribution" => {
                for name in ["vTypes", "routes", "probabilities"] {
                    let count = tag.attribute(name).map_or(0, |text| text.split_whitespace().count());
                    if count > MOST_TYPES {
                        return Err(format!("{name} has {count} members; allowed: at most {MOST_TYPES}"));
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn flow(&mut self, tag: &Tag) -> Result<(), String> {
        let rate = FlowRate::of(tag, &self.times.of_flows)?;
        let per_s = rate.most_within_a_second();
        if per_s > MOST_PER_S {
            let text = rate.text;
            return Err(format!("{text}, which is {per_s:.0} per second; allowed: at most {MOST_PER_S}{LOWER}"));
        }
        let brings = rate.within(&self.drive);
        self.departures.add((rate.begin_s, rate.end_s), brings, self.drive.start);
        if brings > MOST_VEHICLES as f64 {
            return Err(format!(
                "{} brings {} until {} s; allowed: at most {MOST_VEHICLES} of all flows and vehicles together{LOWER}",
                rate.text,
                brings.ceil(),
                self.drive.end
            ));
        }
        self.vehicles += brings;
        Ok(())
    }

    fn route(&mut self, tag: &Tag) -> Result<(), String> {
        let Some(repeat) = whole("repeat", tag)? else { return Ok(()) };
        let edges = tag.attribute("edges").map_or(0, |text| text.split_whitespace().count()) as f64 * (repeat + 1.0);
        self.repeated_edges += edges;
        if edges > MOST_ROUTE_EDGES {
            return Err(format!(
                "repeat is {repeat}, so the route has {edges} edges; allowed: at most {MOST_ROUTE_EDGES}"
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

/// Begin and end that the enclosing interval gives to flows without their own, s.
#[derive(Clone, Copy, Default)]
struct FlowTimes {
    begin_s: Option<f64>,
    end_s: Option<f64>,
}

impl FlowTimes {
    fn of(tag: &Tag) -> Result<Self, String> {
        Ok(Self { begin_s: time("begin", tag)?, end_s: time("end", tag)? })
    }
}

/// Interval that encloses the elements being read.
#[derive(Default)]
struct IntervalTimes {
    /// Begin and end for the flows in it.
    of_flows: FlowTimes,
    /// Nesting depth of the interval; deeper elements belong to it.
    depth: Option<usize>,
}

impl IntervalTimes {
    /// Enters an interval at its start tag.
    fn enter(&mut self, tag: &Tag) -> Result<(), String> {
        *self = Self { of_flows: FlowTimes::of(tag)?, depth: Some(tag.depth) };
        Ok(())
    }

    /// Leaves the interval if a new element is not inside it.
    fn leave(&mut self, tag: &Tag) {
        if self.depth.is_some_and(|depth| tag.depth <= depth) {
            *self = Self::default();
        }
    }
}

/// Rate and times of the departures of a flow.
struct FlowRate {
    begin_s: f64,
    end_s: f64,
    /// Mean rate, vehicles per second.
    per_s: f64,
    /// True for random departure times, false for even ones.
    is_random: bool,
    /// Maximum number of departures, if the flow states one.
    number: Option<f64>,
    /// Rate attribute as written in the file, for messages.
    text: String,
}

impl FlowRate {
    fn of(tag: &Tag, times: &FlowTimes) -> Result<Self, String> {
        let begin = tag.attribute("begin").map(|text| departure("begin", text)).transpose()?;
        let begin_s = begin.map_or(times.begin_s, |at| at.or(Some(0.0))).unwrap_or(0.0);
        let end_s = time("end", tag)?.or(times.end_s).unwrap_or(begin_s + OPEN_FLOW_S);
        let number = whole("number", tag)?;
        let flow =
            |(per_s, is_random): (f64, bool), text: String| Self { begin_s, end_s, per_s, is_random, number, text };
        if let Some(text) = tag.attribute("period") {
            return Ok(flow(of_period(text)?, format!("period is \"{text}\"")));
        }
        for name in PER_HOUR {
            let Some(text) = tag.attribute(name) else { continue };
            let per_hour = text.trim().parse().ok().filter(|n: &f64| n.is_finite() && *n > 0.0);
            let per_hour = per_hour.ok_or_else(|| not_allowed(name, text, "a number above 0"))?;
            return Ok(flow((per_hour / 3600.0, false), format!("{name} is \"{text}\"")));
        }
        if let Some(text) = tag.attribute("probability") {
            let chance = text.trim().parse().ok().filter(|n: &f64| *n > 0.0 && *n <= 1.0);
            let chance = chance.ok_or_else(|| not_allowed("probability", text, "a number above 0, at most 1"))?;
            return Ok(flow((chance, true), format!("probability is \"{text}\"")));
        }
        let Some(count) = number else {
            let names = "period, probability, vehsPerHour, perHour or number";
            return Err(format!("the flow has no rate; allowed: {names}"));
        };
        // A flow of zero length departs all at once.
        let per_s = if end_s > begin_s { count / (end_s - begin_s) } else { f64::INFINITY };
        Ok(flow((per_s, false), format!("number is \"{count}\"")))
    }

    /// Returns the number of departures within a drive, from its begin to its end, s.
    fn within(&self, drive: &Range<f64>) -> f64 {
        (self.until(drive.end) - self.until(drive.start)).max(0.0)
    }

    /// Returns the number of departures before a time, s. The first departure of an even flow is at its begin.
    fn until(&self, until_s: f64) -> f64 {
        let most = self.number.unwrap_or(f64::INFINITY);
        let until_s = if self.per_s.is_infinite() { until_s } else { until_s.min(self.end_of_rate_s()) };
        let length_s = until_s - self.begin_s;
        if length_s <= 0.0 {
            return 0.0;
        }
        let count = length_s * self.per_s;
        // Allows for rounding: 3.6 s divided by 1.8 s can be slightly above 2.
        let count = if self.is_random { count } else { (count - 1e-9).ceil() };
        count.min(most)
    }

    /// Returns the end of the departures, s: SUMO continues a flow with a number and a rate beyond its end.
    fn end_of_rate_s(&self) -> f64 {
        self.number.map_or(self.end_s, |number| self.begin_s + number / self.per_s)
    }

    fn most_within_a_second(&self) -> f64 {
        self.number.map_or(self.per_s, |number| number.min(self.per_s))
    }
}

/// Parses a period: vehicles per second, and true for random departures.
fn of_period(text: &str) -> Result<(f64, bool), String> {
    let wrong = || not_allowed("period", text, "seconds above 0, or exp(NUMBER PER SECOND)");
    let above = |number: &str| number.trim().parse().ok().filter(|n: &f64| n.is_finite() && *n > 0.0);
    if let Some(rest) = text.trim().strip_prefix("exp(") {
        return rest.strip_suffix(')').and_then(above).map(|per_s| (per_s, true)).ok_or_else(wrong);
    }
    seconds(text).filter(|period_s| *period_s > 0.0).map(|period_s| (1.0 / period_s, false)).ok_or_else(wrong)
}

/// Parses a time in SUMO's format to seconds from 0; `None` if it is none.
pub fn time_of_day_s(text: &str) -> Option<f64> {
    seconds(text).filter(|seconds| *seconds >= 0.0)
}

/// Parses a time in SUMO's format to seconds: `90`, `0:01:30` or `0:00:01:30`.
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

/// Parses a departure time, s; `None` for a keyword such as `triggered`.
fn departure(name: &str, text: &str) -> Result<Option<f64>, String> {
    match text.trim() {
        "triggered" | "containerTriggered" | "split" | "now" | "begin" => Ok(None),
        other => match time_of_day_s(other) {
            Some(seconds) => Ok(Some(seconds)),
            None => Err(not_allowed(name, text, "seconds from 0, h:mm:ss, triggered")),
        },
    }
}

fn time(name: &str, tag: &Tag) -> Result<Option<f64>, String> {
    let Some(text) = tag.attribute(name) else { return Ok(None) };
    time_of_day_s(text).map(Some).ok_or_else(|| not_allowed(name, text, "seconds from 0, or h:mm:ss"))
}

/// Parses an attribute as a whole number from 0 to `i32::MAX`, SUMO's limit; `None` if the attribute is missing.
fn whole(name: &str, tag: &Tag) -> Result<Option<f64>, String> {
    let Some(text) = tag.attribute(name) else { return Ok(None) };
    let number = text.trim().parse::<u32>().ok().filter(|n| *n <= i32::MAX as u32);
    number.map(|n| Some(f64::from(n))).ok_or_else(|| not_allowed(name, text, "a whole number from 0"))
}

fn not_allowed(name: &str, text: &str, allowed: &str) -> String {
    format!("{name} is \"{text}\"; allowed: {allowed}")
}

#[cfg(test)]
#[path = "demand_count_tests.rs"]
mod tests;
