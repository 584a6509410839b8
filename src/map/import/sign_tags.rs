//! Road signs that the tags of a node of OpenStreetMap state (`docs/references.md: roads`). In: tags. Out: [`NodeSigns`], with the values
//! of signs that codrive does not draw.

use super::osm_elements::value;
use crate::map::surroundings::{StatedSign, StatedSignKind, older_limit};

/// Least number of a plate below a sign, which says when or for whom the sign holds.
const PLATE: u32 = 1000;
/// Length of the longest value that the report names, characters.
const MOST_VALUE: usize = 30;
/// Points of the compass, from north by 22.5 degrees.
const COMPASS: [&str; 16] =
    ["N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE", "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW"];

/// Direction of travel for which a sign holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum HoldsFor {
    /// Direction of the way that the node is on.
    Forward,
    Backward,
    Both,
    /// Sign that faces in this direction, radians counter-clockwise from east.
    Facing(f64),
    Unstated,
}

impl HoldsFor {
    fn of(text: &str) -> Self {
        let point = || COMPASS.iter().position(|point| point.eq_ignore_ascii_case(text)).map(|k| 22.5 * k as f64);
        let degrees = || text.trim_end_matches('°').parse::<f64>().ok().filter(|deg| deg.abs() <= 360.0);
        match text {
            "forward" => Self::Forward,
            "backward" => Self::Backward,
            "both" => Self::Both,
            _ => match point().or_else(degrees) {
                Some(angle_deg) => Self::Facing(StatedSign::facing_rad(angle_deg)),
                None => Self::Unstated,
            },
        }
    }
}

/// Signs of a node.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct NodeSigns {
    /// Signs from top to bottom, each with those for whom it holds.
    pub signs: Vec<(StatedSignKind, HoldsFor)>,
    /// Values of signs that are not drawn.
    pub others: Vec<String>,
}

impl NodeSigns {
    /// Returns the signs of a node; `place` is the name that signs of the place show. `None` for a node without signs.
    pub fn of(tags: &[(String, String)], place: Option<&str>) -> Option<Self> {
        let of = |key: &str| value(tags, key);
        let stated = of("traffic_sign:direction").or(of("direction")).map_or(HoldsFor::Unstated, HoldsFor::of);
        let mut found = Self::default();
        let keys = [
            ("traffic_sign", stated),
            ("traffic_sign:forward", HoldsFor::Forward),
            ("traffic_sign:backward", HoldsFor::Backward),
        ];
        let facts = NodeFacts {
            limit: of("maxspeed").and_then(limit),
            is_place: place.is_some() && of("name") == place && of("city_limit") != Some("end"),
        };
        for (key, holds) in keys {
            of(key).into_iter().for_each(|text| found.add(text, holds, facts));
        }
        let at_node = match of("highway") {
            Some("stop") => Some(StatedSignKind::Stop),
            Some("give_way") => Some(StatedSignKind::Yield),
            _ => None,
        };
        if let Some(kind) = at_node.filter(|kind| !found.signs.iter().any(|(of, _)| of == kind)) {
            found.signs.insert(0, (kind, stated));
        }
        (!found.signs.is_empty() || !found.others.is_empty()).then_some(found)
    }

    /// Adds the signs of a value, such as `DE:274-30,1040-30;DE:206` or `stop`.
    fn add(&mut self, text: &str, holds: HoldsFor, facts: NodeFacts) {
        let mut is_german = false;
        // The last sign, if a plate below it may restrict it: its index and value.
        let mut limit: Option<(usize, String)> = None;
        for token in tokens(text) {
            let country = token.split_once(':').filter(|(country, _)| country.chars().all(char::is_alphabetic));
            let code = match country {
                Some((country, code)) => {
                    is_german = country.eq_ignore_ascii_case("DE");
                    code.trim()
                }
                None => token,
            };
            let begins_with_digit = code.starts_with(|c: char| c.is_ascii_digit());
            let kind = match begins_with_digit {
                true if is_german => by_number(code, facts),
                true => None,
                false => by_word(code, facts),
            };
            let value = || shown(if is_german && begins_with_digit { format!("DE:{code}") } else { token.to_owned() });
            match kind {
                Some(kind) => {
                    let is_limit = matches!(kind, StatedSignKind::SpeedLimit(_));
                    limit = is_limit.then(|| (self.signs.len(), value()));
                    self.signs.push((kind, holds));
                }
                None => {
                    // A limit that holds at times, or for some, is not shown as one that always holds.
                    let is_plate = is_german && number(code).0.parse().is_ok_and(|number: u32| number >= PLATE);
                    if let Some((index, value)) = limit.take_if(|_| is_plate) {
                        self.signs.remove(index);
                        self.others.push(value);
                    }
                    self.others.push(value());
                }
            }
        }
    }
}

