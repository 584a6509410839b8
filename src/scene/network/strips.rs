//! Ribbons and areas of paved ground. In: places along a line with columns beside it, outlines. Out: one mesh in world axes; `uv` is
//! metres along and across on lanes, and metres of the world on areas, far from where lanes have their tracks.

use super::{Layer, PAINT, triangulation};
use crate::scene::{
    Material, Mesh, Vertex,
    land::{
        Relief,
        noise::{self, shade},
    },
};
use glam::{Vec2, Vec3};

/// Half the width of the line that `road.wgsl` draws, and how far into its strip the line's middle lies, metres.
const LINE_HALF_M: f32 = 0.059;
const LINE_MIDDLE: f32 = 0.22;

/// What a ribbon is made of between two columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ground {
    /// Asphalt, and what is paved like it, in the columns' colours.
    Tarred,
    /// The same without patches: where ribbons lie over each other on one layer, they are one colour.
    Even,
    /// Asphalt with a painted line; the columns' `share` says how far into the line's strip they are.
    Painted,
    /// Gravel with grass growing into it; the columns' `share` says how far.
    Grown,
}

/// A line of corners beside a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    /// Metres to the left of the line.
    pub offset_m: f64,
    /// Height over the line, metres.
    pub z_m: f32,
    /// Colour where it is tarred.
    pub colour: [f32; 3],
    /// See [`Ground`].
    pub share: f32,
}

impl Column {
    /// A column of tarred ground.
    pub fn tarred(offset_m: f64, layer: Layer, colour: [f32; 3]) -> Self {
        Self { offset_m, z_m: layer.z_m(), colour, share: 0.0 }
    }

    /// A column of a strip with a painted line `half_width_m` wide on both sides of its middle, which is `off_m` from the column.
    pub fn painted(offset_m: f64, layer: Layer, off_m: f64, half_width_m: f64) -> Self {
        let share = LINE_MIDDLE + off_m as f32 * LINE_HALF_M / half_width_m as f32;
        Self { offset_m, z_m: layer.z_m(), colour: PAINT, share }
    }

    /// A column of the verge.
    pub fn grown(offset_m: f64, z_m: f32, share: f32) -> Self {
        Self { offset_m, z_m, colour: [0.0; 3], share }
    }
}

/// Makes the mesh.
pub(super) struct Paver<'a> {
    /// What is paved so far.
    pub mesh: Mesh,
    relief: &'a Relief<'a>,
    seed: u64,
    /// From the world to `uv` of areas.
    shift: Vec2,
}

impl<'a> Paver<'a> {
    /// Nothing is paved yet; nothing lies further south-west than `low`.
    pub fn new(relief: &'a Relief<'a>, seed: u64, low: Vec2) -> Self {
        // Tracks of wheels, and repairs, lie up to 3 m from the middle of a lane.
        Self { mesh: Mesh::default(), relief, seed, shift: Vec2::splat(16.0) - low }
    }

    /// A ribbon between two columns, the right one first, through `rows` of a line; `place` gives the place at a row and an offset.
    /// `start` is added to the row for `uv`; without it, `uv` is that of areas.
    pub fn ribbon(
        &mut self,
        rows: &[f64],
        place: &dyn Fn(f64, f64) -> Vec3,
        [right, left]: [Column; 2],
        ground: Ground,
        start: Option<f64>,
    ) {
        if rows.len() < 2 {
            return;
        }
        let first = self.mesh.vertices.len() as u32;
        let corner = |row: f64, column: &Column| place(row, column.offset_m) + Vec3::Z * column.z_m;
        for (k, &row) in rows.iter().enumerate() {
            let (before, after) = (rows[k.saturating_sub(1)], rows[(k + 1).min(rows.len() - 1)]);
            let along = corner(after, &right) + corner(after, &left) - corner(before, &right) - corner(before, &left);
            let across = corner(row, &left) - corner(row, &right);
            let normal = along.cross(across).try_normalize().filter(|normal| normal.z > -1e-3).unwrap_or(Vec3::Z);
            for column in [&right, &left] {
                let at = corner(row, column);
                let uv = start.map(|start| Vec2::new((row + start) as f32, column.offset_m as f32));
                self.vertex(at, normal, column, ground, uv);
            }
        }
        for row in 0..rows.len() as u32 - 1 {
            let at = first + 2 * row;
            self.mesh.indices.extend([at, at + 2, at + 3, at, at + 3, at + 1]);
        }
    }

    /// An area on a layer, in one colour.
    pub fn area(&mut self, outline: &[Vec3], layer: Layer, colour: [f32; 3]) {
        let flat: Vec<Vec2> = outline.iter().map(|point| point.truncate()).collect();
        let triangles = triangulation::triangles(&flat);
        let first = self.mesh.vertices.len() as u32;
        let column = Column::tarred(0.0, layer, colour);
        for point in outline {
            self.vertex(*point + Vec3::Z * layer.z_m(), Vec3::Z, &column, Ground::Tarred, None);
        }
        self.mesh.indices.extend(triangles.iter().flatten().map(|corner| first + *corner as u32));
    }

    /// A flat quadrilateral of paint that is drawn as one line, whose middle runs from `from` to `to`.
    pub fn painted_line(&mut self, from: Vec3, to: Vec3, half_width_m: f32) {
        // What of the strip is bare.
        const BARE: f32 = 1.15;
        let along = to - from;
        let across = Vec3::Z.cross(along).normalize_or_zero() * half_width_m * BARE;
        let edge = f64::from(half_width_m * BARE);
        let columns = [-edge, edge].map(|off_m| Column::painted(off_m, Layer::Paint, off_m, half_width_m.into()));
        let place = |row: f64, off_m: f64| from + along * row as f32 + across * (off_m / edge) as f32;
        self.ribbon(&[0.0, 1.0], &place, columns, Ground::Painted, None);
    }

    fn vertex(&mut self, at: Vec3, normal: Vec3, column: &Column, ground: Ground, uv: Option<Vec2>) {
        let point = at.truncate();
        let patch = || noise::fractal(self.seed ^ 0x0a5f, point / 9.0);
        let mut colour = match ground {
            Ground::Even => column.colour,
            Ground::Tarred => shade(column.colour, 1.0 + 0.10 * patch()),
            Ground::Painted => shade(column.colour, 1.0 + 0.05 * patch()),
            Ground::Grown => self.relief.colour(point),
        };
        let material = match ground {
            Ground::Tarred | Ground::Even => Material::Asphalt,
            Ground::Painted => Material::Marking,
            Ground::Grown => Material::Verge,
        };
        if matches!(ground, Ground::Painted | Ground::Grown) {
            // Paint and grass spare a channel (`road.wgsl`).
            colour[2] = column.share;
        }
        // On walls and kerbs, along and up.
        let on_area = || if normal.z > 0.3 { point + self.shift } else { Vec2::new(point.x + point.y, at.z + 64.0) };
        let uv = uv.unwrap_or_else(on_area);
        self.mesh.vertex(Vertex::new(at, normal, colour, uv, material));
    }
}
