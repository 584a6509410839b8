//! The meshes on the device: one vertex and one index buffer, filled once. In: a [`StaticScene`]. Out: [`ModelMesh`]es
//! that a pass draws by instances, [`GroundMesh`]es that it draws piece by piece, and their bounding spheres, for
//! culling: on software rendering vertices cost more than pixels.

use super::{
    device::cost::CountedPass,
    level_of_detail::{CAR_LEVELS, InstanceBatches, TreeDetail},
    textures::impostor::{self, ImpostorExtent},
};
use crate::scene::{CarModel, Cockpit, Material, Mesh, StaticScene, Vertex};
use glam::{Vec2, Vec3, vec2};
use std::{ops::Range, sync::Arc};

/// A mesh in the shared buffers.
#[derive(Clone, Debug)]
pub struct ModelMesh {
    indices: Range<u32>,
    first_vertex: i32,
    /// Centre of the bounding sphere, in the mesh's own frame, m.
    pub centre: Vec3,
    /// Radius of the bounding sphere, m.
    pub radius_m: f32,
    /// Lowest and highest corner of the bounding box, in the mesh's own frame, m.
    pub bounds: [Vec3; 2],
}

/// A mesh in world axes, cut into pieces; only those in the picture are drawn.
#[derive(Clone, Debug)]
pub struct GroundMesh(Vec<ModelMesh>);

/// Maximum number of triangles in a piece of ground and of buildings, which are denser, and the approximate maximum
/// number of pieces of a very large ground: each piece is a draw.
const PIECE: usize = 600;
const BUILT_PIECE: usize = 1800;
const MOST_PIECES: usize = 250;
/// Corners of a square of half side 1, and of a triangle around the circle of radius 1. On software rendering a small
/// tree costs by its triangles, and from above it fills no more than that circle.
const SQUARE: [Vec2; 4] = [vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, 1.0)];
const TRIANGLE: [Vec2; 3] = [vec2(0.0, 2.0), vec2(-1.732_051, -1.0), vec2(1.732_051, -1.0)];

/// All meshes of a static scene.
#[derive(Debug)]
pub struct ModelMeshes {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    /// Road with its markings.
    pub road: GroundMesh,
    /// Line along the ego's path.
    pub route_line: ModelMesh,
    /// Meadow and far ground.
    pub land: GroundMesh,
    /// Reflector posts, and the supports of signals.
    pub posts: GroundMesh,
    /// Houses along streets: walls, then roofs, hedges and fences.
    pub buildings: [GroundMesh; 2],
    /// A lamp that is lit.
    pub lamp: ModelMesh,
    /// A tuft of grass.
    pub tuft: ModelMesh,
    /// Cars without wheels, by style and [`CarDetail`](super::level_of_detail::CarDetail).
    pub bodies: Vec<[ModelMesh; CAR_LEVELS]>,
    /// Styles of the next phase and of the standing posture by style, see [`CarModel::postures`].
    postures: Vec<Option<[usize; 2]>>,
    /// Windows of near and mid cars, by style.
    pub glass: Vec<[ModelMesh; 2]>,
    /// Parts of the ego seen from inside: bonnet, shelf, cabin, steering wheel, wipers at rest, one wiper, windscreen.
    pub cockpit: [ModelMesh; 7],
    /// Housings of the ego's mirrors, see [`Cockpit::housings`].
    pub housings: [ModelMesh; 4],
    /// One wheel by level.
    pub wheels: [ModelMesh; 3],
    /// Trees by kind and [`TreeDetail`]; far ones are a square for a picture.
    pub trees: Vec<[ModelMesh; 4]>,
    /// Triangles for pictures of trees from above, by kind.
    pub trees_from_above: Vec<ModelMesh>,
}

