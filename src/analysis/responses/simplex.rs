//! Minimum of a function without derivatives. In: a function of a few numbers, a start and steps. Out: the place of the
//! minimum, by the simplex of Nelder and Mead (1965).

/// Largest number of rounds.
const ROUNDS: usize = 2000;
/// Relative difference between the costs of the corners below which the search ends.
const TOLERANCE: f64 = 1e-11;

/// Minimises `cost` from `start`, with first corners `steps` away; returns the place and its cost.
pub(super) fn least<const N: usize>(
    cost: impl Fn(&[f64; N]) -> f64,
    start: [f64; N],
    steps: [f64; N],
) -> ([f64; N], f64) {
    let mut corners: Vec<(f64, [f64; N])> = vec![(cost(&start), start)];
    for k in 0..N {
        let mut at = start;
        at[k] += steps[k];
        corners.push((cost(&at), at));
    }
    for _ in 0..ROUNDS {
        corners.sort_by(|a, b| a.0.total_cmp(&b.0));
        let worst = corners[N];
        if worst.0 - corners[0].0 < TOLERANCE * (1.0 + corners[0].0.abs()) {
            break;
        }
        let middle: [f64; N] = std::array::from_fn(|k| corners[..N].iter().map(|c| c.1[k]).sum::<f64>() / N as f64);
        let beyond = |way: f64| {
            let at: [f64; N] = std::array::from_fn(|k| middle[k] + way * (middle[k] - worst.1[k]));
            (cost(&at), at)
        };
        let reflected = beyond(1.0);
        let next = if reflected.0 < corners[0].0 {
            Some(beyond(2.0)).filter(|far| far.0 < reflected.0).or(Some(reflected))
        } else if reflected.0 < corners[N - 1].0 {
            Some(reflected)
        } else {
            let inner = beyond(if reflected.0 < worst.0 { 0.5 } else { -0.5 });
            Some(inner).filter(|inner| inner.0 < worst.0.min(reflected.0))
        };
        match next {
            Some(next) => corners[N] = next,
            None => {
                let best = corners[0].1;
                for corner in &mut corners[1..] {
                    corner.1 = std::array::from_fn(|k| 0.5 * (best[k] + corner.1[k]));
                    corner.0 = cost(&corner.1);
                }
            }
        }
    }
    corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    (corners[0].1, corners[0].0)
}