/// Other tags of a node that say what its signs show.
#[derive(Clone, Copy)]
struct NodeFacts {
    /// Value of `maxspeed`.
    limit: Option<f64>,
    /// True if the node's name is that of the place.
    is_place: bool,
}

/// Returns the parts of a value, which `,` and `;` separate outside of brackets.
fn tokens(text: &str) -> impl Iterator<Item = &str> {
    let mut depth = 0;
    let separates = move |c: char| {
        depth += i32::from(c == '[') - i32::from(c == ']');
        depth <= 0 && (c == ',' || c == ';')
    };
    text.split(separates).map(str::trim).filter(|token| !token.is_empty())
}

/// Returns the number of a German sign, and what stands behind it: `274-30`, `274[30]` and `274.1` have the numbers 274, 274 and 274.1.
fn number(code: &str) -> (&str, Option<f64>) {
    match code.split_once(['-', '[']) {
        Some((number, shown)) => (number, shown.trim_end_matches(']').trim().parse().ok()),
        None => (code, None),
    }
}

fn by_number(code: &str, facts: NodeFacts) -> Option<StatedSignKind> {
    let (number, shown) = number(code);
    // 274-60 is 60 km/h in the numbering of today and 100 km/h in the older one, in which all others end with other digits than 0.
    let older = shown.filter(|shown| shown % 10.0 != 0.0).and_then(older_limit);
    let certain = older.or(shown.filter(|shown| *shown != 60.0));
    let kind = StatedSignKind::of(number, certain.or(facts.limit).or(shown));
    kind.filter(|kind| *kind != StatedSignKind::PlaceName || facts.is_place)
}

fn by_word(word: &str, facts: NodeFacts) -> Option<StatedSignKind> {
    match word {
        "stop" => Some(StatedSignKind::Stop),
        "give_way" | "yield" => Some(StatedSignKind::Yield),
        "maxspeed" => StatedSignKind::of("274", facts.limit),
        "city_limit" => facts.is_place.then_some(StatedSignKind::PlaceName),
        _ => None,
    }
}

/// Returns the number of a speed limit, km/h or mph.
fn limit(text: &str) -> Option<f64> {
    text.trim_end_matches("mph").trim_end().parse().ok()
}