impl ModelMeshes {
    /// Uploads the meshes of a static scene.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, static_scene: &StaticScene) -> Self {
        let mut vertices: Vec<Vertex> = Vec::new();
        let mut indices: Vec<u32> = Vec::new();
        let mut add = |mesh: &Mesh| {
            let first = indices.len() as u32;
            let first_vertex = vertices.len() as i32;
            vertices.extend_from_slice(&mesh.vertices);
            indices.extend_from_slice(&mesh.indices);
            let (centre, radius_m) = mesh.bounding_sphere();
            let bounds = mesh.bounds().into();
            ModelMesh { indices: first..indices.len() as u32, first_vertex, centre, radius_m, bounds }
        };
        let mut ground = |mesh: &Mesh, most| GroundMesh(pieces(mesh, most).iter().map(&mut add).collect());
        let [road, land, posts] =
            [&static_scene.road, &static_scene.land, &static_scene.posts].map(|mesh| ground(mesh, PIECE));
        let parts = [true, false].map(|walls| part_of(&static_scene.buildings, walls));
        let buildings = parts.each_ref().map(|part| ground(part, BUILT_PIECE));
        let route_line = add(&static_scene.route_line);
        let tuft = add(&static_scene.tuft);
        let lamp = add(&static_scene.lit_lamp);
        let bodies = static_scene.cars.iter().map(|car| {
            let CarModel { levels: [near, mid, far], plan, shade, .. } = car;
            let levels = [near, mid, far, plan, shade];
            let mut stored: Vec<ModelMesh> = Vec::with_capacity(CAR_LEVELS);
            for (level, mesh) in levels.iter().enumerate() {
                // A mesh of several levels is stored once.
                let same = levels[..level].iter().position(|before| Arc::ptr_eq(before, mesh));
                stored.push(same.map_or_else(|| add(mesh), |before| stored[before].clone()));
            }
            stored.try_into().expect("one for each level")
        });
        let bodies = bodies.collect();
        let postures = static_scene.cars.iter().map(|car| car.postures).collect();
        let glass = static_scene.cars.iter().map(|car| [0, 1].map(|level| add(&car.glass[level]))).collect();
        let Cockpit { bonnet, shelf, cabin, wheel, resting_wipers, wiper, windscreen, housings } =
            &static_scene.cockpit;
        let cockpit = [bonnet, shelf, cabin, wheel, resting_wipers, wiper, windscreen].map(&mut add);
        let housings = [0, 1, 2, 3].map(|which| add(&housings[which]));
        let wheels = [0, 1, 2].map(|level| add(&static_scene.wheels[level]));
        let pictured = |corners: &[Vec2]| -> Vec<Mesh> {
            static_scene.trees.iter().enumerate().map(|(kind, tree)| picture(kind, tree, corners)).collect()
        };
        let [squares, triangles] = [pictured(&SQUARE), pictured(&TRIANGLE)];
        let levels = [&static_scene.trees, &static_scene.trees_mid, &squares, &static_scene.trees_shade];
        let trees = (0..static_scene.trees.len()).map(|kind| levels.map(|level| add(&level[kind]))).collect();
        let trees_from_above = triangles.iter().map(&mut add).collect();
        let buffer = |label, bytes: &[u8], usage| {
            // One spare vertex, so that an empty scene is no special case (a buffer may not be empty).
            let size = bytes.len().next_multiple_of(4) as u64 + size_of::<Vertex>() as u64;
            let usage = usage | wgpu::BufferUsages::COPY_DST;
            let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
            let buffer = device.create_buffer(&descriptor);
            queue.write_buffer(&buffer, 0, bytes);
            buffer
        };
        Self {
            vertices: buffer("vertices", bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX),
            indices: buffer("indices", bytemuck::cast_slice(&indices), wgpu::BufferUsages::INDEX),
            road,
            route_line,
            land,
            posts,
            buildings,
            lamp,
            tuft,
            bodies,
            postures,
            glass,
            cockpit,
            housings,
            wheels,
            trees,
            trees_from_above,
        }
    }

    /// Binds the meshes as the source of the pass's draws.
    pub fn bind(&self, pass: &mut CountedPass) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
    }

    /// Draws parts without a clear coat: the ego's shelf and cabin, wheels of all levels.
    pub fn draw_uncoated(&self, pass: &mut CountedPass, batches: &InstanceBatches) {
        let [_, shelf, cabin, ..] = &self.cockpit;
        let [body, furnished, ..] = &batches.inside;
        shelf.draw(pass, body.clone());
        cabin.draw(pass, furnished.clone());
        for (model, range) in self.wheels.iter().zip(&batches.wheels) {
            model.draw(pass, range.clone());
        }
    }

    /// Draws bodies of all styles and levels but people's, the ego's bonnet, steering wheel, wipers and mirror housings.
    pub fn draw_cars(&self, pass: &mut CountedPass, batches: &InstanceBatches) {
        let [bonnet, _, _, wheel, resting, wiper, _] = &self.cockpit;
        let [body, _, steered, at_rest, moving] = &batches.inside;
        for (model, range) in [(bonnet, body), (wheel, steered), (resting, at_rest), (wiper, moving)] {
            model.draw(pass, range.clone());
        }
        for (model, range) in self.housings.iter().zip(&batches.housings) {
            model.draw(pass, range.clone());
        }
        self.draw_bodies(pass, batches);
    }

    /// Draws the ego's windscreen, if the picture is taken from inside.
    pub fn draw_windscreen(&self, pass: &mut CountedPass, batches: &InstanceBatches) {
        let [.., windscreen] = &self.cockpit;
        windscreen.draw(pass, batches.inside[0].clone());
    }

    /// Draws bodies of all styles and levels but people's.
    pub fn draw_bodies(&self, pass: &mut CountedPass, batches: &InstanceBatches) {
        let vehicles = self.bodies.iter().zip(&batches.bodies).zip(&self.postures).filter(|(_, of)| of.is_none());
        for ((models, ranges), _) in vehicles {
            models.iter().zip(ranges).for_each(|(model, range)| model.draw(pass, range.clone()));
        }
    }

    /// Draws people with this pipeline, if there are any, blended between the phases of their gait. Leaves the meshes bound.
    pub fn draw_people(&self, pass: &mut CountedPass, batches: &InstanceBatches, pipeline: &wgpu::RenderPipeline) {
        let mut is_first = true;
        for (style, ranges) in batches.bodies.iter().enumerate() {
            let Some(postures) = self.postures[style] else { continue };
            for (level, range) in ranges.iter().enumerate().filter(|(_, range)| !range.is_empty()) {
                if std::mem::take(&mut is_first) {
                    pass.set_pipeline(pipeline);
                }
                for (slot, style) in [(0, style), (2, postures[0]), (3, postures[1])] {
                    let first = self.bodies[style][level].first_vertex as u64 * size_of::<Vertex>() as u64;
                    pass.set_vertex_buffer(slot, self.vertices.slice(first..));
                }
                pass.draw_indexed(self.bodies[style][level].indices.clone(), 0, range.clone());
            }
        }
        if !is_first {
            self.bind(pass);
        }
    }

    /// Draws the outer shapes of all bodies, in whose mirror images on a wet road nothing smaller is visible. People are in the last phase of
    /// their gait.
    pub fn draw_mirrored(&self, pass: &mut CountedPass, batches: &InstanceBatches) {
        for ([_, _, far, plan, _], [near, _, last, coarse, _]) in self.bodies.iter().zip(&batches.bodies) {
            // The instances of the three fine levels follow each other.
            far.draw(pass, near.start..last.end);
            plan.draw(pass, coarse.clone());
        }
    }

    /// Draws the transparent windows, far ones first.
    pub fn draw_glass(&self, pass: &mut CountedPass, batches: &InstanceBatches) {
        for level in [1, 0] {
            for (models, ranges) in self.glass.iter().zip(&batches.bodies) {
                models[level].draw(pass, ranges[level].clone());
            }
        }
    }

    /// Draws the trees with leaf cards of all kinds, the nearest first, so that hidden pixels are not shaded.
    pub fn draw_trees(&self, pass: &mut CountedPass, ranges: &[[Range<u32>; 4]]) {
        self.draw_trees_of(pass, ranges, TreeDetail::Near);
        self.draw_trees_of(pass, ranges, TreeDetail::Mid);
    }

    /// Draws the pictures of far trees, seen from above or from the sides.
    pub fn draw_far_trees(&self, pass: &mut CountedPass, ranges: &[[Range<u32>; 4]], from_above: bool) {
        if !from_above {
            return self.draw_trees_of(pass, ranges, TreeDetail::Far);
        }
        for (model, ranges) in self.trees_from_above.iter().zip(ranges) {
            model.draw(pass, ranges[TreeDetail::Far as usize].clone());
        }
    }

    /// Draws the trees' shapes for shadows.
    pub fn draw_tree_shades(&self, pass: &mut CountedPass, ranges: &[[Range<u32>; 4]]) {
        self.draw_trees_of(pass, ranges, TreeDetail::Shade);
    }

    fn draw_trees_of(&self, pass: &mut CountedPass, ranges: &[[Range<u32>; 4]], detail: TreeDetail) {
        for (models, ranges) in self.trees.iter().zip(ranges) {
            models[detail as usize].draw(pass, ranges[detail as usize].clone());
        }
    }
}

