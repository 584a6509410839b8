//! Far trees: pictures of a tree from sixteen sides and from above, painted once from its finest model. In: meshes and
//! their leaves ([`leaf_textures`]). Out: an array texture; a tree about 50 pixels high is two triangles with a picture
//! instead of a thousand triangles, in the same light.
//!
//! Layers come in pairs. The first has the square root of the albedo, with the cover in a. The second has the normal in
//! the tree's own frame, with the share of leaves in a; the rest is bark. Pair `kind * VIEWS + view`; a view's eye is
//! at the azimuth `view / SIDES` of a turn, the last one's above. The picture holds the tree's bounding sphere: its
//! middle is the middle of the model's height, its half side [`ImpostorExtent::half_m`].

use super::{
    leaf_textures::{self, LeafLayers},
    upload::{PaintedTexture, byte},
};
use crate::scene::{Material, Mesh, Vertex};
use glam::{Vec2, Vec3, vec2};
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Number of pictures around a tree.
pub const SIDES: usize = 16;
/// Number of pictures with the one from above.
pub const VIEWS: usize = SIDES + 1;
/// Side of a picture, texels; a power of two.
const SIZE: usize = 128;
const LEVELS: u32 = SIZE.ilog2();

/// Cover, albedo, normal, share of leaves.
type ImpostorTexel = [f32; 8];

/// Half the side of a model's pictures, and the height of their middle.
#[derive(Clone, Copy, Debug)]
pub struct ImpostorExtent {
    /// Half the side, m.
    pub half_m: f32,
    /// Height of the middle above the foot, m.
    pub middle_m: f32,
    /// Filled share of the half side: horizontally, for side views and around the middle for the view from above; and
    /// vertically. Beyond it all pictures are empty.
    pub filled: [f32; 2],
}

impl ImpostorExtent {
    /// Computes the extent of a model with its foot at the origin.
    pub fn of(mesh: &Mesh) -> Self {
        let reach = mesh.vertices.iter().map(|v| Vec2::new(v.position[0], v.position[1]).length()).fold(0.0, f32::max);
        let high = mesh.vertices.iter().map(|v| v.position[2]).fold(0.0, f32::max);
        let half_m = reach.max(high / 2.0) * 1.02;
        // One texel more for the filter.
        let low = mesh.vertices.iter().map(|v| v.position[2]).fold(0.0, f32::min);
        let filled = [reach, high / 2.0 - low].map(|m| (m / half_m + 2.0 / SIZE as f32).min(1.0));
        Self { half_m, middle_m: high / 2.0, filled }
    }
}

/// Paints the pictures of all `trees`: bytes by mip level, in the layers described above.
pub fn paint(trees: &[Mesh]) -> Vec<Vec<u8>> {
    let layers = leaf_textures::layers();
    let views: Vec<(&Mesh, usize)> = trees.iter().flat_map(|mesh| (0..VIEWS).map(move |view| (mesh, view))).collect();
    let pictures: Vec<Vec<Vec<ImpostorTexel>>> =
        views.into_par_iter().map(|(mesh, view)| reduced(picture(mesh, layers, view))).collect();
    let level = |level: usize| {
        let mut bytes = Vec::with_capacity(8 * pictures.len() * (SIZE >> level).pow(2));
        for picture in &pictures {
            let texels = &picture[level];
            bytes.extend(
                texels.iter().flat_map(|t| [byte(t[1].sqrt()), byte(t[2].sqrt()), byte(t[3].sqrt()), byte(t[0])]),
            );
            let towards = |v: f32| 0.5 + 0.5 * v;
            bytes.extend(
                texels.iter().flat_map(|t| [byte(towards(t[4])), byte(towards(t[5])), byte(towards(t[6])), byte(t[7])]),
            );
        }
        bytes
    };
    (0..LEVELS as usize).map(level).collect()
}

/// Uploads the pictures to the device.
pub fn upload(device: &wgpu::Device, queue: &wgpu::Queue, levels: &[Vec<u8>]) -> wgpu::TextureView {
    PaintedTexture { label: "far trees", side: SIZE, array: true, levels }.upload(device, queue)
}

/// Returns right, up and towards the eye of a view, in the tree's frame.
fn axes(view: usize) -> [Vec3; 3] {
    if view == SIDES {
        return [Vec3::X, Vec3::Y, Vec3::Z];
    }
    let out = Vec2::from_angle(TAU * view as f32 / SIDES as f32);
    [out.perp().extend(0.0), Vec3::Z, out.extend(0.0)]
}