fn shown(value: String) -> String {
    value.chars().filter(|c| !c.is_control()).take(MOST_VALUE).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use StatedSignKind::{PlaceName, Priority, Roundabout, SpeedLimit, Stop, Yield, Zebra};
    use std::f64::consts::{FRAC_PI_2, PI};

    fn of(tags: &[[&str; 2]]) -> NodeSigns {
        let tags: Vec<(String, String)> = tags.iter().map(|[key, value]| ((*key).into(), (*value).into())).collect();
        NodeSigns::of(&tags, Some("Rain & Sun")).unwrap_or_default()
    }

    fn kinds(tags: &[[&str; 2]]) -> Vec<StatedSignKind> {
        of(tags).signs.iter().map(|(kind, _)| *kind).collect()
    }

    #[test]
    fn values_of_traffic_sign_give_the_signs_that_they_name() {
        // By the German catalogue of signs and the wiki of OpenStreetMap, "Key:traffic_sign".
        let cases: [(&str, &[StatedSignKind]); 13] = [
            ("DE:206", &[Stop]),
            ("DE:205", &[Yield]),
            ("stop", &[Stop]),
            ("give_way", &[Yield]),
            ("DE:274-50", &[SpeedLimit(50)]),
            ("DE:274[70]", &[SpeedLimit(70)]),
            ("DE:274-53", &[SpeedLimit(30)]),
            ("DE:205,215", &[Yield, Roundabout]),
            ("DE:350;DE:274-30", &[Zebra, SpeedLimit(30)]),
            ("de:306 ; DE:274-100", &[Priority, SpeedLimit(100)]),
            ("hazard,stop", &[Stop]),
            ("206", &[]),
            ("US:206", &[]),
        ];
        for (value, expected) in cases {
            assert_eq!(kinds(&[["traffic_sign", value]]), expected, "{value}");
        }
        assert_eq!(kinds(&[["traffic_sign", "maxspeed"], ["maxspeed", "30 mph"]]), [SpeedLimit(30)]);
        assert_eq!(kinds(&[["traffic_sign", "DE:274"], ["maxspeed", "80"]]), [SpeedLimit(80)]);
        assert_eq!(
            kinds(&[["traffic_sign", "DE:274-80;DE:274-50"], ["maxspeed", "80"]]),
            [SpeedLimit(80), SpeedLimit(50)]
        );
        // The older number of 100 km/h is today's of 60 km/h.
        assert_eq!(kinds(&[["traffic_sign", "DE:274-60"], ["maxspeed", "100"]]), [SpeedLimit(100)]);
        assert_eq!(kinds(&[["traffic_sign", "DE:274-60"]]), [SpeedLimit(60)]);
        assert_eq!(kinds(&[["traffic_sign", "city_limit"], ["name", "Rain & Sun"]]), [PlaceName]);
        assert_eq!(kinds(&[["traffic_sign", "DE:310"], ["name", "Elsewhere"]]), []);
        assert_eq!(kinds(&[["traffic_sign", "city_limit"], ["name", "Rain & Sun"], ["city_limit", "end"]]), []);
        assert_eq!(kinds(&[["highway", "give_way"]]), [Yield]);
        assert_eq!(kinds(&[["highway", "stop"], ["traffic_sign", "DE:206"]]), [Stop]);
        assert_eq!(NodeSigns::of(&[("highway".into(), "crossing".into())], None), None);
    }

    #[test]
    fn signs_that_are_not_drawn_are_named_by_their_values() {
        assert_eq!(
            of(&[["traffic_sign", "DE:283,1042[Mo,We 8:00;Fr]; hazard"]]).others,
            ["DE:283", "DE:1042[Mo,We 8:00;Fr]", "hazard"]
        );
        // A limit at night, and another that always holds.
        let found = of(&[["traffic_sign", "DE:274-30,1040-35;DE:274-50"]]);
        assert_eq!(found.others, ["DE:274-30", "DE:1040-35"]);
        assert_eq!(found.signs, [(SpeedLimit(50), HoldsFor::Unstated)]);
    }

    #[test]
    fn a_sign_holds_for_those_whom_its_tags_name() {
        let holds = |tags: &[[&str; 2]]| of(tags).signs.iter().map(|(_, holds)| *holds).collect::<Vec<_>>();
        assert_eq!(holds(&[["highway", "stop"], ["direction", "backward"]]), [HoldsFor::Backward]);
        assert_eq!(holds(&[["traffic_sign:forward", "DE:206"], ["direction", "90"]]), [HoldsFor::Forward]);
        let both = [["traffic_sign", "DE:350"], ["traffic_sign:direction", "both"], ["direction", "90"]];
        assert_eq!(holds(&both), [HoldsFor::Both]);
        // Degrees clockwise from north: west is 270.
        for (text, expected) in [("270", PI), ("W", PI), ("N", FRAC_PI_2), ("0", FRAC_PI_2)] {
            let [HoldsFor::Facing(facing_rad)] = holds(&[["traffic_sign", "stop"], ["direction", text]])[..] else {
                panic!("{text}")
            };
            assert!((facing_rad - expected).sin().abs() < 1e-9 && (facing_rad - expected).cos() > 0.0, "{text}");
        }
        assert_eq!(holds(&[["highway", "stop"], ["direction", "up"]]), [HoldsFor::Unstated]);
    }
}
