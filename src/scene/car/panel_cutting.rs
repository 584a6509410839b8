//! Cutting of sheet metal: windows, lamps, wheel arches and door gaps are regions of space that divide the triangles they cross.
//! In: quads with their positions before bending. Out: loose triangles with smooth normals, or a closed [`Mesh`]. Metres in the
//! body's frame.

use crate::scene::{Mesh, Vertex, mesh::SurfaceFinish, point_key::PointKey};
use glam::{IVec3, Vec2, Vec3};
use std::collections::BTreeMap;

/// A corner of a face.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct FaceCorner {
    /// Position before the body was bent; regions are in these coordinates.
    pub flat: Vec3,
    /// Position after the body was bent.
    pub at: Vec3,
    /// Unit normal, pointing out of the body.
    pub normal: Vec3,
}

impl FaceCorner {
    fn mix(&self, other: &Self, t: f32) -> Self {
        Self {
            flat: self.flat.lerp(other.flat, t),
            at: self.at.lerp(other.at, t),
            normal: self.normal.lerp(other.normal, t).normalize_or(self.normal),
        }
    }
}

/// A triangle, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct BodyFace {
    /// Corners, counter-clockwise seen from outside.
    pub corners: [FaceCorner; 3],
    pub finish: SurfaceFinish,
}

impl BodyFace {
    /// Checks whether the face has an area: false if its corners lie on a line.
    fn is_real(&self) -> bool {
        let [a, b, c] = self.places();
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        self.cross().length() > 2e-4 * longest
    }

    /// Returns the corners' positions. Written out, because a map over the array would be a function call.
    #[inline]
    fn places(&self) -> [Vec3; 3] {
        let [a, b, c] = &self.corners;
        [a.at, b.at, c.at]
    }

    #[inline]
    fn cross(&self) -> Vec3 {
        let [a, b, c] = self.places();
        (b - a).cross(c - a)
    }
}

/// Convex region: inside all planes, `normal . flat <= reach`. A face is in the region only if it also faces the required
/// direction.
#[derive(Clone, Debug)]
pub(in crate::scene) struct CutRegion {
    planes: Vec<(Vec3, f32)>,
    facing: (Vec3, f32),
}

impl CutRegion {
    /// Returns the region of a convex polygon (in either direction) seen along an axis: 0 from the front or rear as (y, z), 1
    /// from the side as (x, z), 2 from above as (x, y).
    pub fn seen_along(axis: usize, polygon: &[Vec2]) -> Self {
        let lift = |p: Vec2| match axis {
            0 => Vec3::new(0.0, p.x, p.y),
            1 => Vec3::new(p.x, 0.0, p.y),
            _ => p.extend(0.0),
        };
        let middle = polygon.iter().sum::<Vec2>() / polygon.len() as f32;
        let edge = |i: usize| {
            let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            let normal = (b - a).perp().normalize();
            let normal = if normal.dot(middle - a) > 0.0 { -normal } else { normal };
            (lift(normal), normal.dot(a))
        };
        Self { planes: (0..polygon.len()).map(edge).collect(), facing: (Vec3::ZERO, -1.0) }
    }

    /// Returns the region with every plane moved outwards.
    pub fn grown(mut self, by_m: f32) -> Self {
        self.planes.iter_mut().for_each(|plane| plane.1 += by_m);
        self
    }

    /// Returns the region limited to `reach` along `normal`.
    pub fn within(mut self, normal: Vec3, reach: f32) -> Self {
        let length = normal.length();
        self.planes.push((normal / length, reach / length));
        self
    }

    /// Returns the region limited to faces whose unit normal has at least the component `least` along `direction`.
    pub fn facing(mut self, direction: Vec3, least: f32) -> Self {
        self.facing = (direction, least);
        self
    }
}

/// Surface of triangles that can be cut.
#[derive(Clone, Debug, Default)]
pub(in crate::scene) struct PanelSkin {
    /// Triangles in no particular order.
    pub faces: Vec<BodyFace>,
}