impl ModelMesh {
    /// Draws the instances in `range`; nothing for an empty mesh or range.
    pub fn draw(&self, pass: &mut CountedPass, range: Range<u32>) {
        if !range.is_empty() && !self.indices.is_empty() {
            pass.draw_indexed(self.indices.clone(), self.first_vertex, range);
        }
    }

    /// Draws some of the mesh's indices once, in world axes.
    pub fn draw_part(&self, pass: &mut CountedPass, part: Range<u32>) {
        let Range { start, end } = part;
        let indices = self.indices.start + start..(self.indices.start + end).min(self.indices.end);
        Self { indices, ..self.clone() }.draw(pass, 0..1);
    }
}

impl GroundMesh {
    /// Draws the pieces for which `seen` is true; the first instance is the world itself.
    pub fn draw(&self, pass: &mut CountedPass, seen: impl Fn(&ModelMesh) -> bool) {
        for piece in self.0.iter().filter(|piece| seen(piece)) {
            piece.draw(pass, 0..1);
        }
    }

    /// Draws the pieces as [`GroundMesh::draw`] does, in the order of their distance from the eye: near ones hide pixels of far ones, which are
    /// then not shaded.
    pub fn draw_nearest_first(&self, pass: &mut CountedPass, eye: Vec3, seen: impl Fn(&ModelMesh) -> bool) {
        let mut near: Vec<&ModelMesh> = self.0.iter().filter(|piece| seen(piece)).collect();
        let nearest_m = |piece: &ModelMesh| piece.centre.distance(eye) - piece.radius_m;
        near.sort_by(|a, b| nearest_m(a).total_cmp(&nearest_m(b)));
        near.into_iter().for_each(|piece| piece.draw(pass, 0..1));
    }
}

