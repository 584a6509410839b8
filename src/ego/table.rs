//! Tables of measured values. In: pairs of place and value, by ascending place. Out: the value between them.

/// Interpolates linearly; outside of the table the value at its end holds.
pub(super) fn interpolated(table: &[(f64, f64)], at: f64) -> f64 {
    let next = table.partition_point(|point| point.0 <= at);
    if next == 0 {
        return table[0].1;
    }
    if next == table.len() {
        return table[next - 1].1;
    }
    let (a, b) = (table[next - 1], table[next]);
    a.1 + (b.1 - a.1) * (at - a.0) / (b.0 - a.0)
}
