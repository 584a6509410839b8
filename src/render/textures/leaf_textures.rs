//! Masks of leaf cards: sprays, boughs and bark, painted once from a fixed seed. In: nothing. Out: an array texture
//! with all its mip levels, so that a fragment of a tree costs one sample; on software rendering, computing the leaves
//! anew for every pixel took a third of the frame.
//!
//! Channels: r distance inside a leaf (0.5 is its edge), g its tone around 0.5, b and a its lean around 0.5. Layers:
//! the number of the cut times `VARIANTS` plus the number of the variant (`scene/trees/leaf_cards.rs`), then bark. Mip
//! levels keep the covered share of the card (after Castano 2010), or crowns would grow thin with distance.

use super::{
    noise_texture::smooth,
    upload::{PaintedTexture, byte, side_by_side},
};
use crate::rng::{self, Stream};
use glam::{Vec2, vec2};
use std::{f32::consts::TAU, sync::OnceLock};

/// Side of a layer, texels; a power of two.
const SIZE: usize = 128;
/// Number of different cards of one cut, as in `scene/trees/leaf_cards.rs`.
const VARIANTS: usize = 8;
/// Number of cuts, as in `scene/trees/leaf_cards.rs`.
const CUTS: usize = 4;
/// Number of the bark's layer.
const BARK: usize = CUTS * VARIANTS;
/// Width of the ramp at a leaf's edge in the full size, texels.
const RAMP: f32 = 4.0;
/// Number of mip levels. The level of 1 texel is left out: it would be the card's mean.
const LEVELS: u32 = SIZE.ilog2();

/// Texel of a card: cover 0 to 1 with 0.5 at the edge, tone, lean.
pub type LeafTexel = [f32; 4];
/// Texel of a gap, with neutral tone and lean.
const EMPTY: LeafTexel = [0.0, 0.5, 0.5, 0.5];

/// One leaf or needle.
#[derive(Clone, Copy, Debug)]
struct LeafOutline {
    /// Foot of the leaf, 0 to 1 on the card.
    foot: Vec2,
    /// Vector from the foot to the tip.
    along: Vec2,
    /// Half its greatest width.
    half: f32,
    /// Position of the greatest width, 0 at the foot to 1 at the tip.
    widest: f32,
    tone: f32,
    lean: Vec2,
    /// Opposite lean of the two halves.
    fold: f32,
}

/// All layers, each at all mip levels.
pub type LeafLayers = Vec<Vec<Vec<LeafTexel>>>;

/// Returns the layers, painted at the first call.
pub fn layers() -> &'static LeafLayers {
    static LAYERS: OnceLock<LeafLayers> = OnceLock::new();
    LAYERS.get_or_init(all)
}

/// Returns the texel at a place, 0 to 1, of the card with the variant `x` and the cut `y`.
#[inline]
pub fn at(layers: &LeafLayers, card: Vec2, place: Vec2) -> LeafTexel {
    let layer = card.y as usize * VARIANTS + card.x as usize;
    let texel = |v: f32| ((v * SIZE as f32) as usize).min(SIZE - 1);
    let (x, y) = (texel(place.x), texel(place.y));
    layers[layer][0][y * SIZE + x]
}

/// Uploads the leaves and returns the texture view.
pub fn upload(device: &wgpu::Device, queue: &wgpu::Queue) -> wgpu::TextureView {
    let level = |level: usize| layers().iter().flat_map(|layer| &layer[level]).flatten().map(|v| byte(*v)).collect();
    let levels: Vec<Vec<u8>> = (0..LEVELS as usize).map(level).collect();
    PaintedTexture { label: "leaves", side: SIZE, array: true, levels: &levels }.upload(device, queue)
}

/// Paints all layers with their mip levels.
fn all() -> LeafLayers {
    let layer = |number: usize| {
        if number == BARK {
            return reduced_bark(bark());
        }
        let mut random = rng::stream(number as u64, "render.leaves");
        reduced(paint(&blades_of(number / VARIANTS, &mut random)))
    };
    side_by_side(BARK + 1, layer)
}

fn draw(random: &mut Stream, low: f32, high: f32) -> f32 {
    random.uniform(f64::from(low), f64::from(high)) as f32
}