impl PanelSkin {
    /// Adds a quad of four corners, counter-clockwise, with their positions before and after bending.
    pub fn quad(&mut self, flat: [Vec3; 4], bend: impl Fn(Vec3) -> Vec3, finish: SurfaceFinish) {
        let [a, b, c, d] = flat.map(|flat| FaceCorner { flat, at: bend(flat), normal: Vec3::Z });
        let halves = if a.at.distance_squared(c.at) <= b.at.distance_squared(d.at) {
            [[a, b, c], [a, c, d]]
        } else {
            [[b, c, d], [b, d, a]]
        };
        for corners in halves {
            let [p, q, r] = [corners[0].at, corners[1].at, corners[2].at];
            if p.distance(q).min(q.distance(r)).min(r.distance(p)) > 1e-5 {
                self.faces.push(BodyFace { corners, finish });
            }
        }
    }

    /// Gives every corner the mean normal of the faces around it that meet at less than `crease_rad`.
    pub fn smooth(&mut self, crease_rad: f32) {
        let key = |p: Vec3| PointKey::cell((p * 1e4).round().as_ivec3());
        let normals: Vec<Vec3> = self.faces.iter().map(|face| face.cross().normalize_or_zero()).collect();
        let mut around: BTreeMap<PointKey, Vec<(usize, f32)>> = BTreeMap::new();
        for (i, face) in self.faces.iter().enumerate() {
            for k in 0..3 {
                let to = |j: usize| (face.corners[(k + j) % 3].at - face.corners[k].at).normalize_or_zero();
                let angle = to(1).dot(to(2)).clamp(-1.0, 1.0).acos();
                around.entry(key(face.corners[k].at)).or_default().push((i, angle * face.cross().length()));
            }
        }
        let least = crease_rad.cos();
        for (i, face) in self.faces.iter_mut().enumerate() {
            for corner in &mut face.corners {
                let beside = around[&key(corner.at)].iter().filter(|(j, _)| normals[i].dot(normals[*j]) >= least);
                let mut normal = beside.map(|&(j, weight)| normals[j] * weight).sum::<Vec3>();
                // The other half of the body continues the surface beyond the middle.
                if corner.at.y.abs() < 1e-4 {
                    normal.y = 0.0;
                }
                corner.normal = normal.try_normalize().unwrap_or(normals[i]);
            }
        }
    }

    /// Removes the part in a region and returns it.
    pub fn cut(&mut self, cell: &CutRegion) -> Vec<BodyFace> {
        let mut inside = Vec::new();
        let mut rest = Vec::with_capacity(self.faces.len());
        for face in std::mem::take(&mut self.faces) {
            let looks = cell.facing.1 <= -1.0 || face.cross().normalize_or_zero().dot(cell.facing.0) >= cell.facing.1;
            let apart = |&(normal, reach): &(Vec3, f32)| {
                face.corners.iter().all(|corner| normal.dot(corner.flat) >= reach - 1e-6)
            };
            if !looks || cell.planes.iter().any(apart) {
                rest.push(face);
                continue;
            }
            let mut piece = face.corners.to_vec();
            let mut cut_off = Vec::new();
            for &(normal, reach) in &cell.planes {
                let (within, beyond) = part(&piece, normal, reach);
                fan(&beyond, face.finish, &mut cut_off);
                piece = within;
                if piece.is_empty() {
                    break;
                }
            }
            if piece.is_empty() {
                // Only near a corner of the region: the face stays whole.
                rest.push(face);
            } else {
                rest.extend(cut_off);
                fan(&piece, face.finish, &mut inside);
            }
        }
        self.faces = rest;
        inside
    }

    /// Gives the part in a region another finish.
    pub fn paint(&mut self, cell: &CutRegion, finish: SurfaceFinish) {
        let inside = self.cut(cell);
        self.faces.extend(inside.into_iter().map(|face| BodyFace { finish, ..face }));
    }

