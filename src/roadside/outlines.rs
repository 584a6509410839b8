//! Outlines of areas on the ground. In: corners. Out: the corners that count, counter-clockwise; whether a point is inside.

use glam::{Vec2, Vec3};

/// Distance up to which two successive corners count as one, metres.
const SAME_M: f32 = 0.005;

/// Returns the indices of an outline's corners without duplicates, counter-clockwise; empty if the area is below 0.01 m².
pub fn cleaned(outline: &[Vec2]) -> Vec<usize> {
    let mut kept: Vec<usize> = Vec::new();
    for k in 0..outline.len() {
        if kept.last().is_none_or(|&last| outline[last].distance(outline[k]) > SAME_M) {
            kept.push(k);
        }
    }
    while kept.len() > 1 && outline[kept[0]].distance(outline[kept[kept.len() - 1]]) <= SAME_M {
        kept.pop();
    }
    let doubled: f32 = (0..kept.len()).map(|k| outline[kept[k]].perp_dot(outline[kept[(k + 1) % kept.len()]])).sum();
    if kept.len() < 3 || doubled.abs() < 0.02 {
        return Vec::new();
    }
    if doubled < 0.0 {
        kept.reverse();
    }
    kept
}

/// Checks whether a point lies inside an outline (even-odd rule).
pub fn contains(outline: &[Vec3], point: Vec2) -> bool {
    let mut inside = false;
    for (k, a) in outline.iter().enumerate() {
        let b = outline[(k + 1) % outline.len()];
        if (a.y > point.y) != (b.y > point.y) && point.x < a.x + (b.x - a.x) * (point.y - a.y) / (b.y - a.y) {
            inside = !inside;
        }
    }
    inside
}
