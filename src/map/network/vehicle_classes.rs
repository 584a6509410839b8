//! Who may drive on a lane. In: SUMO's lists of vehicle classes (`allow`, `disallow`). Out: a set. The classes and their words are
//! those of SUMO 1.28 (sumo.dlr.de, "Abstract Vehicle Class", EPL-2.0).

/// SUMO's classes; the place in this list is the bit.
const NAMES: [&str; 33] = [
    "private",
    "emergency",
    "authority",
    "army",
    "vip",
    "pedestrian",
    "passenger",
    "hov",
    "taxi",
    "bus",
    "coach",
    "delivery",
    "truck",
    "trailer",
    "motorcycle",
    "moped",
    "bicycle",
    "evehicle",
    "tram",
    "rail_urban",
    "rail",
    "rail_electric",
    "rail_fast",
    "ship",
    "container",
    "cable_car",
    "subway",
    "aircraft",
    "wheelchair",
    "scooter",
    "drone",
    "custom1",
    "custom2",
];

/// Words of old networks and what they are today.
const OLD_NAMES: [(&str, &str); 8] = [
    ("public_emergency", "emergency"),
    ("public_authority", "authority"),
    ("public_army", "army"),
    ("public_transport", "bus"),
    ("transport", "truck"),
    ("lightrail", "tram"),
    ("cityrail", "rail_urban"),
    ("rail_slow", "rail"),
];

const fn bit(name: &str) -> u64 {
    let mut k = 0;
    while k < NAMES.len() {
        if equal(NAMES[k].as_bytes(), name.as_bytes()) {
            return 1 << k;
        }
        k += 1;
    }
    panic!("no class of SUMO has this name");
}

const fn equal(a: &[u8], b: &[u8]) -> bool {
    let mut k = 0;
    while k < a.len() && k < b.len() {
        if a[k] != b[k] {
            return false;
        }
        k += 1;
    }
    a.len() == b.len()
}

/// A set of SUMO's vehicle classes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VehicleClasses(u64);

impl VehicleClasses {
    /// No class.
    pub const NONE: Self = Self(0);
    /// Every class.
    pub const ALL: Self = Self((1 << NAMES.len()) - 1);
    /// Cars.
    pub const PASSENGER: Self = Self(bit("passenger"));
    /// Buses of a line.
    pub const BUS: Self = Self(bit("bus"));
    /// Motorcycles.
    pub const MOTORCYCLE: Self = Self(bit("motorcycle"));
    /// Bicycles.
    pub const BICYCLE: Self = Self(bit("bicycle"));
    /// People on foot.
    pub const PEDESTRIAN: Self = Self(bit("pedestrian"));
    /// Ambulances, fire engines.
    pub const EMERGENCY: Self = Self(bit("emergency"));
    /// All that runs on rails.
    pub const RAIL: Self = Self(
        bit("tram")
            | bit("rail_urban")
            | bit("rail")
            | bit("rail_electric")
            | bit("rail_fast")
            | bit("subway")
            | bit("cable_car"),
    );
    /// All with an engine on a road.
    pub const ROAD_MOTOR: Self = Self(
        bit("private")
            | bit("emergency")
            | bit("authority")
            | bit("army")
            | bit("vip")
            | bit("passenger")
            | bit("hov")
            | bit("taxi")
            | bit("bus")
            | bit("coach")
            | bit("delivery")
            | bit("truck")
            | bit("trailer")
            | bit("motorcycle")
            | bit("moped")
            | bit("evehicle"),
    );

    /// The set of a list of SUMO's words with spaces between; `all` is every class. A word that is no class stands for none, as
    /// SUMO has it: networks of later versions know more.
    pub fn parse(list: &str) -> Self {
        let mut set = 0;
        for word in list.split_whitespace() {
            let today = OLD_NAMES.iter().find(|(old, _)| *old == word).map_or(word, |(_, today)| today);
            match NAMES.iter().position(|name| *name == today) {
                Some(k) => set |= 1 << k,
                None if word == "all" => set = Self::ALL.0,
                None => {}
            }
        }
        Self(set)
    }

    /// True if every class of `other` is in this set.
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// True if some class is in both.
    pub fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// The classes that are in both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// The classes of this set that are not in the other.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// True of no class.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// SUMO's words, in the order of its list.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        NAMES.iter().enumerate().filter(move |(k, _)| self.0 & (1 << k) != 0).map(|(_, name)| *name)
    }

    /// The set as SUMO writes it: `all`, or words with spaces between.
    pub fn list(self) -> String {
        if self == Self::ALL { "all".into() } else { self.names().collect::<Vec<_>>().join(" ") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_sets_and_words_of_old_networks_are_todays() {
        let set = VehicleClasses::parse("bus passenger");
        assert!(set.contains(VehicleClasses::BUS) && set.contains(VehicleClasses::PASSENGER));
        assert!(!set.intersects(VehicleClasses::PEDESTRIAN));
        assert_eq!(set.list(), "passenger bus");
        assert_eq!(VehicleClasses::parse("all"), VehicleClasses::ALL);
        assert_eq!(VehicleClasses::ALL.list(), "all");
        assert_eq!(VehicleClasses::parse(""), VehicleClasses::NONE);
        assert_eq!(VehicleClasses::parse("transport"), VehicleClasses::parse("truck"));
        assert_eq!(VehicleClasses::parse("bus passanger"), VehicleClasses::BUS);
        let motor = VehicleClasses::ALL.without(VehicleClasses::ROAD_MOTOR);
        assert!(motor.contains(VehicleClasses::RAIL) && motor.contains(VehicleClasses::BICYCLE));
    }
}
