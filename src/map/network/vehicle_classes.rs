//! Vehicle classes that may use a lane. In: SUMO's lists of vehicle classes (`allow`, `disallow`). Out: a set. The classes and their
//! names follow SUMO 1.28 (sumo.dlr.de, "Abstract Vehicle Class", EPL-2.0).

/// SUMO's classes; the index in this list is the bit.
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

/// Names in old networks with their current names.
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

/// Set of SUMO's vehicle classes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VehicleClasses(u64);

impl VehicleClasses {
    pub const NONE: Self = Self(0);
    pub const ALL: Self = Self((1 << NAMES.len()) - 1);
    pub const PASSENGER: Self = Self(bit("passenger"));
    /// Buses in public transport.
    pub const BUS: Self = Self(bit("bus"));
    pub const MOTORCYCLE: Self = Self(bit("motorcycle"));
    pub const BICYCLE: Self = Self(bit("bicycle"));
    pub const PEDESTRIAN: Self = Self(bit("pedestrian"));
    /// Ambulances and fire engines, for example.
    pub const EMERGENCY: Self = Self(bit("emergency"));
    /// All classes of rail vehicles.
    pub const RAIL: Self = Self(
        bit("tram")
            | bit("rail_urban")
            | bit("rail")
            | bit("rail_electric")
            | bit("rail_fast")
            | bit("subway")
            | bit("cable_car"),
    );
    /// All classes of motor vehicles on roads.
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

    /// Parses a list of SUMO's class names separated by spaces; `all` is every class. Unknown names are ignored, as in SUMO: networks of
    /// later versions may have further classes.
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

    /// Returns true if every class of `other` is in this set.
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Returns true if the sets have a class in common.
    pub fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Returns the classes in both sets.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Returns the classes of this set that are not in the other.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Returns true if the set has no class.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns SUMO's names of the classes, in the order of SUMO's list.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        NAMES.iter().enumerate().filter(move |(k, _)| self.0 & (1 << k) != 0).map(|(_, name)| *name)
    }

    /// Returns the set as SUMO writes it: `all`, or names separated by spaces.
    pub fn list(self) -> String {
        if self == Self::ALL { "all".into() } else { self.names().collect::<Vec<_>>().join(" ") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_sets_and_names_of_old_networks_are_translated() {
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
