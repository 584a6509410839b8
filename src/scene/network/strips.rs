//! Ribbons and areas of paved ground. In: points along a line with columns beside it, outlines. Out: one mesh in world axes. `uv` is in
//! metres: along and across on lanes; world coordinates on areas, shifted away from the range in which lanes have wheel tracks.

use super::{
    layer::{Layer, PAINT},
    triangulation,
};
use crate::{
    roadside::{noise, relief::Relief},
    scene::{Material, Mesh, Vertex, colours::shade, land},
};
use glam::{Vec2, Vec3};

/// Half the width of the line that `road.wgsl` draws, and distance of the line's middle from the strip's edge, metres.
const LINE_HALF_M: f32 = 0.059;
const LINE_MIDDLE: f32 = 0.22;

/// Material of a ribbon between two columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ground {
    /// Asphalt or similar paving in the columns' colours, with a slight random variation.
    Tarred,
    /// Paving in the columns' colours without variation, so that overlapping ribbons of one layer match.
    Even,
    /// Asphalt with a painted line. The columns' `share` is the distance from the strip's edge, in the metres of `road.wgsl`.
    Painted,
    /// Gravel with grass growing into it, more of it the greater the columns' `share`.
    Grown,
}

/// Line of vertices at a constant offset from a centre line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    /// Offset to the left of the line, metres.
    pub offset_m: f64,
    /// Height above the line, metres.
    pub z_m: f32,
    /// Colour of paving or paint, linear albedo; unused on the verge.
    pub colour: [f32; 3],
    /// Position within a painted line's strip, or amount of grass on the verge: see [`Ground`].
    pub share: f32,
}

impl Column {
    /// Returns a column of paved ground.
    pub fn tarred(offset_m: f64, layer: Layer, colour: [f32; 3]) -> Self {
        Self { offset_m, z_m: layer.z_m(), colour, share: 0.0 }
    }

    /// Returns a column of a strip with a painted line. `half_width_m` is half the line's width. `off_m` is the column's offset from the
    /// line's middle.
    pub fn painted(offset_m: f64, layer: Layer, off_m: f64, half_width_m: f64) -> Self {
        let share = LINE_MIDDLE + off_m as f32 * LINE_HALF_M / half_width_m as f32;
        Self { offset_m, z_m: layer.z_m(), colour: PAINT, share }
    }

    /// Returns a column of the verge.
    pub fn grown(offset_m: f64, z_m: f32, share: f32) -> Self {
        Self { offset_m, z_m, colour: [0.0; 3], share }
    }
}

/// Builder of the mesh of roads.
pub(super) struct Paver<'a> {
    /// Mesh of all ribbons and areas so far.
    pub mesh: Mesh,
    relief: &'a Relief<'a>,
    seed: u64,
    /// Offset from world coordinates to `uv` on areas, metres.
    shift: Vec2,
}

impl<'a> Paver<'a> {
    /// Returns a paver with an empty mesh. `low` is the south-west corner of a box around all roads.
    pub fn new(relief: &'a Relief<'a>, seed: u64, low: Vec2) -> Self {
        // Wheel tracks and repairs lie within 3 m of a lane's middle, at smaller `uv` than any area.
        Self { mesh: Mesh::default(), relief, seed, shift: Vec2::splat(16.0) - low }
    }

    /// Adds a ribbon between two columns, the right one first, along the `rows` of a line. `place` returns the point at a row and an
    /// offset. `start` is added to the row for `uv`; without it, the ribbon has the `uv` of areas.
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

    /// Adds an area on a layer, in one colour.
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

    /// Adds a painted line with its middle from `from` to `to`, as one flat quadrilateral.
    pub fn painted_line(&mut self, from: Vec3, to: Vec3, half_width_m: f32) {
        // Width of the strip, as a multiple of the line's: its edges are bare asphalt.
        const BARE: f32 = 1.15;
        let along = to - from;
        let across = Vec3::Z.cross(along).normalize_or_zero() * half_width_m * BARE;
        let edge = f64::from(half_width_m * BARE);
        let columns = [-edge, edge].map(|off_m| Column::painted(off_m, Layer::Paint, off_m, half_width_m.into()));
        let place = |row: f64, off_m: f64| from + along * row as f32 + across * (off_m / edge) as f32;
        self.ribbon(&[0.0, 1.0], &place, columns, Ground::Painted, None);
    }

    /// Adds a convex area of paint. `corners` lie on the ground, in either order.
    pub fn painted_area(&mut self, corners: &[Vec3]) {
        let doubled = corners.windows(2).map(|pair| (pair[0] - corners[0]).cross(pair[1] - corners[0])).sum::<Vec3>();
        if doubled.length() < 1e-4 {
            return;
        }
        let (normal, faces_up) = (doubled.normalize() * doubled.z.signum(), doubled.z > 0.0);
        let first = self.mesh.vertices.len() as u32;
        let column = Column::painted(0.0, Layer::Paint, 0.0, LINE_HALF_M.into());
        for corner in corners {
            self.vertex(*corner + Vec3::Z * column.z_m, normal, &column, Ground::Painted, None);
        }
        for k in 1..corners.len() as u32 - 1 {
            let [b, c] = if faces_up { [k, k + 1] } else { [k + 1, k] };
            self.mesh.indices.extend([first, first + b, first + c]);
        }
    }

    fn vertex(&mut self, at: Vec3, normal: Vec3, column: &Column, ground: Ground, uv: Option<Vec2>) {
        let point = at.truncate();
        let patch = || noise::fractal(self.seed ^ 0x0a5f, point / 9.0);
        let mut colour = match ground {
            Ground::Even => column.colour,
            Ground::Tarred => shade(column.colour, 1.0 + 0.10 * patch()),
            Ground::Painted => shade(column.colour, 1.0 + 0.05 * patch()),
            Ground::Grown => land::colour(self.relief, point),
        };
        let material = match ground {
            Ground::Tarred | Ground::Even => Material::Asphalt,
            Ground::Painted => Material::Marking,
            Ground::Grown => Material::Verge,
        };
        if matches!(ground, Ground::Painted | Ground::Grown) {
            // The blue channel of paint and grass carries the share (`road.wgsl`).
            colour[2] = column.share;
        }
        // `uv` on walls and kerbs is along and up.
        let on_area = || if normal.z > 0.3 { point + self.shift } else { Vec2::new(point.x + point.y, at.z + 64.0) };
        let uv = uv.unwrap_or_else(on_area);
        self.mesh.vertex(Vertex::new(at, normal, colour, uv, material));
    }
}
