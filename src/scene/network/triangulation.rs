//! Triangulation of areas by ear clipping. In: an outline on the ground, in either orientation. Slight self-intersections, as in some
//! outlines of junctions, are allowed. Out: triangles that face up, as indices of the outline's corners.

use crate::roadside::outlines::cleaned;
use glam::Vec2;

/// Cuts ears off the outline until none is left. If no corner is an ear, because the outline intersects itself, cuts the corner whose
/// triangle is the least thin.
pub(in crate::scene) fn triangles(outline: &[Vec2]) -> Vec<[usize; 3]> {
    let mut left = cleaned(outline);
    let mut cut = Vec::with_capacity(left.len());
    while left.len() > 2 {
        let n = left.len();
        let corners = |k: usize| [left[(k + n - 1) % n], left[k], left[(k + 1) % n]];
        let doubled = |[a, b, c]: [usize; 3]| (outline[b] - outline[a]).perp_dot(outline[c] - outline[b]);
        let is_ear = |&k: &usize| {
            let corner = corners(k);
            doubled(corner) > 0.0
                && !left.iter().any(|&other| !corner.contains(&other) && within(outline, corner, other))
        };
        // Cut the ear with the least thin triangle, so that no long slivers run across a junction.
        let fat = |k: usize| {
            let [a, b, c] = corners(k);
            let longest = [(a, b), (b, c), (c, a)].map(|(p, q)| outline[p].distance_squared(outline[q]));
            doubled([a, b, c]) / longest.iter().copied().fold(1e-9, f32::max)
        };
        let ear = (0..n).filter(is_ear).max_by(|&a, &b| fat(a).total_cmp(&fat(b)));
        let ear = ear.unwrap_or_else(|| (0..n).max_by(|&a, &b| fat(a).total_cmp(&fat(b))).unwrap_or(0));
        let corner = corners(ear);
        if doubled(corner) > 0.0 {
            cut.push(corner);
        }
        left.remove(ear);
    }
    cut
}

/// Checks whether a corner of the outline lies in a triangle of its corners, edges included. Corners at the same point do not count.
fn within(outline: &[Vec2], [a, b, c]: [usize; 3], corner: usize) -> bool {
    let [a, b, c, p] = [a, b, c, corner].map(|k| outline[k]);
    let side = |u: Vec2, v: Vec2| (v - u).perp_dot(p - u);
    p != a && p != b && p != c && side(a, b) >= 0.0 && side(b, c) >= 0.0 && side(c, a) >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(outline: &[Vec2]) -> f32 {
        let of = |[a, b, c]: &[usize; 3]| (outline[*b] - outline[*a]).perp_dot(outline[*c] - outline[*a]) / 2.0;
        triangles(outline).iter().map(of).sum()
    }

    #[test]
    fn triangles_fill_the_outline_and_face_up() {
        // A cross of five unit squares has area 5 and twelve corners, eight of them convex.
        let cross = [(1, 0), (2, 0), (2, 1), (3, 1), (3, 2), (2, 2), (2, 3), (1, 3), (1, 2), (0, 2), (0, 1), (1, 1)];
        let mut cross: Vec<Vec2> = cross.iter().map(|&(x, y)| Vec2::new(x as f32, y as f32)).collect();
        for _ in 0..2 {
            assert_eq!(triangles(&cross).len(), 10);
            assert!((area(&cross) - 5.0).abs() < 1e-5, "{}", area(&cross));
            cross.reverse();
        }
        // The cross with a duplicate corner.
        cross.insert(3, cross[3]);
        assert!((area(&cross) - 5.0).abs() < 1e-5);
    }

    #[test]
    fn an_outline_without_an_area_has_no_triangles() {
        for outline in [vec![], vec![Vec2::ONE], vec![Vec2::ZERO, Vec2::X], vec![Vec2::ZERO, Vec2::X, Vec2::X * 2.0]] {
            assert!(triangles(&outline).is_empty(), "{outline:?}");
        }
        // A bow tie, with halves of opposite orientation, must not panic.
        triangles(&[Vec2::ZERO, Vec2::ONE, Vec2::X, Vec2::Y]);
    }
}
