//! Parameters of controllers as a list: key, meaning, unit, limits, and the range that a search goes through. In: a
//! controller's numbers. Out: whether they are allowed, and the nearest that are.

/// One number that a controller is set to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Key in the file; an entry of a list has its number behind a dot, from 0: `dx0_m.1`.
    pub key: &'static str,
    /// What it is, one phrase.
    pub doc: &'static str,
    /// Unit, empty if it has none.
    pub unit: &'static str,
    /// Lowest and highest value that a file may have.
    pub limits: [f64; 2],
    /// Lowest and highest value that a search tries; within the limits.
    pub search: [f64; 2],
    /// What `search` is given in.
    pub scale: SearchScale,
    /// What it must be to the parameter before it.
    pub order: Order,
}

/// What the range of a search is given in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchScale {
    /// The parameter's own unit.
    Unit,
    /// Shares of the speed at which an even ring flows, so that a search fits any ring.
    EquilibriumSpeed,
}

/// What a parameter must be to the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Anything.
    Free,
    /// Above it.
    Above,
    /// Not above it.
    NotAbove,
}

/// By how much a search keeps a parameter above the one before it, in its unit: less would divide by next to nothing.
const LEAST_STEP: f64 = 0.1;

/// What speeds have in common. A search tries up to half as much again as the even ring's speed.
pub(super) const SPEED: Parameter = Parameter {
    key: "",
    doc: "",
    unit: "m/s",
    limits: [0.0, 60.0],
    search: [0.0, 1.5],
    scale: SearchScale::EquilibriumSpeed,
    order: Order::Free,
};

/// What gains have in common.
pub(super) const GAIN: Parameter = Parameter {
    key: "",
    doc: "",
    unit: "",
    limits: [-100.0, 100.0],
    search: [-1.0, 1.0],
    scale: SearchScale::Unit,
    order: Order::Free,
};

impl Parameter {
    /// The key in the file, without the number of an entry of a list.
    pub fn table_key(&self) -> &'static str {
        self.key.split_once('.').map_or(self.key, |(key, _)| key)
    }

    /// The entry of a list that it is, from 0.
    pub fn entry(&self) -> Option<usize> {
        self.key.split_once('.').and_then(|(_, entry)| entry.parse().ok())
    }

    /// What is allowed, in words.
    pub fn allowed(&self) -> String {
        let [low, high] = self.limits;
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        format!("a number from {low} to {high}{unit}")
    }

    /// True within the limits; never for what is not finite.
    pub fn allows(&self, value: f64) -> bool {
        (self.limits[0]..=self.limits[1]).contains(&value)
    }

    /// True if the order to the parameter before it holds.
    pub fn follows(&self, before: f64, value: f64) -> bool {
        match self.order {
            Order::Free => true,
            Order::Above => value > before,
            Order::NotAbove => value <= before,
        }
    }

    /// Lowest and highest value that a search tries on a ring that flows evenly at `equilibrium_mps`.
    pub fn search_range(&self, equilibrium_mps: f64) -> [f64; 2] {
        let scale = match self.scale {
            SearchScale::Unit => 1.0,
            SearchScale::EquilibriumSpeed => equilibrium_mps,
        };
        self.search.map(|end| (end * scale).clamp(self.limits[0], self.limits[1]))
    }

    /// The value nearest to this one that keeps the order.
    fn ordered(&self, before: f64, value: f64) -> f64 {
        match self.order {
            Order::Free => value,
            Order::Above => value.max(before + LEAST_STEP),
            Order::NotAbove => value.min(before),
        }
    }
}

/// A controller that is a row of numbers.
pub(super) trait Parametric {
    /// What each number is.
    const PARAMETERS: &'static [Parameter];

    /// The numbers, as many as there are parameters.
    fn numbers(&self) -> Vec<f64>;

    /// The controller of as many numbers.
    fn of(numbers: &[f64]) -> Self;
}

/// These numbers with each raised or lowered until it keeps the order to the one before it.
pub(super) fn ordered(parameters: &[Parameter], numbers: &[f64]) -> Vec<f64> {
    let mut kept: Vec<f64> = Vec::with_capacity(numbers.len());
    for (parameter, value) in parameters.iter().zip(numbers) {
        let value = kept.last().map_or(*value, |before| parameter.ordered(*before, *value));
        kept.push(value);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_order_are_moved_as_little_as_keeps_it() {
        let above = Parameter { order: Order::Above, ..GAIN };
        let not_above = Parameter { order: Order::NotAbove, ..GAIN };
        let moved = |parameter, numbers: [f64; 3]| ordered(&[GAIN, parameter, parameter], &numbers);
        assert_eq!(moved(above, [1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
        assert_eq!(moved(above, [2.0, 1.0, 1.5]), [2.0, 2.1, 2.2]);
        assert_eq!(moved(not_above, [1.0, 2.0, 0.5]), [1.0, 1.0, 0.5]);
        assert_eq!(moved(GAIN, [3.0, 1.0, 2.0]), [3.0, 1.0, 2.0]);
    }

    #[test]
    fn speeds_are_searched_in_shares_of_the_even_rings_speed_and_within_the_limits() {
        assert_eq!(SPEED.search_range(4.0), [0.0, 6.0]);
        assert_eq!(SPEED.search_range(50.0), [0.0, 60.0]);
        assert_eq!(GAIN.search_range(50.0), [-1.0, 1.0]);
    }
}