/// Returns the walls of a mesh of buildings, or all but them.
fn part_of(buildings: &Mesh, walls: bool) -> Mesh {
    let is_wall = |index: u32| buildings.vertices[index as usize].material & 0xff == Material::Wall as u32;
    let triangles: &[[u32; 3]] = buildings.indices.as_chunks().0;
    let some: Vec<[u32; 3]> = triangles.iter().filter(|corners| is_wall(corners[0]) == walls).copied().collect();
    extract(buildings, &some)
}

/// Cuts a mesh into compact pieces of at most `piece` triangles, or a very large mesh into about [`MOST_PIECES`], by
/// repeatedly halving along the longer side.
fn pieces(mesh: &Mesh, piece: usize) -> Vec<Mesh> {
    let corner = |index: u32| Vec3::from(mesh.vertices[index as usize].position).truncate();
    let middle = |t: &[u32; 3]| (corner(t[0]) + corner(t[1]) + corner(t[2])) / 3.0;
    let mut whole: Vec<(Vec2, [u32; 3])> = mesh.indices.as_chunks().0.iter().map(|t| (middle(t), *t)).collect();
    let most = piece.max(whole.len() / MOST_PIECES);
    let mut todo = vec![whole.as_mut_slice()];
    let mut done = Vec::new();
    while let Some(part) = todo.pop() {
        if part.len() <= most {
            let triangles: Vec<[u32; 3]> = part.iter().map(|(_, triangle)| *triangle).collect();
            done.push(extract(mesh, &triangles));
            continue;
        }
        let middles = || part.iter().map(|(middle, _)| *middle);
        let size = middles().fold(Vec2::NEG_INFINITY, Vec2::max) - middles().fold(Vec2::INFINITY, Vec2::min);
        let axis = if size.x > size.y { 0 } else { 1 };
        let half = part.len() / 2;
        part.select_nth_unstable_by(half, |(a, _), (b, _)| a[axis].total_cmp(&b[axis]));
        let (left, right) = part.split_at_mut(half);
        todo.extend([left, right]);
    }
    done
}

