//! Construction of meshes. In: loose triangles with a finish ([`TriangleList`]). Out: a [`Mesh`] with shared corners and smooth
//! normals, sharp where the surface bends more than its crease angle. Metres; counter-clockwise seen from outside.

use super::{Material, Mesh, Vertex, point_key::PointKey};
use glam::{Quat, Vec2, Vec3};
use std::collections::BTreeMap;

/// Colour and material of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceFinish {
    pub material: Material,
    /// Linear albedo, 0..1.
    pub colour: [f32; 3],
}

impl SurfaceFinish {
    /// Creates a finish from its parts.
    pub const fn new(material: Material, colour: [f32; 3]) -> Self {
        Self { material, colour }
    }

    /// Creates a neutral grey finish of the material.
    pub const fn grey(material: Material, value: f32) -> Self {
        Self { material, colour: [value; 3] }
    }
}

/// Loose triangles, without shared corners.
#[derive(Clone, Debug, Default)]
pub(super) struct TriangleList {
    triangles: Vec<([Vec3; 3], SurfaceFinish)>,
    /// True if a quad is cut along its first diagonal, whichever is shorter.
    cuts_alike: bool,
}

/// Key of shared corners: position, normal, colour and material.
type MeshCornerKey = (PointKey, PointKey, [u32; 4]);

/// Distance below which corners are merged, metres.
const WELD_M: f32 = 1e-4;

impl TriangleList {
    /// Adds a triangle, counter-clockwise; omits triangles without area.
    pub fn triangle(&mut self, corners: [Vec3; 3], finish: SurfaceFinish) {
        let [a, b, c] = corners.map(key);
        if a != b && b != c && c != a {
            self.triangles.push((corners, finish));
        }
    }

    /// Creates a list that cuts all quads along the same diagonal, so that a body has the same triangles in every posture.
    pub fn cutting_alike() -> Self {
        Self { cuts_alike: true, ..Self::default() }
    }

    /// Adds a quad of four corners, counter-clockwise, cut along the shorter diagonal or, in a list that cuts alike, the first one.
    pub fn quad(&mut self, [a, b, c, d]: [Vec3; 4], finish: SurfaceFinish) {
        if self.cuts_alike || a.distance_squared(c) <= b.distance_squared(d) {
            self.triangle([a, b, c], finish);
            self.triangle([a, c, d], finish);
        } else {
            self.triangle([b, c, d], finish);
            self.triangle([b, d, a], finish);
        }
    }