    /// Moves the part in a region by `sink`, adds walls around it, and returns the part as it was.
    pub fn recess(
        &mut self,
        cell: &CutRegion,
        sink: impl Fn(Vec3) -> Vec3,
        floor: SurfaceFinish,
        wall: SurfaceFinish,
    ) -> Vec<BodyFace> {
        let inside = self.cut(cell);
        let mut open: BTreeMap<(PointKey, PointKey), (i32, [FaceCorner; 2])> = BTreeMap::new();
        let key = |p: Vec3| PointKey::cell((p * 2e4).round().as_ivec3());
        for face in &inside {
            for k in 0..3 {
                let (a, b) = (face.corners[k], face.corners[(k + 1) % 3]);
                let (i, j) = (key(a.at), key(b.at));
                open.entry((i.min(j), i.max(j))).or_insert((0, [a, b])).0 += if i < j { 1 } else { -1 };
            }
        }
        let mut walls = Self::default();
        for (count, [a, b]) in open.into_values() {
            let middle = a.at.y.abs() < 1e-4 && b.at.y.abs() < 1e-4;
            let on = |&&(normal, reach): &&(Vec3, f32)| {
                [a, b].iter().all(|corner| (normal.dot(corner.flat) - reach).abs() < 2e-5)
            };
            if count != 0 && !middle && cell.planes.iter().any(|plane| on(&plane)) {
                walls.quad([a.at, b.at, sink(b.at), sink(a.at)], |p| p, wall);
            }
        }
        let mut sunk = Self { faces: inside.clone() };
        for face in &mut sunk.faces {
            face.finish = floor;
            face.corners = face.corners.map(|corner| FaceCorner { at: sink(corner.at), ..corner });
        }
        // Faces along the direction of sinking have become lines; their neighbours meet without them.
        sunk.faces.retain(BodyFace::is_real);
        walls.faces.retain(BodyFace::is_real);
        sunk.smooth(0.7);
        walls.smooth(0.7);
        self.faces.extend(sunk.faces);
        self.faces.extend(walls.faces);
        inside
    }

    /// Returns the surface and its mirror image in the plane y = 0.
    pub fn doubled(mut self) -> Self {
        let flip = |p: Vec3| Vec3::new(p.x, -p.y, p.z);
        let corner = |c: FaceCorner| FaceCorner { flat: flip(c.flat), at: flip(c.at), normal: flip(c.normal) };
        let image = |face: &BodyFace| {
            let [a, b, c] = face.corners;
            BodyFace { corners: [a, c, b].map(corner), finish: face.finish }
        };
        let other: Vec<BodyFace> = self.faces.iter().map(image).collect();
        self.faces.extend(other);
        self
    }

    /// Returns the faces for which `wanted` holds, turned to be seen from inside.
    pub fn lining(&self, finish: SurfaceFinish, wanted: impl Fn(&BodyFace) -> bool) -> Self {
        let turned = |face: &BodyFace| {
            let [a, b, c] = face.corners.map(|corner| FaceCorner { normal: -corner.normal, ..corner });
            BodyFace { corners: [a, c, b], finish }
        };
        Self { faces: self.faces.iter().filter(|face| wanted(face)).map(turned).collect() }
    }

    /// Removes the faces for which `wanted` holds and returns them.
    pub fn take(&mut self, wanted: impl Fn(&BodyFace) -> bool) -> Self {
        let (taken, kept) = std::mem::take(&mut self.faces).into_iter().partition(|face| wanted(face));
        self.faces = kept;
        Self { faces: taken }
    }