/// Paints a model seen from one side: triangles by depth, cut out as in the tree shader.
fn picture(mesh: &Mesh, layers: &LeafLayers, view: usize) -> Vec<ImpostorTexel> {
    let extent = ImpostorExtent::of(mesh);
    let [right, up, towards] = axes(view);
    let scale = SIZE as f32 / (2.0 * extent.half_m);
    // Position in pixels, and depth.
    let place = |v: &Vertex| {
        let p = Vec3::from(v.position) - Vec3::Z * extent.middle_m;
        Vec3::new(p.dot(right) * scale, -p.dot(up) * scale, p.dot(towards)) + Vec2::splat(SIZE as f32 / 2.0).extend(0.0)
    };
    let places: Vec<Vec3> = mesh.vertices.iter().map(place).collect();
    let mut depth = vec![f32::MIN; SIZE * SIZE];
    let mut texels = vec![[0.0; 8]; SIZE * SIZE];
    for t in mesh.indices.chunks_exact(3) {
        let corner = |k: usize| t[k] as usize;
        let corners = [corner(0), corner(1), corner(2)].map(|k| &mesh.vertices[k]);
        let (a, b, c) = (places[corner(0)], places[corner(1)], places[corner(2)]);
        let area = (b - a).truncate().perp_dot((c - a).truncate());
        if area.abs() < 1e-6 {
            continue;
        }
        let low = a.min(b).min(c).max(Vec3::ZERO);
        let high = a.max(b).max(c).min(Vec3::splat(SIZE as f32 - 1.0));
        for y in low.y as usize..=high.y.max(0.0) as usize {
            for x in low.x as usize..=high.x.max(0.0) as usize {
                let p = vec2(x as f32 + 0.5, y as f32 + 0.5);
                let share =
                    |from: Vec3, to: Vec3| (to.truncate() - from.truncate()).perp_dot(p - from.truncate()) / area;
                let (u, v) = (share(c, a), share(a, b));
                let weights = [1.0 - u - v, u, v];
                if weights.iter().any(|w| *w < 0.0) {
                    continue;
                }
                let z = weights[0] * a.z + weights[1] * b.z + weights[2] * c.z;
                if z <= depth[y * SIZE + x] {
                    continue;
                }
                if let Some(texel) = shade(corners, weights, layers) {
                    depth[y * SIZE + x] = z;
                    texels[y * SIZE + x] = texel;
                }
            }
        }
    }
    texels
}

/// Returns the texel at a place of a triangle; `None` between leaves.
fn shade(corners: [&Vertex; 3], weights: [f32; 3], layers: &LeafLayers) -> Option<ImpostorTexel> {
    let mean = |of: &dyn Fn(&Vertex) -> f32| {
        of(corners[0]) * weights[0] + of(corners[1]) * weights[1] + of(corners[2]) * weights[2]
    };
    let uv = vec2(mean(&|v| v.uv[0]), mean(&|v| v.uv[1]));
    let normal = Vec3::new(mean(&|v| v.normal[0]), mean(&|v| v.normal[1]), mean(&|v| v.normal[2]));
    let leafy = corners[0].material == Material::Leaves as u32;
    let (mut tone, mut lean) = (1.0, Vec3::ZERO);
    if leafy {
        let whole = (Vec2::from(corners[0].uv) * 0.5).floor();
        let leaf = leaf_textures::at(layers, whole, uv - 2.0 * whole);
        if leaf[0] < 0.5 {
            return None;
        }
        tone = 2.0 * leaf[1];
        let flat = vec2(leaf[2], leaf[3]) * 2.0 - 1.0;
        lean = 0.6 * flat.extend(0.5 * (flat.x - flat.y));
    }
    let normal = (normal.normalize_or(Vec3::Z) + lean).normalize_or(Vec3::Z);
    let colour = |i: usize| mean(&|v| v.colour[i]) * tone;
    let (r, g, b) = (colour(0), colour(1), colour(2));
    Some([1.0, r, g, b, normal.x, normal.y, normal.z, f32::from(u8::from(leafy))])
}

/// Returns the means of four texels; colour and normal weighted by cover.
fn halve(texels: &[ImpostorTexel], side: usize) -> Vec<ImpostorTexel> {
    let half = side / 2;
    let mut out = Vec::with_capacity(half * half);
    for i in 0..half * half {
        let (x, y) = (i % half, i / half);
        let at = |dx: usize, dy: usize| texels[(2 * y + dy) * side + 2 * x + dx];
        let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        let cover: f32 = four.iter().map(|t| t[0]).sum();
        let mut mean = [0.0; 8];
        for t in &four {
            (1..8).for_each(|k| mean[k] += t[k] * (t[0] + 1e-4) / (cover + 4e-4));
        }
        mean[0] = cover / 4.0;
        out.push(mean);
    }
    out
}

/// Softens the outline by one texel to either side, so that the filter finds the edge between texels.
fn softened(texels: &[ImpostorTexel]) -> Vec<ImpostorTexel> {
    let at = |x: usize, y: usize| if x < SIZE && y < SIZE { texels[y * SIZE + x][0] } else { 0.0 };
    let mut out = texels.to_vec();
    for (i, texel) in out.iter_mut().enumerate() {
        let (x, y) = (i % SIZE, i / SIZE);
        // Beyond the lower edge the sum wraps to a huge number, which is outside too.
        let row = |y: usize| at(x.wrapping_sub(1), y) + 2.0 * at(x, y) + at(x + 1, y);
        texel[0] = (row(y.wrapping_sub(1)) + 2.0 * row(y) + row(y + 1)) / 16.0;
    }
    out
}