/// Returns the leaves on a card of this cut, lowest first.
fn blades_of(cut: usize, random: &mut Stream) -> Vec<LeafOutline> {
    match cut {
        0 => spray(random, 7.0),
        1 => spray(random, 12.0),
        2 => spray(random, 9.0),
        _ => bough(random),
    }
}

/// Returns leaves in a ragged round, `count` of them across, pointing away from the card's foot.
fn spray(random: &mut Stream, count: f32) -> Vec<LeafOutline> {
    let mut leaves = Vec::new();
    let [a, b] = [0.0, 0.0].map(|_: f32| draw(random, 0.0, TAU));
    let cells = count as i32;
    // Two layers: the lower one is in the shade of the upper one.
    for layer in 0..2 {
        for k in 0..cells * cells {
            let cell = vec2((k % cells) as f32, (k / cells) as f32);
            let at = (cell + vec2(draw(random, 0.1, 0.9), draw(random, 0.1, 0.9))) / count;
            let c = at * 2.0 - 1.0;
            let luck = draw(random, 0.0, 1.0);
            let angle = c.y.atan2(c.x);
            let reach = 0.74 + 0.10 * (3.0 * angle + a).sin() + 0.07 * (5.0 * angle + b).sin();
            let length = draw(random, 0.95, 1.35) / count;
            let turn = draw(random, -0.9, 0.9);
            let (tone, lean) = (draw(random, -1.0, 1.0), vec2(draw(random, -1.0, 1.0), draw(random, -1.0, 1.0)));
            // Loose: at least a tenth is missing, more towards the rim.
            if c.length() > reach - 0.4 * length || luck < 0.10 + 0.22 * c.length_squared() {
                continue;
            }
            // Leaves point away from the foot of the spray and to the sides.
            let way = Vec2::from_angle((c - vec2(0.0, -0.9)).to_angle() + turn);
            leaves.push(LeafOutline {
                foot: at - way * length * 0.5,
                along: way * length,
                half: length * 0.29,
                widest: 0.42,
                tone: 0.5 + 0.20 * tone - if layer == 0 { 0.16 } else { -0.04 },
                lean: lean * 0.6,
                fold: 0.35,
            });
        }
    }
    leaves
}

/// Returns a stem along v with twigs forwards to either side, all set with needles.
fn bough(random: &mut Stream) -> Vec<LeafOutline> {
    const TWIGS: usize = 13;
    let mut needles = Vec::new();
    let mut twig = |random: &mut Stream, foot: Vec2, along: Vec2, tone: f32| {
        let length = along.length();
        let count = (length * 46.0).ceil() as usize;
        needles.push(LeafOutline { foot, along, half: 0.007, widest: 0.1, tone: 0.32, lean: Vec2::ZERO, fold: 0.0 });
        for k in 0..count {
            let t = (k as f32 + draw(random, 0.0, 1.0)) / count as f32;
            for side in [-1.0, 1.0] {
                let way = Vec2::from_angle(along.to_angle() + side * draw(random, 0.5, 0.95));
                let tone = 0.5 + 0.13 * tone + draw(random, -0.14, 0.14) + 0.10 * t;
                needles.push(LeafOutline {
                    foot: foot + along * t,
                    along: way * draw(random, 0.060, 0.085) * (1.15 - 0.45 * t),
                    half: 0.0085,
                    widest: 0.35,
                    tone,
                    lean: way * 0.5,
                    fold: 0.0,
                });
            }
        }
    };
    for k in 0..TWIGS {
        let t = 0.03 + 0.92 * (k as f32 + draw(random, -0.25, 0.25)) / TWIGS as f32;
        for side in [-1.0, 1.0] {
            // Shorter towards the tip.
            let reach = 0.47 * (1.0 - 0.80 * t * t) * draw(random, 0.70, 1.0);
            let way = Vec2::from_angle(TAU / 4.0 - side * draw(random, 0.80, 1.05));
            let room = (0.97 - t).max(0.05) / way.y.max(0.1);
            let tone = draw(random, -1.0, 1.0);
            twig(random, vec2(0.5, t), way * (reach / way.x.abs()).min(room), tone);
        }
    }
    twig(random, vec2(0.5, 0.0), vec2(0.0, 0.93), 0.3);
    needles
}

