//! Words that the sections of the page share. In: links, numbers and counts. Out: text and cells of tables.

use super::page::{TableCells, short};
use crate::metrics::Estimate;

/// Largest number of conditions, or drives, beside each other in a table: more are wider than a sheet.
pub(super) const BESIDE: usize = 4;

/// Mark of a missing number.
pub(super) const NONE: &str = "–";

/// Returns links with their verb: `Tables 1 and 2 give`, `Table 1 gives`.
pub(super) fn verb(links: &str, n: usize, verb: &str) -> String {
    format!("{links} {verb}{}", if n == 1 { "s" } else { "" })
}

pub(super) fn cells<const N: usize>(words: [&str; N]) -> TableCells {
    words.map(str::to_owned).to_vec()
}

/// Returns mean and interval; a single number has no interval, and no number gives `None`.
pub(super) fn estimate(numbers: &[f64]) -> Option<String> {
    let e = Estimate::of(numbers)?;
    Some(if numbers.len() > 1 {
        format!("{} [{}, {}]", short(e.mean), short(e.low), short(e.high))
    } else {
        short(e.mean)
    })
}

/// Returns the definition of the intervals in page, figures and methods.
pub(super) fn interval() -> String {
    format!(
        "95 % confidence interval of the mean (percentile bootstrap over participants, {} resamples)",
        thousands(Estimate::RESAMPLES)
    )
}

/// Formats a number with a comma before the last three digits.
fn thousands(n: usize) -> String {
    if n < 1000 { n.to_string() } else { format!("{},{:03}", n / 1000, n % 1000) }
}
