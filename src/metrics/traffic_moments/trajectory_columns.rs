//! Columns of a file of trajectories. In: the first line, then each line. Out: the layout, then a [`Row`] for each vehicle of a line.
//!
//! * A row for each vehicle and step: the columns of `trajectory_file`, the Arizona Ring Experiments' among them (`t_s`, `car`).
//! * A row for each step, as OpenACC's car-following pairs: `t_s`, `v1_CAR`, `v2_CAR`, `gap2_m`, `v3_CAR`, ... The first vehicle leads.

use super::trajectory_file::{COLUMNS, FileRules, GAPS_M, LineFault};

/// Columns of the layout with a row for each vehicle, each with its second name.
const NAMES: [[&str; 2]; 6] = [
    ["time_s", "t_s"],
    ["vehicle", "car"],
    ["leader", "leader"],
    ["speed_mps", "speed_mps"],
    ["gap_m", "gap_m"],
    ["s_m", "s_m"],
];
/// Smallest and largest time, s.
const TIMES_S: [f64; 2] = [-1e9, 1e9];

/// Cells of one vehicle at one step.
pub(super) struct Row<'a> {
    pub line: usize,
    pub time_s: f64,
    pub vehicle: &'a str,
    pub leader: &'a str,
    pub speed_mps: f64,
    pub gap_m: Option<f64>,
    pub s_m: Option<f64>,
}

/// Vehicle of a layout with a row for each step.
pub(super) struct PlatoonVehicle {
    name: String,
    /// Name of the column of its speed.
    speed: String,
    speed_at: usize,
    /// Place of the column of its gap; `None` for the first.
    gap_at: Option<usize>,
}

/// Layout of a file.
pub(super) enum Layout {
    /// A row for each vehicle and step: places of the columns, if present.
    Vehicles([Option<usize>; 6]),
    /// A row for each step: place of the time, and the vehicles, the first ahead.
    Platoon(usize, Vec<PlatoonVehicle>),
}

impl Layout {
    /// Finds the layout from the first line.
    pub fn of(head: &str, rules: &FileRules) -> Result<Self, LineFault> {
        let names: Vec<&str> = head.trim_start_matches('\u{feff}').split(',').map(str::trim).collect();
        let place = |wanted: &str| names.iter().position(|name| *name == wanted);
        if let (Some(time_at), Some(_)) = (place("t_s"), names.iter().find(|name| name.starts_with("v1_"))) {
            return platoon(&names).map(|vehicles| Self::Platoon(time_at, vehicles));
        }
        let mut places = [None; 6];
        for (at, [name, other]) in places.iter_mut().zip(NAMES) {
            *at = place(name).or_else(|| place(other));
            if at.is_none() && rules.required.contains(&name) {
                return Err(missing(name, &names, rules));
            }
        }
        Ok(Self::Vehicles(places))
    }

    /// Returns the rows of a line.
    pub fn rows<'a>(&'a self, line: usize, text: &'a str, rules: &'a FileRules) -> Vec<Result<Row<'a>, LineFault>> {
        let cells = Cells { line, cells: text.split(',').map(str::trim).collect() };
        match self {
            Self::Vehicles(places) => vec![cells.vehicle(places, rules)],
            Self::Platoon(time_at, vehicles) => {
                let leader = |k: usize| k.checked_sub(1).map_or("", |ahead| vehicles[ahead].name.as_str());
                let rows = vehicles.iter().enumerate();
                rows.map(|(k, vehicle)| cells.of_platoon(*time_at, vehicle, leader(k), rules)).collect()
            }
        }
    }
}

/// Returns the vehicles of a layout with a row for each step.
fn platoon(names: &[&str]) -> Result<Vec<PlatoonVehicle>, LineFault> {
    let mut vehicles = Vec::new();
    for number in 1.. {
        let start = format!("v{number}_");
        let Some(speed_at) = names.iter().position(|name| name.starts_with(&start)) else { break };
        let gap = format!("gap{number}_m");
        let gap_at = names.iter().position(|name| *name == gap);
        if number > 1 && gap_at.is_none() {
            let what = format!("there is no column \"{gap}\"; the columns are \"{}\"", names.join(", "));
            return Err((1, what, "write the gap of each vehicle to the one ahead, in m".to_owned()));
        }
        let (name, speed) = (format!("v{number}"), names[speed_at].to_owned());
        vehicles.push(PlatoonVehicle { name, speed, speed_at, gap_at: gap_at.filter(|_| number > 1) });
    }
    Ok(vehicles)
}

