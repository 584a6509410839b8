//! The number of vehicles, persons and containers that a demand brings. In: its flows and the elements of its `rou.xml` files, one after the
//! other. Out: how many depart until a time, of random flows the expected number; or what is wrong with an attribute that says so.
//!
//! A drive is refused before SUMO has the files where they are too many: SUMO keeps each vehicle that waits. And a drive says how
//! many found no room where they come: SUMO lets them wait beside the road, where nothing is seen of them.

use super::{Demand, demand_file::MOST_VEHICLES};
use crate::sumo_xml::{
    self,
    stream::{self, Tag},
};
use std::{io, path::Path};

/// The most vehicles that one flow may bring within a second: SUMO tries to find room for each in every step. A lane carries one in two
/// seconds.
pub const MOST_PER_S: f64 = 1000.0;
/// The most edges of one route with its repetitions, and of all routes that are repeated together: SUMO writes each out.
pub const MOST_ROUTE_EDGES: f64 = 100_000.0;
const MOST_REPEATED_EDGES: f64 = 10_000_000.0;
/// The most types of vehicles, and the most members of a distribution. A file by SUMO's `createVehTypeDistribution.py` has 100.
pub const MOST_TYPES: usize = 20_000;
/// The remedy of a rate that is too high.
const LOWER: &str = "\n  remedy: state a rate that roads carry; a lane takes some 2,000 vehicles an hour";
/// Length for which a drive without an end is counted, s.
pub const ENDLESS_S: f64 = 3600.0;
/// Length of a flow without an end in SUMO, s.
const OPEN_FLOW_S: f64 = 86_400.0;
/// Attributes that state a number an hour.
const PER_HOUR: [&str; 4] = ["vehsPerHour", "personsPerHour", "containersPerHour", "perHour"];

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
    let (mut sum, mut times) = (Some(0.0), IntervalTimes::default());
    let mut look = |tag: &Tag| {
        times.leave(tag);
        sum = sum.and_then(|sum| Some(sum + due_of_element(tag, until_s, &mut times)?));
        Ok(())
    };
    stream::copy(file, sumo_xml::demand(), io::sink(), &mut look).ok()?;
    sum
}

fn due_of_element(tag: &Tag, until_s: f64, times: &mut IntervalTimes) -> Option<f64> {
    match tag.name.as_str() {
        "trip" | "vehicle" => Some(f64::from(u8::from(seconds(tag.attribute("depart")?)? < until_s))),
        "flow" => Some(FlowRate::of(tag, &times.of_flows).ok()?.until(until_s)),
        "interval" => {
            times.enter(tag).ok()?;
            Some(0.0)
        }
        _ => Some(0.0),
    }
}

/// Sums of all files of a demand.
pub(super) struct DemandCount {
    until_s: f64,
    times: IntervalTimes,
    vehicles: f64,
    types: usize,
    repeated_edges: f64,
}

impl DemandCount {
    /// A count until a time, s, that begins with those that the demand's own flows bring.
    pub fn new(demand: &Demand, until_s: f64) -> Self {
        let vehicles = demand.due_of_flows(until_s);
        Self { until_s, times: IntervalTimes::default(), vehicles, types: 0, repeated_edges: 0.0 }
    }

    /// Vehicles, persons and containers until now.
    pub fn vehicles(&self) -> u64 {
        self.vehicles.ceil() as u64
    }

    /// Adds an element that begins. The error says what is wrong and what is allowed.
    pub fn add(&mut self, tag: &Tag) -> Result<(), String> {
        self.times.leave(tag);
        match tag.name.as_str() {
            "trip" | "vehicle" | "person" | "container" => {
                if let Some(text) = tag.attribute("depart") {
                    departure("depart", text)?;
                }
                self.vehicles += 1.0;
            }
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
            let said = rate.said;
            return Err(format!("{said}, that is {per_s:.0} within a second; allowed: at most {MOST_PER_S}{LOWER}"));
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

    fn route(&mut self, tag: &Tag) -> Result<(), String> {
        let Some(repeat) = whole("repeat", tag)? else { return Ok(()) };
        let edges = tag.attribute("edges").map_or(0, |text| text.split_whitespace().count()) as f64 * (repeat + 1.0);
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
    fn of(tag: &Tag) -> Result<Self, String> {
        Ok(Self { begin_s: time("begin", tag)?, end_s: time("end", tag)? })
    }
}

/// The interval around the elements that are read.
#[derive(Default)]
struct IntervalTimes {
    /// Times that it gives to its flows.
    of_flows: FlowTimes,
    /// Depth of the interval; elements that lie deeper are in it.
    depth: Option<usize>,
}

impl IntervalTimes {
    /// Takes the start of an interval.
    fn enter(&mut self, tag: &Tag) -> Result<(), String> {
        *self = Self { of_flows: FlowTimes::of(tag)?, depth: Some(tag.depth) };
        Ok(())
    }

    /// Forgets the interval where an element that begins is not in it.
    fn leave(&mut self, tag: &Tag) {
        if self.depth.is_some_and(|depth| tag.depth <= depth) {
            *self = Self::default();
        }
    }
}

/// Departures of the vehicles of a flow.
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
    fn of(tag: &Tag, times: &FlowTimes) -> Result<Self, String> {
        let begin = tag.attribute("begin").map(|text| departure("begin", text)).transpose()?;
        let begin_s = begin.map_or(times.begin_s, |at| at.or(Some(0.0))).unwrap_or(0.0);
        let end_s = time("end", tag)?.or(times.end_s).unwrap_or(begin_s + OPEN_FLOW_S);
        let number = whole("number", tag)?;
        let flow =
            |(per_s, is_random): (f64, bool), said: String| Self { begin_s, end_s, per_s, is_random, number, said };
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

fn time(name: &str, tag: &Tag) -> Result<Option<f64>, String> {
    let Some(text) = tag.attribute(name) else { return Ok(None) };
    let found = seconds(text).filter(|seconds| *seconds >= 0.0);
    found.map(Some).ok_or_else(|| not_allowed(name, text, "seconds from 0, or h:mm:ss"))
}

/// A whole number from 0 that SUMO can hold.
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