/// Paints blades over one another.
fn paint(blades: &[LeafOutline]) -> Vec<LeafTexel> {
    let mut texels = vec![EMPTY; SIZE * SIZE];
    let size = SIZE as f32;
    for blade in blades {
        let length = blade.along.length();
        let way = blade.along / length;
        let margin = blade.half + RAMP / size;
        let tip = blade.foot + blade.along;
        let low = ((blade.foot.min(tip) - margin) * size).max(Vec2::ZERO);
        let high = ((blade.foot.max(tip) + margin) * size).min(Vec2::splat(size - 1.0));
        for y in low.y as usize..=high.y.max(0.0) as usize {
            for x in low.x as usize..=high.x.max(0.0) as usize {
                let off = (vec2(x as f32, y as f32) + 0.5) / size - blade.foot;
                let t = off.dot(way) / length;
                let across = off.perp_dot(way);
                // Round towards the foot, pointed towards the tip.
                let bulge = if t < blade.widest {
                    let d = (blade.widest - t) / blade.widest;
                    1.0 - d * d
                } else {
                    let d = (t - blade.widest) / (1.0 - blade.widest);
                    1.0 - d * (0.35 + 0.65 * d)
                };
                let inside = (blade.half * bulge - across.abs()) * size;
                let cover = 0.5 + inside / RAMP;
                let texel = &mut texels[y * SIZE + x];
                if cover <= 0.0 {
                    continue;
                }
                if inside > 0.0 {
                    // The rib is pale, the foot darker than the tip.
                    let rib = (1.0 - across.abs() / (0.16 * blade.half)).max(0.0);
                    let side = across.signum() * blade.fold;
                    let lean = (blade.lean + way.perp() * side).clamp(Vec2::splat(-1.0), Vec2::ONE);
                    texel[1] = blade.tone + 0.06 * rib - 0.05 * (1.0 - t);
                    texel[2] = 0.5 + 0.5 * lean.x;
                    texel[3] = 0.5 + 0.5 * lean.y;
                }
                // An edge over another leaf leaves no gap.
                texel[0] = texel[0].max(cover.min(1.0));
            }
        }
    }
    // No texel at the card's edge: the neighbour across it belongs to another card.
    for k in 0..SIZE {
        for at in [k, (SIZE - 1) * SIZE + k, k * SIZE, k * SIZE + SIZE - 1] {
            texels[at][0] = 0.0;
        }
    }
    fill(&mut texels);
    texels
}

/// Gives the gaps the mean tone and lean of the leaves, which the filter mixes into their edges.
fn fill(texels: &mut [LeafTexel]) {
    let (mut sum, mut weight) = ([0.0; 3], 1e-6);
    for texel in texels.iter().filter(|t| t[0] > 0.5) {
        weight += 1.0;
        (0..3).for_each(|i| sum[i] += texel[i + 1]);
    }
    for texel in texels.iter_mut().filter(|t| t[0] <= 0.5) {
        (0..3).for_each(|i| texel[i + 1] = sum[i] / weight);
    }
}

/// Returns the share of texels inside leaves.
fn covered(texels: &[LeafTexel], scale: f32) -> f32 {
    texels.iter().filter(|t| t[0] * scale > 0.5).count() as f32 / texels.len() as f32
}

/// Returns a layer at all mip levels.
fn reduced(full: Vec<LeafTexel>) -> Vec<Vec<LeafTexel>> {
    let share = covered(&full, 1.0);
    // From here on r is the covered share of a texel, not the distance from an edge.
    let mut plain: Vec<LeafTexel> =
        full.iter().map(|t| [((t[0] - 0.5) * RAMP + 0.5).clamp(0.0, 1.0), t[1], t[2], t[3]]).collect();
    let mut levels = vec![full];
    let mut side = SIZE;
    while levels.len() < LEVELS as usize {
        plain = halve(&plain, side);
        side /= 2;
        let (mut low, mut high) = (0.25, 4.0);
        for _ in 0..16 {
            let middle = 0.5 * (low + high);
            if covered(&plain, middle) < share { low = middle } else { high = middle }
        }
        let scaled = plain.iter().map(|t| [(t[0] * high).min(1.0), t[1], t[2], t[3]]).collect();
        levels.push(scaled);
    }
    levels
}