    /// Closes the seams left where only one of two neighbours was cut: a corner that lies on another face's edge becomes a corner
    /// of that face.
    pub fn close_seams(&mut self) {
        self.weld();
        let ends = |face: &BodyFace, k: usize| (face.corners[k].at, face.corners[(k + 1) % 3].at);
        let edge = |face: &BodyFace, k: usize| {
            let (a, b) = ends(face, k);
            let (a, b) = (PointKey::exact(a), PointKey::exact(b));
            if a < b { ((a, b), 1) } else { ((b, a), -1) }
        };
        let mut edges: Vec<_> = self.faces.iter().flat_map(|face| [0, 1, 2].map(|k| edge(face, k))).collect();
        edges.sort_unstable();
        // Open are those that are not passed as often one way as the other.
        let sides = edges.chunk_by(|a, b| a.0 == b.0);
        let open_edges = sides.filter(|sides| sides.iter().map(|(_, way)| way).sum::<i32>() != 0);
        let open_edges: Vec<_> = open_edges.map(|sides| sides[0].0).collect();
        let open = |face: &BodyFace, k: usize| open_edges.binary_search(&edge(face, k).0).is_ok();
        let mut loose: BTreeMap<PointKey, Vec3> = BTreeMap::new();
        for face in &self.faces {
            for k in (0..3).filter(|&k| open(face, k)) {
                let (a, b) = ends(face, k);
                loose.extend([(PointKey::exact(a), a), (PointKey::exact(b), b)]);
            }
        }
        // Sorted by x, so that an edge checks only the corners near it.
        let mut loose: Vec<Vec3> = loose.into_values().collect();
        loose.sort_by(|a, b| a.x.total_cmp(&b.x));
        let mut whole = Vec::with_capacity(self.faces.len());
        for face in &self.faces {
            let mut outline = Vec::with_capacity(3);
            for k in 0..3 {
                let (from, to) = (face.corners[k], face.corners[(k + 1) % 3]);
                outline.push(from);
                if open(face, k) {
                    let way = to.at - from.at;
                    let (low, high) = (from.at.x.min(to.at.x) - SEAM_M, from.at.x.max(to.at.x) + SEAM_M);
                    let start = loose.partition_point(|p| p.x < low);
                    let mut on: Vec<(f32, Vec3)> = loose[start..]
                        .iter()
                        .take_while(|p| p.x <= high)
                        .filter_map(|&p| {
                            let t = (p - from.at).dot(way) / way.length_squared();
                            let off = (from.at + way * t).distance(p);
                            (off < SEAM_M && t > 0.0 && t < 1.0 && p != from.at && p != to.at).then_some((t, p))
                        })
                        .collect();
                    on.sort_by(|a, b| a.0.total_cmp(&b.0));
                    outline.extend(on.iter().map(|&(t, at)| FaceCorner { at, ..from.mix(&to, t) }));
                }
            }
            if outline.len() == 3 {
                whole.push(*face);
                continue;
            }
            let third = 1.0 / 3.0;
            let [a, b, c] = face.corners;
            let mut middle = a.mix(&b, 0.5).mix(&c, third);
            middle.at = (a.at + b.at + c.at) * third;
            for k in 0..outline.len() {
                let corners = [outline[k], outline[(k + 1) % outline.len()], middle];
                whole.push(BodyFace { corners, finish: face.finish });
            }
        }
        self.faces = whole;
    }

    /// Merges corners that almost coincide, and drops faces that have lost a side.
    fn weld(&mut self) {
        const CELL_M: f32 = 0.01;
        let mut cells: BTreeMap<PointKey, Vec<Vec3>> = BTreeMap::new();
        for face in &mut self.faces {
            for corner in &mut face.corners {
                let p = corner.at;
                let place = |p: Vec3| (p / CELL_M).floor().as_ivec3();
                let (low, high) = (place(p - WELD_M), place(p + WELD_M));
                let mut found = None;
                'search: for x in low.x..=high.x {
                    for y in low.y..=high.y {
                        for z in low.z..=high.z {
                            let near = |q: &&Vec3| q.distance_squared(p) < WELD_M * WELD_M;
                            found = cells
                                .get(&PointKey::cell(IVec3::new(x, y, z)))
                                .and_then(|list| list.iter().find(near))
                                .copied();
                            if found.is_some() {
                                break 'search;
                            }
                        }
                    }
                }
                corner.at = found.unwrap_or_else(|| {
                    cells.entry(PointKey::cell(place(p))).or_default().push(p);
                    p
                });
            }
        }
        self.faces.retain(|face| {
            let [a, b, c] = face.places();
            a != b && b != c && c != a
        });
    }

    /// Returns a mesh with shared corners; call [`PanelSkin::close_seams`] first.
    pub fn mesh(&self) -> Mesh {
        let mut mesh = Mesh::default();
        let mut shared: BTreeMap<CornerKey, u32> = BTreeMap::new();
        for face in &self.faces {
            let [r, g, b] = face.finish.colour;
            let look = [r.to_bits(), g.to_bits(), b.to_bits(), face.finish.material as u32];
            for corner in &face.corners {
                let normal = PointKey::cell((corner.normal * 500.0).round().as_ivec3());
                let key = (PointKey::exact(corner.at), normal, look);
                let number = *shared.entry(key).or_insert_with(|| {
                    let (finish, zero) = (face.finish, Vec2::ZERO);
                    mesh.vertex(Vertex::new(corner.at, corner.normal, finish.colour, zero, finish.material))
                });
                mesh.indices.push(number);
            }
        }
        mesh
    }
}

