//! Simplified meshes, for pictures from so high above that a car is only a few pixels long, and for shadows. In: a mesh. Out: a
//! mesh with far fewer triangles and almost the same outline seen from above. Metres.
//!
//! Corners in one box of a lattice become one corner (vertex clustering; Rossignac and Borrel 1993): the outermost one, so that
//! the mesh does not shrink, or the innermost one, so that it does not extend beyond the original. Faces that point down are
//! omitted.

use super::{Mesh, Vertex, point_key::PointKey};
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};

/// Vertical component of the unit normal below which a triangle is omitted.
const DOWNWARDS: f32 = -0.3;

/// Share of half an extent within which a corner counts as the furthest: 1 cm of a car's length.
const REACHING: f32 = 0.004;

/// Key of shared corners of the coarse mesh: box, material, colour.
type BoxKey = (PointKey, u32, PointKey);

/// Choice of the corner that is kept in a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum KeptCorner {
    Outermost,
    Innermost,
}

/// Returns the mesh with the corners in each box of size `cell_m` merged.
pub(super) fn coarse(mesh: &Mesh, cell_m: Vec3, which: KeptCorner) -> Mesh {
    let (low, high) = mesh.bounds();
    let (middle, half) = ((low + high) / 2.0, ((high - low) / 2.0).max(Vec3::splat(1e-3)));
    let place = |i: u32| Vec3::from(mesh.vertices[i as usize].position);
    // Boxes are symmetric about the middle, so that both sides of a car are alike.
    let cell = |p: Vec3| PointKey::cell(((p - middle) / cell_m).round().as_ivec3());
    // Corners at the end of an axis come first; otherwise the mesh would become smaller.
    let out = |p: Vec3| {
        let share = ((p - middle) / half).abs();
        (share.max_element() > 1.0 - REACHING, share.length_squared())
    };
    let mut kept: BTreeMap<PointKey, Vec3> = BTreeMap::new();
    for &i in &mesh.indices {
        let p = place(i);
        let kept = kept.entry(cell(p)).or_insert(p);
        if (out(p) > out(*kept)) == (which == KeptCorner::Outermost) {
            *kept = p;
        }
    }
    let mut result = Mesh::default();
    let mut numbers: BTreeMap<BoxKey, u32> = BTreeMap::new();
    let mut made: BTreeSet<[PointKey; 3]> = BTreeSet::new();
    // Large triangles first: where two become one, the larger one sets the finish.
    let face = |t: &[u32; 3]| (place(t[1]) - place(t[0])).cross(place(t[2]) - place(t[0]));
    let mut triangles: Vec<[u32; 3]> = mesh.indices.as_chunks().0.to_vec();
    triangles.sort_by(|a, b| face(b).length_squared().total_cmp(&face(a).length_squared()));
    for triangle in triangles {
        let cells = triangle.map(|i| cell(place(i)));
        let [a, b, c] = cells;
        if a == b || b == c || c == a || face(&triangle).normalize_or_zero().z < DOWNWARDS {
            continue;
        }
        let mut turned = [a, b, c];
        turned.sort_unstable();
        if !made.insert(turned) {
            continue;
        }
        let corners = [0, 1, 2].map(|k| {
            let vertex = &mesh.vertices[triangle[k] as usize];
            let key = (cells[k], vertex.material, PointKey::exact(Vec3::from(vertex.colour)));
            let number = *numbers.entry(key).or_insert_with(|| {
                let position = kept[&key.0].to_array();
                result.vertex(Vertex { position, normal: [0.0; 3], ..*vertex })
            });
            let shared = &mut result.vertices[number as usize];
            shared.normal = (Vec3::from(shared.normal) + Vec3::from(vertex.normal)).to_array();
            number
        });
        // Merging corners may have turned the triangle over.
        let [p, q, r] = corners.map(|i| Vec3::from(result.vertices[i as usize].position));
        let over = (q - p).cross(r - p).dot(face(&triangle)) < 0.0;
        result.indices.extend(if over { [corners[0], corners[2], corners[1]] } else { corners });
    }
    for vertex in &mut result.vertices {
        vertex.normal = Vec3::from(vertex.normal).try_normalize().unwrap_or(Vec3::Z).to_array();
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Material;
    use crate::scene::mesh::tests::{check, faces};
    use crate::scene::mesh::{SurfaceFinish, TriangleList};

    #[test]
    fn a_ball_becomes_a_lump_of_the_same_size_that_faces_outwards() {
        let mut triangles = TriangleList::default();
        triangles
            .ellipsoid(Vec3::ZERO, Vec3::new(2.0, 1.0, 1.0), [24, 48], |_| SurfaceFinish::grey(Material::Paint, 0.5));
        let fine = triangles.into_mesh(0.7);
        let lump = coarse(&fine, Vec3::splat(0.4), KeptCorner::Outermost);
        check(&lump, "lump");
        assert!(lump.triangles() * 5 < fine.triangles(), "{} of {}", lump.triangles(), fine.triangles());
        let ((low, high), (fine_low, fine_high)) = (lump.bounds(), fine.bounds());
        // A tenth of the finest pixel with which a plan is drawn (0.25 m, `scene/car/mod.rs`).
        assert!((high - fine_high).abs().truncate().max_element() < 0.02, "{high} {fine_high}");
        assert!((low - fine_low).abs().truncate().max_element() < 0.02, "{low} {fine_low}");
        for (corners, face) in faces(&lump) {
            let middle = corners.iter().map(|v| Vec3::from(v.position)).sum::<Vec3>() / 3.0;
            assert!(face.dot(middle) > 0.0, "{middle} faces inwards");
        }
    }
}
