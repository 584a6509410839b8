//! Parts of buildings: walls with facades, roofs, boxes. In: sizes in the building's own frame. Out: triangles in a mesh. Metres; x to the
//! right along the front as seen from the street, y inwards, z up from the ground floor.

use super::facade::Facade;
use crate::scene::{Material, Mesh, Vertex};
use glam::{Vec2, Vec3};

/// Thickness of a roof at its eaves, metres.
const ROOF_M: f32 = 0.16;
/// Height of a flat roof's parapet over the roof, and its width, metres.
const PARAPET_M: [f32; 2] = [0.5, 0.25];

/// Builder of a building's mesh.
#[derive(Debug, Default)]
pub(super) struct Shell {
    pub mesh: Mesh,
}

/// Rectangle that four walls stand on.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallPlan {
    pub low: Vec2,
    pub high: Vec2,
}

/// Dimensions and colours of a pitched roof.
#[derive(Clone, Copy, Debug)]
pub(super) struct PitchedRoof {
    /// Height of the walls, metres.
    pub eaves_m: f32,
    /// Rise over the horizontal distance.
    pub slope: f32,
    /// Overhang beyond the walls, metres: at the eaves, at the gables.
    pub overhang_m: [f32; 2],
    /// True if the ridge runs along x.
    pub is_along: bool,
    /// True if all four sides slope.
    pub is_hipped: bool,
    pub tiles: [f32; 3],
    pub trim: [f32; 3],
}

impl PitchedRoof {
    /// Returns the height of the ridge over the ground floor, metres.
    pub fn ridge_m(&self, walls: WallPlan) -> f32 {
        let size = walls.high - walls.low;
        self.eaves_m + self.slope * if self.is_along { size.y } else { size.x } / 2.0
    }
}

impl Shell {
    /// Adds a flat polygon with its corners counter-clockwise as seen from outside.
    pub fn polygon(&mut self, corners: &[(Vec3, Vec2)], colour: [f32; 3], material: u32) {
        let [a, b, c] = [corners[0].0, corners[1].0, corners[2].0];
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { return };
        let first = self.mesh.vertices.len() as u32;
        for (at, uv) in corners {
            let vertex = Vertex { material, ..Vertex::new(*at, normal, colour, *uv, Material::Matt) };
            self.mesh.vertex(vertex);
        }
        for k in 1..corners.len() as u32 - 1 {
            self.mesh.indices.extend([first, first + k, first + k + 1]);
        }
    }

    /// Adds a plain flat polygon.
    pub fn plain(&mut self, corners: &[Vec3], colour: [f32; 3]) {
        let corners: Vec<(Vec3, Vec2)> = corners.iter().map(|at| (*at, Vec2::ZERO)).collect();
        self.polygon(&corners, colour, Material::Matt as u32);
    }

    /// Adds a plain box with its edges along the axes, without an underside.
    pub fn plain_box(&mut self, low: Vec3, high: Vec3, colour: [f32; 3]) {
        let at = |x: bool, y: bool, z: bool| {
            Vec3::new(if x { high.x } else { low.x }, if y { high.y } else { low.y }, if z { high.z } else { low.z })
        };
        let faces = [
            [at(false, false, false), at(true, false, false), at(true, false, true), at(false, false, true)],
            [at(true, false, false), at(true, true, false), at(true, true, true), at(true, false, true)],
            [at(true, true, false), at(false, true, false), at(false, true, true), at(true, true, true)],
            [at(false, true, false), at(false, false, false), at(false, false, true), at(false, true, true)],
            [at(false, false, true), at(true, false, true), at(true, true, true), at(false, true, true)],
        ];
        faces.iter().for_each(|face| self.plain(face, colour));
    }

    /// Adds a wall from `from` to `to`, left to right as seen from outside, between two heights. Its openings begin at the ground floor.
    pub fn wall(&mut self, [from, to]: [Vec2; 2], [low_m, high_m]: [f32; 2], colour: [f32; 3], facade: (Facade, f32)) {
        let (facade, along_m) = facade;
        let corner = |at: Vec2, u: f32, z: f32| (at.extend(z), Vec2::new(u, z));
        let corners = [
            corner(from, 0.0, low_m),
            corner(to, along_m, low_m),
            corner(to, along_m, high_m),
            corner(from, 0.0, high_m),
        ];
        self.polygon(&corners, colour, facade.material());
    }

    /// Adds a surface of a roof with tiles in rows along its lower edge, from `low[0]` to `low[1]`, left to right as seen from outside.
    pub fn slope(&mut self, low: [Vec3; 2], high: &[Vec3], tiles: [f32; 3]) {
        let along = (low[1] - low[0]).normalize_or(Vec3::X);
        let uv = |at: Vec3| {
            let off = at - low[0];
            let along_m = off.dot(along);
            Vec2::new(along_m, (off - along * along_m).length())
        };
        let corners: Vec<(Vec3, Vec2)> = low.iter().chain(high).map(|at| (*at, uv(*at))).collect();
        self.polygon(&corners, tiles, Material::Roof as u32);
    }