/// Returns a picture at all mip levels. Each covers the same share, and gaps have the colour of their surroundings.
fn reduced(full: Vec<ImpostorTexel>) -> Vec<Vec<ImpostorTexel>> {
    let share = full.iter().map(|t| t[0]).sum::<f32>() / full.len() as f32;
    let soft = softened(&full);
    let mut plain = vec![full];
    for level in 1..LEVELS as usize {
        plain.push(halve(&plain[level - 1], SIZE >> (level - 1)));
    }
    // From the coarsest to the finest: gaps take the values of the coarser level.
    for level in (0..LEVELS as usize - 1).rev() {
        let side = SIZE >> level;
        for i in 0..side * side {
            if plain[level][i][0] < 0.02 {
                let from = plain[level + 1][(i / side / 2) * (side / 2) + i % side / 2];
                plain[level][i][1..].copy_from_slice(&from[1..]);
            }
        }
    }
    plain[0].iter_mut().zip(soft).for_each(|(texel, soft)| texel[0] = soft[0]);
    for texels in &mut plain {
        // As many texels cover more than half as the model covers.
        let covered = (share * texels.len() as f32).round() as usize;
        let mut covers: Vec<f32> = texels.iter().map(|t| t[0]).collect();
        let (_, least, _) = covers.select_nth_unstable_by(covered.min(texels.len() - 1), |a, b| b.total_cmp(a));
        let scale = (0.5 / least.max(1e-6)).clamp(0.5, 4.0);
        texels.iter_mut().for_each(|t| t[0] = (t[0] * scale).min(1.0));
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shader_has_the_size_of_a_picture() {
        assert!(include_str!("../../../shaders/far_cover.wgsl").contains(&format!("SIDE = {SIZE}.0;")));
    }

    #[test]
    fn a_picture_is_the_models_outline() {
        // A triangle that faces +x, 4 m wide and 6 m high: visible from +x, an edge from +y.
        let corner = |y: f32, z: f32| Vertex {
            position: [0.0, y, z],
            normal: [1.0, 0.0, 0.0],
            colour: [0.25; 3],
            material: Material::Bark as u32,
            ..Default::default()
        };
        let mesh =
            Mesh { vertices: vec![corner(-2.0, 0.0), corner(2.0, 0.0), corner(0.0, 6.0)], indices: vec![0, 1, 2] };
        let seen = |view: usize| picture(&mesh, leaf_textures::layers(), view);
        let share = |texels: &[ImpostorTexel]| texels.iter().map(|t| t[0]).sum::<f32>() / texels.len() as f32;
        let side = 2.0 * ImpostorExtent::of(&mesh).half_m;
        assert!((share(&seen(0)) - 12.0 / (side * side)).abs() < 0.02, "{}", share(&seen(0)));
        assert!(share(&seen(SIDES / 4)) < 0.03);
        let middle = seen(0)[SIZE / 2 * SIZE + SIZE / 2];
        assert!(middle[0] > 0.9 && (middle[1] - 0.25).abs() < 0.01 && middle[4] > 0.9, "{middle:?}");
        // The tip is at the top: it is narrow.
        let row = |y: usize| seen(0)[y * SIZE..(y + 1) * SIZE].iter().map(|t| t[0]).sum::<f32>();
        assert!(row(SIZE - 6) > 3.0 * row(6), "{} {}", row(SIZE - 6), row(6));
    }

    #[test]
    fn pictures_are_empty_beyond_the_extent_of_a_tree() {
        let map = crate::map::RoadMap::load("ring-250").expect("a map that is shipped");
        let trees = crate::scene::StaticScene::with_trees(&map, 1, 0).trees;
        let layers = leaf_textures::layers();
        let mut shares = Vec::new();
        for (kind, tree) in trees.iter().enumerate() {
            let [across, high] = ImpostorExtent::of(tree).filled;
            for view in [0, 3, SIDES] {
                let up = if view == SIDES { across } else { high };
                let texels = softened(&picture(tree, layers, view));
                let off = |i: usize| (2 * i + 1) as f32 / SIZE as f32 - 1.0;
                let lost = (0..SIZE * SIZE).filter(|&i| {
                    let [x, y] = [off(i % SIZE), off(i / SIZE)];
                    let around = view == SIDES && x.hypot(y) > across;
                    texels[i][0] > 0.0 && (x.abs() > across || y.abs() > up || around)
                });
                assert_eq!(lost.count(), 0, "kind {kind}, view {view}");
            }
            shares.push([across * high, across * across]);
        }
        // Mean empty share of the squares: a fifth from the side, a third from above.
        let [side, above] = [0, 1].map(|i| shares.iter().map(|s| s[i]).sum::<f32>() / shares.len() as f32);
        assert!(side < 0.8 && above < 0.7, "{side} {above}: {shares:?}");
    }
}