/// Returns the fault of a file without a column.
fn missing(column: &str, names: &[&str], rules: &FileRules) -> LineFault {
    let what = format!("there is no column \"{column}\"; the columns are \"{}\"", names.join(", "));
    let unit = |name: &&&str| ["kmh", "km/h", "kph", "mph"].iter().any(|unit| name.to_lowercase().contains(unit));
    let remedy = match names.iter().find(unit) {
        Some(name) if column == "speed_mps" => {
            let per =
                if name.to_lowercase().contains("mph") { "multiply mph by 0.44704" } else { "divide km/h by 3.6" };
            format!("write speeds in m/s in a column speed_mps: {per} (column {name})")
        }
        _ if rules.required.len() == COLUMNS.len() => {
            format!("name the columns in the first line: {}", COLUMNS.join(","))
        }
        _ => format!("name at least these columns in the first line: {}", rules.required.join(",")),
    };
    (1, what, remedy)
}

/// Cells of a line.
struct Cells<'a> {
    line: usize,
    cells: Vec<&'a str>,
}

impl<'a> Cells<'a> {
    fn at(&self, place: Option<usize>) -> &'a str {
        place.and_then(|place| self.cells.get(place).copied()).unwrap_or_default()
    }

    /// Reads a number within limits; the fault names the column.
    fn number(&self, place: Option<usize>, name: &str, [low, high]: [f64; 2]) -> Result<f64, LineFault> {
        let cell = self.at(place);
        let value = cell.parse::<f64>().ok().filter(|value| (low..=high).contains(value));
        value.ok_or_else(|| {
            let column = place.map_or(String::new(), |place| format!(" (column {})", place + 1));
            let what = format!("{name} is \"{cell}\"; allowed: a number from {low} to {high}{column}");
            let remedy = "write the value in this unit, fill short holes by interpolation, or leave the vehicle out";
            (self.line, what, remedy.to_owned())
        })
    }

    fn vehicle(&self, places: &[Option<usize>; 6], rules: &FileRules) -> Result<Row<'a>, LineFault> {
        let [time, name, ahead, speed, gap, s] = *places;
        let (vehicle, leader) = (if name.is_some() { self.at(name) } else { "1" }, self.at(ahead));
        if vehicle.is_empty() || vehicle == leader {
            let what = format!("vehicle \"{vehicle}\" with leader \"{leader}\"");
            return Err((self.line, what, "give each vehicle a name, and another vehicle as its leader".to_owned()));
        }
        // A log with positions needs no gaps.
        let has_gap = !leader.is_empty() && (gap.is_some() || rules.required.contains(&"gap_m"));
        Ok(Row {
            line: self.line,
            time_s: self.number(time, NAMES[0][0], TIMES_S)?,
            vehicle,
            leader,
            speed_mps: self.number(speed, NAMES[3][0], rules.speeds_mps)?,
            gap_m: has_gap.then(|| self.number(gap, NAMES[4][0], GAPS_M)).transpose()?,
            s_m: s.map(|_| self.number(s, NAMES[5][0], rules.places_m)).transpose()?,
        })
    }

    fn of_platoon<'b>(
        &self,
        time_at: usize,
        own: &'b PlatoonVehicle,
        leader: &'b str,
        rules: &FileRules,
    ) -> Result<Row<'b>, LineFault> {
        let gap = |at: usize| self.number(Some(at), &format!("gap{}_m", &own.name[1..]), GAPS_M);
        Ok(Row {
            line: self.line,
            time_s: self.number(Some(time_at), "t_s", TIMES_S)?,
            vehicle: &own.name,
            leader,
            speed_mps: self.number(Some(own.speed_at), &own.speed, rules.speeds_mps)?,
            gap_m: own.gap_at.map(gap).transpose()?,
            s_m: None,
        })
    }
}