    /// Adds a box with its edges along the axes.
    pub fn cuboid(&mut self, centre: Vec3, half: Vec3, finish: SurfaceFinish) {
        let corner = |x: f32, y: f32, z: f32| centre + half * Vec3::new(x, y, z);
        for axis in 0..3 {
            for side in [-1.0f32, 1.0] {
                let place = |u: f32, v: f32| {
                    let mut p = [0.0; 3];
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u * side, v);
                    corner(p[0], p[1], p[2])
                };
                self.quad([place(-1.0, -1.0), place(1.0, -1.0), place(1.0, 1.0), place(-1.0, 1.0)], finish);
            }
        }
    }

    /// Adds an ellipsoid of `rings` by `sides` faces with its poles along y; `finish_of` receives the outward direction.
    pub fn ellipsoid(
        &mut self,
        centre: Vec3,
        half: Vec3,
        [rings, sides]: [usize; 2],
        finish_of: impl Fn(Vec3) -> SurfaceFinish,
    ) {
        let point = |i: usize, k: usize| {
            let (sin_i, cos_i) = (std::f32::consts::PI * i as f32 / rings as f32).sin_cos();
            let (sin_k, cos_k) = (std::f32::consts::TAU * (k % sides) as f32 / sides as f32).sin_cos();
            // The poles are exact, so that the triangle fans around them close.
            let across = if i == 0 || i == rings { 0.0 } else { sin_i };
            Vec3::new(across * cos_k, cos_i, across * sin_k)
        };
        for i in 0..rings {
            for k in 0..sides {
                let corners = [point(i, k), point(i, k + 1), point(i + 1, k + 1), point(i + 1, k)];
                let outwards = corners.iter().sum::<Vec3>().normalize();
                self.quad(corners.map(|p| centre + half * p), finish_of(outwards));
            }
        }
    }

    /// Returns the mirror image in the plane y = 0.
    pub fn mirrored(&self) -> Self {
        let flip = |p: Vec3| Vec3::new(p.x, -p.y, p.z);
        let triangles = self.triangles.iter().map(|&([a, b, c], f)| ([flip(a), flip(c), flip(b)], f)).collect();
        Self { triangles, ..*self }
    }

    /// Moves all corners by a map that does not turn the surface inside out.
    pub fn moved(mut self, to: impl Fn(Vec3) -> Vec3) -> Self {
        self.triangles.iter_mut().flat_map(|(corners, _)| corners).for_each(|corner| *corner = to(*corner));
        self
    }

    /// Returns the corners of all triangles.
    #[cfg(test)]
    pub fn corners(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        self.triangles.iter().map(|(corners, _)| *corners)
    }

    /// Adds a closed bar through cross-sections that all have the same number of corners; `ring(i)` gives the corners of
    /// cross-section `i`, counter-clockwise seen from before the bar's beginning.
    pub fn bar(&mut self, places: usize, ring: impl Fn(usize) -> Vec<Vec3>, finish: SurfaceFinish) {
        let rings: Vec<Vec<Vec3>> = (0..places).map(ring).collect();
        for pair in rings.windows(2) {
            let n = pair[0].len();
            for k in 0..n {
                let next = (k + 1) % n;
                self.quad([pair[0][k], pair[1][k], pair[1][next], pair[0][next]], finish);
            }
        }
        let mut cap = |ring: &[Vec3], first: bool| {
            for k in 1..ring.len().saturating_sub(1) {
                let [a, b, c] = [ring[0], ring[k], ring[k + 1]];
                self.triangle(if first { [a, b, c] } else { [a, c, b] }, finish);
            }
        };
        if let (Some(first), Some(last)) = (rings.first(), rings.last()) {
            cap(first, true);
            cap(last, false);
        }
    }

    /// Adds all triangles of another list.
    pub fn append(&mut self, other: Self) {
        self.triangles.extend(other.triangles);
    }

    /// Builds a mesh with shared corners and normals. Normals are smooth where faces of one material meet at less than
    /// `crease_rad`, and where faces of different materials meet at less than a third of that (glass is flush with its frame).
    pub fn into_mesh(self, crease_rad: f32) -> Mesh {
        let faces: Vec<Vec3> =
            self.triangles.iter().map(|([a, b, c], _)| (*b - *a).cross(*c - *a).normalize_or_zero()).collect();
        let mut around: BTreeMap<PointKey, Vec<(usize, f32)>> = BTreeMap::new();
        for (index, (corners, _)) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                let to = |j: usize| (corners[(k + j) % 3] - corners[k]).normalize_or_zero();
                // Weighted by the corner's angle, so that the diagonal of a quad does not tilt the normal, and by area, so that a
                // sliver between panels does not bend its neighbours.
                let angle = to(1).dot(to(2)).clamp(-1.0, 1.0).acos();
                let area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
                around.entry(key(corners[k])).or_default().push((index, angle * area));
            }
        }
        let mut mesh = Mesh::default();
        let mut shared: BTreeMap<MeshCornerKey, u32> = BTreeMap::new();
        for (index, (corners, finish)) in self.triangles.iter().enumerate() {
            for &corner in corners {
                let mut normal = Vec3::ZERO;
                for &(other, weight) in &around[&key(corner)] {
                    let same = self.triangles[other].1.material == finish.material;
                    let limit = if same { crease_rad } else { crease_rad / 3.0 };
                    if faces[index].dot(faces[other]) >= limit.cos() {
                        normal += faces[other] * weight;
                    }
                }
                let normal = normal.try_normalize().unwrap_or(faces[index]);
                let [r, g, b] = finish.colour.map(f32::to_bits);
                let look = [r, g, b, finish.material as u32];
                let number = *shared
                    .entry((key(corner), PointKey::cell((normal * 1000.0).round().as_ivec3()), look))
                    .or_insert_with(|| {
                        mesh.vertex(Vertex::new(corner, normal, finish.colour, Vec2::ZERO, finish.material))
                    });
                mesh.indices.push(number);
            }
        }
        mesh
    }
}

