//! Parameters of controllers as a list: key, meaning, unit, limits and search range. In: a controller's numbers. Out: a check against the
//! limits, and the nearest numbers in order.

/// Description of one number of a controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Key in the file; an entry of a list has a dot and its index from 0: `dx0_m.1`.
    pub key: &'static str,
    /// Description in one phrase, for files and messages.
    pub doc: &'static str,
    /// Unit; empty if dimensionless.
    pub unit: &'static str,
    /// Lowest and highest value allowed in a file.
    pub limits: [f64; 2],
    /// Lowest and highest value in a search, within the limits.
    pub search: [f64; 2],
    /// Scale in which `search` is given.
    pub scale: SearchScale,
    /// Required order relative to the previous parameter.
    pub order: Order,
}

/// Scale of a search range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchScale {
    /// Unit of the parameter itself.
    Unit,
    /// Multiples of the ring's equilibrium speed, so that a search fits any ring.
    EquilibriumSpeed,
}

/// Required order of a parameter relative to the previous one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// No order is required.
    Free,
    /// Above the previous parameter.
    Above,
    /// At most the previous parameter.
    NotAbove,
}

/// Distance that a search keeps above the previous parameter, in the parameter's unit; avoids a division by almost 0.
const LEAST_STEP: f64 = 0.1;

/// Template for speeds, searched up to 1.5 times the equilibrium speed of the ring.
pub(super) const SPEED: Parameter = Parameter {
    key: "",
    doc: "",
    unit: "m/s",
    limits: [0.0, 60.0],
    search: [0.0, 1.5],
    scale: SearchScale::EquilibriumSpeed,
    order: Order::Free,
};

/// Template for gains, searched from -1 to 1.
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
    /// Returns the key in the file, without the index of a list entry.
    pub fn table_key(&self) -> &'static str {
        self.key.split_once('.').map_or(self.key, |(key, _)| key)
    }

    /// Returns the index in a list, from 0; `None` if the parameter is not in a list.
    pub fn entry(&self) -> Option<usize> {
        self.key.split_once('.').and_then(|(_, entry)| entry.parse().ok())
    }

    /// Returns the allowed values in words.
    pub fn allowed(&self) -> String {
        let [low, high] = self.limits;
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        format!("a number from {low} to {high}{unit}")
    }

    /// Returns true if the value is within the limits; NaN never is.
    pub fn allows(&self, value: f64) -> bool {
        (self.limits[0]..=self.limits[1]).contains(&value)
    }

    /// Returns true if the order relative to the previous parameter holds.
    pub fn follows(&self, before: f64, value: f64) -> bool {
        match self.order {
            Order::Free => true,
            Order::Above => value > before,
            Order::NotAbove => value <= before,
        }
    }

    /// Returns the lowest and the highest value of a search on a ring with this equilibrium speed.
    pub fn search_range(&self, equilibrium_mps: f64) -> [f64; 2] {
        let scale = match self.scale {
            SearchScale::Unit => 1.0,
            SearchScale::EquilibriumSpeed => equilibrium_mps,
        };
        self.search.map(|end| (end * scale).clamp(self.limits[0], self.limits[1]))
    }

    /// Returns the nearest value that keeps the order.
    fn ordered(&self, before: f64, value: f64) -> f64 {
        match self.order {
            Order::Free => value,
            Order::Above => value.max(before + LEAST_STEP),
            Order::NotAbove => value.min(before),
        }
    }
}

/// A controller that is defined by a list of numbers.
pub(super) trait Parametric {
    /// Descriptions of the numbers, in order.
    const PARAMETERS: &'static [Parameter];

    /// Returns the numbers, one per parameter.
    fn numbers(&self) -> Vec<f64>;

    /// Returns the controller with these numbers.
    fn of(numbers: &[f64]) -> Self;
}

/// Returns the numbers, each raised or lowered until it keeps the order relative to the previous one.
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
    fn numbers_out_of_order_move_by_the_least_amount() {
        let above = Parameter { order: Order::Above, ..GAIN };
        let not_above = Parameter { order: Order::NotAbove, ..GAIN };
        let moved = |parameter, numbers: [f64; 3]| ordered(&[GAIN, parameter, parameter], &numbers);
        assert_eq!(moved(above, [1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
        assert_eq!(moved(above, [2.0, 1.0, 1.5]), [2.0, 2.1, 2.2]);
        assert_eq!(moved(not_above, [1.0, 2.0, 0.5]), [1.0, 1.0, 0.5]);
        assert_eq!(moved(GAIN, [3.0, 1.0, 2.0]), [3.0, 1.0, 2.0]);
    }

    #[test]
    fn speeds_are_searched_in_multiples_of_equilibrium_within_the_limits() {
        assert_eq!(SPEED.search_range(4.0), [0.0, 6.0]);
        assert_eq!(SPEED.search_range(50.0), [0.0, 60.0]);
        assert_eq!(GAIN.search_range(50.0), [-1.0, 1.0]);
    }
}