    /// Adds a pitched roof over four walls, with the gables' walls.
    pub fn pitched(&mut self, walls: WallPlan, roof: PitchedRoof, gable: [f32; 3], facade: Facade) {
        let PitchedRoof { eaves_m, slope, overhang_m: [eave_m, verge_m], tiles, trim, .. } = roof;
        let (middle, size) = ((walls.low + walls.high) / 2.0, walls.high - walls.low);
        // In a frame with the ridge along x.
        let half = if roof.is_along { size / 2.0 } else { Vec2::new(size.y, size.x) / 2.0 };
        let place = |x: f32, y: f32, z: f32| match roof.is_along {
            true => Vec3::new(middle.x + x, middle.y + y, z),
            false => Vec3::new(middle.x - y, middle.y + x, z),
        };
        let ridge_m = roof.ridge_m(walls) + ROOF_M;
        let reach = Vec2::new(half.x + if roof.is_hipped { eave_m } else { verge_m }, half.y + eave_m);
        let low_m = ridge_m - slope * reach.y;
        let ridge_half_m = if roof.is_hipped { (reach.x - reach.y).max(0.05) } else { reach.x };
        for side in [-1.0, 1.0] {
            let low = [side, -side].map(|end| place(end * reach.x, side * reach.y, low_m));
            let high = [-side, side].map(|end| place(end * ridge_half_m, 0.0, ridge_m));
            self.slope(low, &high, tiles);
            let below = |at: Vec3| at - Vec3::Z * ROOF_M;
            // The gutter's board, and what is seen of the roof from below.
            self.plain(&[below(low[0]), below(low[1]), low[1], low[0]], trim);
            let inner = [-side, side].map(|end| place(end * reach.x, side * half.y, eaves_m));
            self.plain(&[inner[0], below(low[1]), below(low[0]), inner[1]], trim);
            let gutter = [low[0], low[1]].map(|at| at - Vec3::Z * 0.05);
            let out = (place(0.0, side, 0.0) - place(0.0, 0.0, 0.0)) * 0.11;
            self.plain(
                &[gutter[0] + out - Vec3::Z * 0.1, gutter[1] + out - Vec3::Z * 0.1, gutter[1] + out, gutter[0] + out],
                [0.13; 3],
            );
            self.plain(&[gutter[0] + out, gutter[1] + out, gutter[1], gutter[0]], [0.05; 3]);
            if roof.is_hipped {
                let low = [place(side * reach.x, -side * reach.y, low_m), place(side * reach.x, side * reach.y, low_m)];
                self.slope(low, &[place(side * ridge_half_m, 0.0, ridge_m)], tiles);
                self.plain(&[below(low[0]), below(low[1]), low[1], low[0]], trim);
                continue;
            }
            // Gable wall, and the edge of the roof over it.
            let corner = |y: f32, z: f32| (place(side * half.x, y, z), Vec2::new(side * y + half.y, z));
            let top = (place(side * half.x, 0.0, ridge_m - ROOF_M), Vec2::new(half.y, ridge_m));
            self.polygon(
                &[corner(-side * half.y, eaves_m), corner(side * half.y, eaves_m), top],
                gable,
                facade.blank().material(),
            );
            for y in [-side, side] {
                let ends = [place(side * reach.x, y * reach.y, low_m), place(side * reach.x, 0.0, ridge_m)];
                let [a, b] = if y == -side { ends } else { [ends[1], ends[0]] };
                self.plain(&[below(a), below(b), b, a], trim);
                let inside =
                    |at: Vec3| at + (place(-side, 0.0, 0.0) - place(0.0, 0.0, 0.0)) * verge_m - Vec3::Z * ROOF_M;
                self.plain(&[inside(a), inside(b), below(b), below(a)], trim);
            }
        }
    }

    /// Adds a flat roof with a parapet that continues the walls.
    pub fn flat(&mut self, walls: WallPlan, eaves_m: f32, colour: [f32; 3], facade: Facade) {
        let [rise_m, width_m] = PARAPET_M;
        let top_m = eaves_m + rise_m;
        let corners = |inset: f32, z: f32| {
            let (low, high) = (walls.low + inset, walls.high - inset);
            [
                Vec3::new(low.x, low.y, z),
                Vec3::new(high.x, low.y, z),
                Vec3::new(high.x, high.y, z),
                Vec3::new(low.x, high.y, z),
            ]
        };
        let (outer, inner) = (corners(0.0, top_m), corners(width_m, top_m));
        let (foot, gravel) = (corners(0.0, eaves_m), corners(width_m, eaves_m + 0.1));
        for k in 0..4 {
            let next = (k + 1) % 4;
            let along_m = foot[k].distance(foot[next]);
            let wall = [(foot[k], 0.0), (foot[next], along_m), (outer[next], along_m), (outer[k], 0.0)];
            let wall = wall.map(|(at, u)| (at, Vec2::new(u, at.z)));
            self.polygon(&wall, colour, facade.blank().material());
            self.plain(&[outer[k], outer[next], inner[next], inner[k]], [0.30, 0.30, 0.29]);
            self.plain(&[inner[k], inner[next], gravel[next], gravel[k]], colour);
        }
        self.plain(&gravel, [0.20, 0.195, 0.185]);
    }

    /// Adds the underside of a box.
    pub fn underside(&mut self, low: Vec3, high: Vec3, colour: [f32; 3]) {
        let at = |x: f32, y: f32| Vec3::new(x, y, low.z);
        self.plain(&[at(low.x, high.y), at(high.x, high.y), at(high.x, low.y), low], colour);
    }

    /// Adds a hedge: a box of leaves that is narrower at its top.
    pub fn hedge(&mut self, low: Vec3, high: Vec3, colour: [f32; 3]) {
        let first = self.mesh.vertices.len();
        self.plain_box(low, high, colour);
        let middle = (low + high) / 2.0;
        for vertex in &mut self.mesh.vertices[first..] {
            vertex.material = Material::Hedge as u32;
            let [x, y, z] = vertex.position;
            if z > middle.z {
                vertex.position = [x + (middle.x - x).signum() * 0.12, y + (middle.y - y) * 0.3, z];
            }
        }
    }
}