/// Returns the key of a position on the welding lattice.
fn key(p: Vec3) -> PointKey {
    PointKey::cell((p / WELD_M).round().as_ivec3())
}

impl Vertex {
    /// Creates a vertex from its parts.
    pub fn new(position: Vec3, normal: Vec3, colour: [f32; 3], uv: Vec2, material: Material) -> Self {
        Self { position: position.into(), normal: normal.into(), colour, uv: uv.into(), material: material as u32 }
    }
}

impl Mesh {
    /// Adds a vertex and returns its index.
    pub fn vertex(&mut self, vertex: Vertex) -> u32 {
        self.vertices.push(vertex);
        self.vertices.len() as u32 - 1
    }

    /// Adds all triangles of another mesh.
    pub fn append(&mut self, other: &Self) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.indices.extend(other.indices.iter().map(|i| i + first));
    }

    /// Returns meshes of a body in several postures, whose triangles correspond, with the same indices: two corners are one vertex if they are one
    /// in every posture.
    pub fn with_same_indices(postures: &[Self]) -> Vec<Self> {
        let corners = postures.first().map_or(0, |mesh| mesh.indices.len());
        debug_assert!(postures.iter().all(|mesh| mesh.indices.len() == corners), "corresponding triangles");
        let mut same = vec![Self::default(); postures.len()];
        let mut numbers: BTreeMap<Vec<u32>, u32> = BTreeMap::new();
        for corner in 0..corners {
            let old: Vec<u32> = postures.iter().map(|mesh| mesh.indices[corner]).collect();
            let next = numbers.len() as u32;
            let number = *numbers.entry(old).or_insert_with_key(|old| {
                for ((mesh, posture), &at) in same.iter_mut().zip(postures).zip(old) {
                    mesh.vertex(posture.vertices[at as usize]);
                }
                next
            });
            same.iter_mut().for_each(|mesh| mesh.indices.push(number));
        }
        same
    }

    /// Adds a copy of another mesh, turned about its origin, which is moved to `at`.
    pub fn append_placed(&mut self, other: &Self, turn: Quat, at: Vec3) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(other.vertices.iter().map(|v| Vertex {
            position: (at + turn * Vec3::from(v.position)).into(),
            normal: (turn * Vec3::from(v.normal)).into(),
            ..*v
        }));
        self.indices.extend(other.indices.iter().map(|i| i + first));
    }

    pub fn triangles(&self) -> usize {
        self.indices.len() / 3
    }

    /// Returns the lowest and highest coordinates; zeros for an empty mesh.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let mut all = self.vertices.iter().map(|v| Vec3::from(v.position));
        let first = all.next().unwrap_or_default();
        all.fold((first, first), |(low, high), p| (low.min(p), high.max(p)))
    }

    /// Returns a sphere that encloses the whole mesh: centre and radius, metres. Its centre is the middle of the bounding box, so
    /// it is not the smallest one.
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
        let (low, high) = self.bounds();
        let centre = (low + high) / 2.0;
        let radius_m = self.vertices.iter().map(|v| centre.distance(v.position.into())).fold(0.0, f32::max);
        (centre, radius_m)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Checks a mesh: indices in range, whole triangles, unit normals, finite numbers.
    pub fn check(mesh: &Mesh, name: &str) {
        assert!(!mesh.indices.is_empty() && mesh.indices.len().is_multiple_of(3), "{name}");
        assert!(mesh.indices.iter().all(|&i| (i as usize) < mesh.vertices.len()), "{name}: index out of range");
        for v in &mesh.vertices {
            assert!((Vec3::from(v.normal).length() - 1.0).abs() < 1e-3, "{name}: normal of {v:?}");
            assert!(v.position.iter().chain(&v.uv).all(|x| x.is_finite()), "{name}: {v:?}");
            // A verge stores its grass cover in place of blue.
            let colours = if v.material == Material::Verge as u32 { &v.colour[..2] } else { &v.colour };
            assert!(
                colours.iter().all(|c| (0.0..=1.0).contains(c)) && v.material & 0xff <= Material::Hedge as u32,
                "{name}: {v:?}"
            );
        }
    }

    /// Checks whether a mesh has a material with a clear coat.
    pub fn has_coat(mesh: &Mesh) -> bool {
        let coated = [Material::Paint, Material::Glass, Material::BrakeLamp, Material::HeadLamp, Material::Lamp]
            .map(|of| of as u32);
        mesh.vertices.iter().any(|v| coated.contains(&v.material))
    }

    /// Returns the corners and the face normal (its length is twice the area) of each triangle.
    pub fn faces(mesh: &Mesh) -> impl Iterator<Item = ([Vertex; 3], Vec3)> {
        mesh.indices.chunks(3).map(|t| {
            let corners = [0, 1, 2].map(|k| mesh.vertices[t[k] as usize]);
            let [a, b, c] = corners.map(|v| Vec3::from(v.position));
            (corners, (b - a).cross(c - a))
        })
    }

    /// Returns the smallest cosine between a face and its corners' normals, ignoring slivers thinner than a quarter of a
    /// millimetre, the distance by which closing a seam may move a corner.
    pub fn worst_agreement(mesh: &Mesh) -> f32 {
        faces(mesh)
            .filter(|(corners, face)| {
                let [a, b, c] = corners.map(|v| Vec3::from(v.position));
                face.length() > 2.5e-4 * a.distance(b).max(b.distance(c)).max(c.distance(a))
            })
            .flat_map(|(corners, face)| corners.map(|v| face.normalize_or_zero().dot(v.normal.into())))
            .fold(1.0, f32::min)
    }

    /// Returns the volume inside a closed surface, positive if its triangles run counter-clockwise seen from outside.
    pub fn volume_m3(mesh: &Mesh) -> f32 {
        faces(mesh).map(|(corners, face)| Vec3::from(corners[0].position).dot(face) / 6.0).sum()
    }

    /// Returns the number of edges that are not shared by exactly two triangles of opposite direction.
    pub fn open_edges(mesh: &Mesh) -> usize {
        open(mesh).len()
    }

    /// Returns the positions of the first four open edges, for messages.
    pub fn open_places(mesh: &Mesh) -> String {
        format!("{:?}", open(mesh).iter().take(4).collect::<Vec<_>>())
    }

    fn open(mesh: &Mesh) -> Vec<[Vec3; 2]> {
        let mut count: BTreeMap<[PointKey; 2], (i32, [Vec3; 2])> = BTreeMap::new();
        for (corners, _) in faces(mesh) {
            let places = corners.map(|v| Vec3::from(v.position));
            for k in 0..3 {
                let edge = [places[k], places[(k + 1) % 3]];
                let [a, b] = edge.map(super::key);
                // Ends that fall on the same lattice point form no edge.
                if a != b {
                    count.entry([a.min(b), a.max(b)]).or_insert((0, edge)).0 += if a < b { 1 } else { -1 };
                }
            }
        }
        count.into_values().filter(|(count, _)| *count != 0).map(|(_, edge)| edge).collect()
    }

    #[test]
    fn a_box_is_closed_and_sharp_and_a_ball_is_closed_and_smooth() {
        let finish = SurfaceFinish::grey(Material::Matt, 0.5);
        let mut triangles = TriangleList::default();
        triangles.cuboid(Vec3::ONE, Vec3::new(1.0, 2.0, 3.0), finish);
        let cuboid = triangles.into_mesh(0.7);
        check(&cuboid, "box");
        assert_eq!((cuboid.vertices.len(), cuboid.triangles(), open_edges(&cuboid)), (24, 12, 0));
        assert!((volume_m3(&cuboid) - 48.0).abs() < 1e-3);
        assert!(worst_agreement(&cuboid) > 0.9999);

        let mut triangles = TriangleList::default();
        triangles.ellipsoid(Vec3::ZERO, Vec3::ONE, [16, 24], |_| finish);
        let ball = triangles.into_mesh(0.7);
        check(&ball, "ball");
        assert_eq!(open_edges(&ball), 0);
        assert!((volume_m3(&ball) - 4.19).abs() < 0.15, "{}", volume_m3(&ball));
        for v in &ball.vertices {
            assert!(Vec3::from(v.normal).dot(v.position.into()) > 0.998, "{v:?}");
        }
        assert!((ball.bounding_sphere().1 - 1.0).abs() < 1e-3);
    }
}