/// Returns the shape for a tree's pictures (`Corner` in `far.wgsl`): a fan over `corners`, in units of half a side.
fn picture(kind: usize, tree: &Mesh, corners: &[Vec2]) -> Mesh {
    let ImpostorExtent { half_m, middle_m, filled: [across, high] } = ImpostorExtent::of(tree);
    let corner = |at: &Vec2| Vertex {
        position: [at.x * half_m, middle_m, at.y * half_m],
        normal: [(kind * impostor::VIEWS) as f32, across, high],
        uv: [half_m, 0.0],
        ..Default::default()
    };
    let fan = (2..corners.len() as u32).flat_map(|last| [0, last - 1, last]);
    Mesh { vertices: corners.iter().map(corner).collect(), indices: fan.collect() }
}

/// Returns some triangles of a mesh with the vertices they need.
fn extract(mesh: &Mesh, triangles: &[[u32; 3]]) -> Mesh {
    let mut used: Vec<u32> = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let new = |old: &u32| used.binary_search(old).expect("collected above") as u32;
    Mesh {
        vertices: used.iter().map(|&old| mesh.vertices[old as usize]).collect(),
        indices: triangles.as_flattened().iter().map(new).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pieces_of_a_ground_are_compact_and_make_the_whole_ground() {
        const SIDE: u32 = 60;
        let mut mesh = Mesh::default();
        for i in 0..=SIDE {
            for j in 0..=SIDE {
                mesh.vertices.push(Vertex { position: [i as f32, j as f32, 0.0], ..Default::default() });
            }
        }
        for i in 0..SIDE {
            for j in 0..SIDE {
                let at = i * (SIDE + 1) + j;
                mesh.indices.extend([at, at + SIDE + 1, at + SIDE + 2, at, at + SIDE + 2, at + 1]);
            }
        }
        let pieces = pieces(&mesh, PIECE);
        let places = |mesh: &Mesh| {
            let triangle = |t: &[u32]| [t[0], t[1], t[2]].map(|i| mesh.vertices[i as usize].position.map(f32::to_bits));
            mesh.indices.chunks(3).map(triangle).collect::<Vec<_>>()
        };
        let mut together: Vec<_> = pieces.iter().flat_map(places).collect();
        let mut whole = places(&mesh);
        together.sort_unstable();
        whole.sort_unstable();
        assert!(together == whole);
        for piece in &pieces {
            assert!(piece.indices.len() <= 3 * PIECE);
            assert!(piece.bounding_sphere().1 < 16.0, "{:?}", piece.bounding_sphere());
        }
    }
}
