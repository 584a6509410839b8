//! Limits of circuits, and faults of lists of pieces that make none. Metres; angles in degrees.

/// Longest circuit, metres. Points are 1 m apart and are compared pairwise.
pub(super) const LONGEST_M: f64 = 20_000.0;
/// Largest number of pieces, see [`LONGEST_M`].
pub(super) const MOST_PIECES: usize = 200;
/// Shortest piece, metres: two cars.
pub(super) const SHORTEST_M: f64 = 10.0;

/// Fault of a list of pieces that does not make a road; pieces are counted from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CircuitFault {
    /// Number of pieces beyond the limit.
    #[error("there are {0} pieces; allowed: at most {MOST_PIECES}")]
    ManyPieces(usize),
    /// Circuit beyond the longest length.
    #[error("the circuit is {length_m:.0} m long; allowed: at most {LONGEST_M} m")]
    TooLong {
        /// Length of the circuit, metres.
        length_m: f64,
    },
    /// Bends that do not add up to one full turn.
    #[error("the bends turn by {turn_deg} degrees in all; allowed: 360 or -360")]
    Open {
        /// Total turn of the bends, degrees.
        turn_deg: f64,
    },
    /// Number of pieces with `solved = true` that is not two.
    #[error("{0} pieces have solved = true; allowed: 2")]
    NotTwoSolved(usize),
    /// Solved straights of nearly equal direction: no lengths close the circuit.
    #[error("the solved straights, pieces {} and {}, are nearly parallel", pieces[0], pieces[1])]
    Parallel {
        /// Numbers of the two straights.
        pieces: [usize; 2],
    },
    /// Solved straight that would be shorter than the shortest piece, or of negative length.
    #[error(
        "piece {piece} would have to be {length_m:.1} m long to close the circuit; allowed: at least {SHORTEST_M} m: \
         lengthen pieces that lead the other way"
    )]
    TooShort {
        /// Number of the straight.
        piece: usize,
        /// Length that closes the circuit, metres.
        length_m: f64,
    },
    /// Parts of the road that come too close to each other.
    #[error(
        "pieces {} and {} come within {apart_m:.1} m of each other; allowed: centre lines at least {wanted_m:.1} m \
         apart",
        pieces[0], pieces[1]
    )]
    TooClose {
        /// Numbers of the two pieces.
        pieces: [usize; 2],
        /// Distance between the centre lines, metres.
        apart_m: f64,
        /// Smallest distance allowed, metres.
        wanted_m: f64,
    },
}