/// Key of shared corners of a mesh: position, normal, colour and material.
type CornerKey = (PointKey, PointKey, [u32; 4]);

/// Distance below which corners are merged, metres.
const WELD_M: f32 = 6e-5;
/// Distance below which a corner lies on an edge, metres.
const SEAM_M: f32 = 2.5e-4;

/// Returns the parts of a convex polygon inside and outside a plane.
fn part(polygon: &[FaceCorner], normal: Vec3, reach: f32) -> (Vec<FaceCorner>, Vec<FaceCorner>) {
    let side = |corner: &FaceCorner| {
        let off = normal.dot(corner.flat) - reach;
        if off.abs() < 1e-6 { 0.0 } else { off }
    };
    let (mut within, mut beyond) = (Vec::new(), Vec::new());
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        let (s, t) = (side(a), side(b));
        if s <= 0.0 {
            within.push(*a);
        }
        if s >= 0.0 {
            beyond.push(*a);
        }
        if s * t < 0.0 {
            // Computed in one direction, so that both faces of an edge get the same bits.
            let first = (a.at.x, a.at.y, a.at.z) < (b.at.x, b.at.y, b.at.z);
            let cut = if first { a.mix(b, s / (s - t)) } else { b.mix(a, t / (t - s)) };
            within.push(cut);
            beyond.push(cut);
        }
    }
    let real = |part: &Vec<FaceCorner>| part.iter().any(|c| side(c) != 0.0);
    (if real(&within) { within } else { Vec::new() }, if real(&beyond) { beyond } else { Vec::new() })
}

/// Splits a convex polygon into triangles.
fn fan(polygon: &[FaceCorner], finish: SurfaceFinish, into: &mut Vec<BodyFace>) {
    for k in 1..polygon.len().saturating_sub(1) {
        into.push(BodyFace { corners: [polygon[0], polygon[k], polygon[k + 1]], finish });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Material;
    use crate::scene::mesh::TriangleList;
    use crate::scene::mesh::tests::{check, open_edges, volume_m3};

    fn cube() -> PanelSkin {
        let mut triangles = TriangleList::default();
        triangles.cuboid(Vec3::new(0.0, 2.0, 0.0), Vec3::ONE, SurfaceFinish::grey(Material::Paint, 1.0));
        let mut skin = PanelSkin::default();
        for corners in triangles.corners() {
            let [a, b, c] = corners;
            skin.quad([a, b, c, c], |p| p, SurfaceFinish::grey(Material::Paint, 1.0));
        }
        skin.smooth(0.7);
        skin
    }

    #[test]
    fn a_cut_body_stays_closed_and_keeps_its_volume() {
        let hexagon: Vec<Vec2> = (0..6).map(|k| Vec2::from_angle(k as f32) * 0.6).collect();
        let mut skin = cube();
        skin.paint(&CutRegion::seen_along(1, &hexagon).facing(Vec3::Y, 0.5), SurfaceFinish::grey(Material::Glass, 0.1));
        skin.close_seams();
        let mesh = skin.mesh();
        check(&mesh, "cut");
        assert_eq!(open_edges(&mesh), 0);
        assert!((volume_m3(&mesh) - 8.0).abs() < 1e-3);
    }

    #[test]
    fn a_recess_takes_its_depth_times_its_area_from_the_body() {
        let square = [Vec2::new(-0.5, -0.5), Vec2::new(0.5, -0.5), Vec2::new(0.5, 0.5), Vec2::new(-0.5, 0.5)];
        let dark = SurfaceFinish::grey(Material::Matt, 0.1);
        let mut skin = cube();
        let cell = CutRegion::seen_along(1, &square).facing(Vec3::Y, 0.5);
        let inside = skin.recess(&cell, |p| p - Vec3::Y * 0.2, dark, dark);
        assert!(!inside.is_empty());
        skin.close_seams();
        let mesh = skin.mesh();
        check(&mesh, "recess");
        assert_eq!(open_edges(&mesh), 0);
        assert!((volume_m3(&mesh) - 7.8).abs() < 1e-3, "{}", volume_m3(&mesh));
    }
}