/// Returns the picture at half the side: means of four texels, tone and lean weighted by cover.
fn halve(texels: &[LeafTexel], side: usize) -> Vec<LeafTexel> {
    let half = side / 2;
    let mut out = Vec::with_capacity(half * half);
    for y in 0..half {
        for x in 0..half {
            let at = |dx: usize, dy: usize| texels[(2 * y + dy) * side + 2 * x + dx];
            let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
            let cover: f32 = four.iter().map(|t| t[0]).sum();
            let mean = |i: usize| four.iter().map(|t| t[i] * (t[0] + 1e-3)).sum::<f32>() / (cover + 4e-3);
            out.push([cover / 4.0, mean(1), mean(2), mean(3)]);
        }
    }
    out
}

/// Paints furrows along v, tiling; lean is the slope of their relief.
fn bark() -> Vec<LeafTexel> {
    let mut random = rng::stream(0, "render.bark");
    let lattice = |random: &mut Stream, nx: usize, ny: usize| -> (usize, usize, Vec<f32>) {
        (nx, ny, (0..nx * ny).map(|_| random.uniform(0.0, 1.0) as f32).collect())
    };
    let layers = [(7, 3), (13, 5), (29, 17), (61, 53)].map(|(nx, ny)| lattice(&mut random, nx, ny));
    let at = |x: usize, y: usize| {
        let (u, v) = ((x % SIZE) as f32 / SIZE as f32, (y % SIZE) as f32 / SIZE as f32);
        let noise = |i: usize| {
            let (nx, ny, values): &(usize, usize, Vec<f32>) = &layers[i];
            smooth(values, *nx, *ny, u, v)
        };
        let (broad, plates, fine, grit) = (noise(0), noise(1), noise(2), noise(3));
        let furrow = (1.0 - (plates - 0.5).abs() * 5.0).max(0.0).max((0.8 - (broad - 0.5).abs() * 6.0).max(0.0));
        0.62 - 0.34 * furrow + 0.22 * (fine - 0.5) + 0.14 * (grit - 0.5)
    };
    let heights: Vec<f32> = (0..SIZE * SIZE).map(|i| at(i % SIZE, i / SIZE)).collect();
    let height = |x: usize, y: usize| heights[(y % SIZE) * SIZE + x % SIZE];
    let texel = |i: usize| {
        let (x, y) = (i % SIZE, i / SIZE);
        let slope = |a: f32, b: f32| (0.5 + 2.2 * (a - b)).clamp(0.0, 1.0);
        [
            1.0,
            0.15 + 0.6 * height(x, y),
            slope(height(x + SIZE - 1, y), height(x + 1, y)),
            slope(height(x, y + SIZE - 1), height(x, y + 1)),
        ]
    };
    (0..SIZE * SIZE).map(texel).collect()
}

fn reduced_bark(full: Vec<LeafTexel>) -> Vec<Vec<LeafTexel>> {
    let mut levels = vec![full];
    while levels.len() < LEVELS as usize {
        let last = &levels[levels.len() - 1];
        levels.push(halve(last, SIZE >> (levels.len() - 1)));
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_card_is_square_and_all_mip_levels_cover_the_same_share() {
        for (number, levels) in all().iter().take(BARK).enumerate() {
            let share = covered(&levels[0], 1.0);
            assert!((0.18..0.72).contains(&share), "layer {number} covers {share}");
            for (level, texels) in levels.iter().enumerate() {
                let side = SIZE >> level;
                if side < 8 {
                    continue;
                }
                assert!((covered(texels, 1.0) - share).abs() < 0.03, "layer {number} at {side} texels");
                // Corners are free: the outline is round or pointed.
                let corner = side / 8;
                let upper = |x: usize, y: usize| texels[(side - 1 - y) * side + x][0];
                let most = (0..corner).flat_map(|x| (0..corner).map(move |y| [x, y]));
                let most = most.map(|[x, y]| upper(x, y).max(upper(side - 1 - x, y))).fold(0.0, f32::max);
                assert!(most < 0.5, "layer {number} at {side} texels: {most} in a corner");
            }
        }
    }

    #[test]
    fn the_shaders_take_bark_from_its_layer() {
        for (shader, number) in [
            (include_str!("../../../shaders/leaf.wgsl"), format!("const BARK_LAYER = {BARK};")),
            (include_str!("../../../shaders/leaf_shadow.wgsl"), format!("const BARK_LAYER = {BARK};")),
        ] {
            assert!(shader.contains(&number), "{number}");
        }
    }

    #[test]
    fn leaves_are_the_same_every_time() {
        assert_eq!(all(), all());
    }
}
