//! Hatched areas between roads that part or meet: asphalt, a line along either road, slanting bars between them. In: a network's gores. Out:
//! ribbons and areas of paint. Bars are as in sign 298 (`docs/references.md: roads`).

use super::{
    layer::{ASPHALT, Layer},
    strips::{Column, Ground, Paver},
};
use crate::{
    map::network::{Gore, Network},
    scene::colours::shade,
};
use glam::Vec3;

/// Width of a bar and distance from one to the next, along the road, metres.
const BAR_M: f32 = 1.0;
const EVERY_M: f32 = 3.0;
/// Width of the lines along the roads, metres, as that of their lanes.
const LINE_M: f64 = 0.12;
/// Width of the wedge from which it has bars, metres.
const HATCHED_M: f32 = 0.6;

/// Paves and paints all gores of a network.
pub(super) fn pave(net: &Network, paver: &mut Paver) {
    for wedge in net.gores().iter().map(Wedge::of) {
        let rows: Vec<f64> = (0..wedge.rows.len()).map(|row| row as f64).collect();
        let place = |row: f64, share: f64| wedge.point(row as f32, share as f32);
        let ground = [0.0, 1.0].map(|share| Column::tarred(share, Layer::Way, shade(ASPHALT, 1.22)));
        paver.ribbon(&rows, &place, ground, Ground::Tarred, None);
        // The shoulders of both roads overlap where they part, so their lines are painted once more above them.
        for side in [0.0, 1.0] {
            let place = |row: f64, inwards_m: f64| {
                let share = inwards_m / f64::from(wedge.width_m(row as f32)).max(LINE_M);
                wedge.point(row as f32, (side - share).abs() as f32)
            };
            let line = [0.0, LINE_M].map(|at| Column::painted(at, Layer::Paint, at - LINE_M / 2.0, LINE_M / 2.0));
            let [outer, inner] = line;
            paver.ribbon(
                &rows,
                &place,
                if side == 0.0 { [outer, inner] } else { [inner, outer] },
                Ground::Painted,
                None,
            );
        }
        wedge.bars(!net.is_left_hand()).iter().for_each(|bar| paver.painted_area(bar));
    }
}

/// Gore seen from its junction.
struct Wedge {
    /// Points on the border to the right and to the left, a metre after each other.
    rows: Vec<[Vec3; 2]>,
}

impl Wedge {
    fn of(gore: &Gore) -> Self {
        // Where roads meet, traffic drives towards the junction.
        let seen = |[right, left]: [Vec3; 2]| if gore.parts { [right, left] } else { [left, right] };
        Self { rows: gore.rows().map(|row| seen(row.map(|point| point.as_vec3()))).collect() }
    }

    /// Returns the point at a row, at a share of the way from the right border to the left.
    fn point(&self, row: f32, share: f32) -> Vec3 {
        let last = self.rows.len() - 1;
        let before = (row.max(0.0) as usize).min(last);
        let after = (before + 1).min(last);
        let [right, left] = [0, 1].map(|k| self.rows[before][k].lerp(self.rows[after][k], row - before as f32));
        right.lerp(left, share)
    }

    fn width_m(&self, row: f32) -> f32 {
        self.point(row, 0.0).distance(self.point(row, 1.0))
    }

    /// Returns the corners of all bars, at 45 degrees. They begin at the left border or at the right and lead outwards.
    fn bars(&self, begin_left: bool) -> Vec<[Vec3; 4]> {
        let (begin, end) = if begin_left { (1.0, 0.0) } else { (0.0, 1.0) };
        let last = (self.rows.len() - 1) as f32;
        // A bar reaches as far along the road as it reaches across: the width is that at its end.
        let reached = |row: f32| (0..4).fold(row, |end, _| row + self.width_m(end.min(last)));
        let count = (last / EVERY_M) as usize;
        let starts = (0..count).map(|k| k as f32 * EVERY_M).filter(|row| self.width_m(*row) >= HATCHED_M);
        let bars = starts.map(|row| [row, row + BAR_M].map(|row| (row, reached(row))));
        let bars = bars.filter(|[_, far]| far.1 <= last);
        let corners = |[near, far]: [(f32, f32); 2]| {
            [(near.0, begin), (far.0, begin), (far.1, end), (near.1, end)].map(|(row, share)| self.point(row, share))
        };
        bars.map(corners).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns an area of 30 m along the x axis with its left border on it.
    fn strip(width_m: f32) -> Wedge {
        Wedge { rows: (0..=30).map(|x| [Vec3::new(x as f32, -width_m, 0.0), Vec3::new(x as f32, 0.0, 0.0)]).collect() }
    }

    #[test]
    fn bars_lean_outwards_from_their_border_and_cover_a_third() {
        let wide = strip(2.0);
        // Ten bars of a metre, and each ends 2 m further, where the area is 2 m wide.
        for (begins_left, begin_y, end_y) in [(true, 0.0, -2.0), (false, -2.0, 0.0)] {
            let bars = wide.bars(begins_left);
            assert_eq!(bars.len(), 10);
            for (bar, x) in bars.iter().zip((0..).map(|k| 3.0 * k as f32)) {
                let expected = [(x, begin_y), (x + 1.0, begin_y), (x + 3.0, end_y), (x + 2.0, end_y)];
                for (corner, (x, y)) in bar.iter().zip(expected) {
                    assert!(corner.distance(Vec3::new(x, y, 0.0)) < 1e-4, "{bar:?}");
                }
            }
        }
        // No room for bars between two lines.
        assert!(strip(0.4).bars(true).is_empty());
    }
}
