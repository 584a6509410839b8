//! Orders of the conditions. In: a design, the number of conditions, the participant's number. Out: a permutation. A balanced design
//! repeats after a whole square, in which every order has come equally often.

use crate::rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Design of the orders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OrderDesign {
    /// Balanced Latin square (Williams 1949): each condition equally often at each place, and equally often right after each other one.
    #[default]
    Williams,
    /// All orders in turn (full counterbalance).
    Full,
    /// Blocks of as many participants as there are conditions; within a block, each condition comes once at each place.
    Block,
    /// Order of the study file, for every participant.
    Fixed,
}

/// Maximum number of conditions of a full counterbalance: 720 orders.
pub const MOST_FULL: usize = 6;

impl OrderDesign {
    /// Returns the number of participants after which every order has come equally often.
    pub fn period(self, conditions: usize) -> usize {
        match self {
            Self::Williams if conditions < 3 => conditions.max(1),
            Self::Williams => conditions * (1 + conditions % 2),
            Self::Full => (1..=conditions).product(),
            Self::Block => conditions.max(1),
            Self::Fixed => 1,
        }
    }

    /// Returns the order for participant number `index` (from 0): a permutation of `0..conditions`.
    pub fn order(self, conditions: usize, index: usize, seed: u64) -> Vec<usize> {
        match self {
            Self::Fixed => (0..conditions).collect(),
            Self::Williams => williams(conditions, index % self.period(conditions)),
            Self::Full => nth_permutation(conditions, index % self.period(conditions)),
            Self::Block => {
                // A cyclic square; its rows and the labels of the conditions are drawn anew for each block.
                let (block, row) = (index / conditions.max(1), index % conditions.max(1));
                let mut random = rng::stream(seed, &format!("order {block}"));
                let words = random.permutation(conditions);
                let rows = random.permutation(conditions);
                (0..conditions).map(|place| words[(rows[row] + place) % conditions]).collect()
            }
        }
    }
}

/// Returns a row of Williams' square: 0, 1, n-1, 2, n-2, ... plus the row number, modulo n. For odd n, rows from n on are reversed.
fn williams(n: usize, row: usize) -> Vec<usize> {
    let shift = row % n.max(1);
    let zigzag = (0..n).map(|place| if place % 2 == 1 { place.div_ceil(2) } else { (n - place / 2) % n });
    let order: Vec<usize> = zigzag.map(|word| (word + shift) % n).collect();
    if row < n { order } else { order.into_iter().rev().collect() }
}

/// Returns the permutation number `index` in lexical order.
fn nth_permutation(n: usize, mut index: usize) -> Vec<usize> {
    let mut left: Vec<usize> = (0..n).collect();
    (0..n)
        .map(|place| {
            let block: usize = (1..n - place).product();
            let at = index / block;
            index %= block;
            left.remove(at)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::{BTreeMap, BTreeSet};

    fn orders(design: OrderDesign, n: usize, participants: usize) -> Vec<Vec<usize>> {
        (0..participants).map(|index| design.order(n, index, 7)).collect()
    }

    /// Counts how often each condition comes at each place.
    fn places(orders: &[Vec<usize>]) -> BTreeMap<(usize, usize), usize> {
        let mut counts = BTreeMap::new();
        for order in orders {
            for (place, word) in order.iter().enumerate() {
                *counts.entry((place, *word)).or_default() += 1;
            }
        }
        counts
    }

    #[test]
    fn williams_square_balances_places_and_predecessors() {
        for n in 2..=9 {
            let period = OrderDesign::Williams.period(n);
            let orders = orders(OrderDesign::Williams, n, period);
            let counts = places(&orders);
            assert!(counts.len() == n * n && counts.values().all(|count| *count == period / n), "{n}: {counts:?}");
            let mut after: BTreeMap<(usize, usize), usize> = BTreeMap::new();
            for order in &orders {
                order.windows(2).for_each(|pair| *after.entry((pair[0], pair[1])).or_default() += 1);
            }
            let every = after.values().next().copied();
            assert!(after.len() == n * (n - 1) && after.values().all(|count| Some(*count) == every), "{n}: {after:?}");
        }
        assert_eq!((OrderDesign::Williams.period(3), OrderDesign::Williams.period(4)), (6, 4));
        // Square of order four as printed in textbooks.
        assert_eq!(orders(OrderDesign::Williams, 4, 4), [[0, 1, 3, 2], [1, 2, 0, 3], [2, 3, 1, 0], [3, 0, 2, 1]]);
    }

    #[test]
    fn every_participant_meets_every_condition_once_in_every_design() {
        for design in [OrderDesign::Williams, OrderDesign::Full, OrderDesign::Block, OrderDesign::Fixed] {
            for n in 1..=6 {
                for mut order in orders(design, n, 4 * n) {
                    order.sort_unstable();
                    assert_eq!(order, (0..n).collect::<Vec<_>>(), "{design:?} of {n}");
                }
            }
        }
    }

    #[test]
    fn a_full_counterbalance_has_every_order_once() {
        for n in 1..=5 {
            let period = OrderDesign::Full.period(n);
            let all: BTreeSet<Vec<usize>> = orders(OrderDesign::Full, n, period).into_iter().collect();
            assert_eq!(all.len(), period);
        }
    }

    #[test]
    fn every_block_has_every_condition_once_at_every_place() {
        let orders = orders(OrderDesign::Block, 4, 20);
        for block in orders.chunks(4) {
            assert!(places(block).len() == 16, "{block:?}");
        }
        let first: BTreeSet<_> = orders.chunks(4).map(|block| block[0].clone()).collect();
        assert!(first.len() > 1, "blocks are drawn, not repeated");
        assert_eq!(orders[3], OrderDesign::Block.order(4, 3, 7), "the same for the same seed");
    }

    #[test]
    fn one_condition_or_a_fixed_order_gives_one_order_for_all() {
        for design in [OrderDesign::Williams, OrderDesign::Full, OrderDesign::Block, OrderDesign::Fixed] {
            assert_eq!(design.order(1, 5, 1), [0]);
        }
        assert_eq!(OrderDesign::Fixed.order(3, 8, 1), [0, 1, 2]);
        // With one condition or none there is a single order, the same for every participant.
        let periods = |n| {
            [OrderDesign::Williams, OrderDesign::Full, OrderDesign::Block, OrderDesign::Fixed]
                .map(|design| design.period(n))
        };
        assert_eq!((periods(0), periods(1)), ([1; 4], [1; 4]));
        assert_eq!((periods(2), periods(5)), ([2, 2, 2, 1], [10, 120, 5, 1]));
    }
}
