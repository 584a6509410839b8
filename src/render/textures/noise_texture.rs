//! The grain of asphalt, grass and bark, and soft clouds: one small tiling picture, made once from a fixed seed. In:
//! nothing. Out: a texture with all its mip levels, so that the hardware's filter fades the grain with distance instead
//! of letting it flicker. The means are near 0.5, for the cracks near 1.
//!
//! Channels: r fine grit (independent texels), g soft clouds (five octaves), b thin cracks (dark lines on 1), a blades
//! of grass from above, in tufts (drawn out, also bark).

use super::upload::{PaintedTexture, byte};
use crate::rng;
use glam::Vec2;
use rayon::prelude::*;
use std::sync::OnceLock;

/// Side of the picture, texels; a power of two.
const SIZE: usize = 512;

/// Returns the grain at all mip levels, as bytes; the first picture of a process paints them.
pub fn levels() -> &'static [Vec<u8>] {
    static LEVELS: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    // Not within `get_or_init`: a thread that waits there for others' parts could begin another picture, and wait for itself.
    LEVELS.get().unwrap_or_else(|| {
        let painted = painted_levels();
        LEVELS.get_or_init(|| painted)
    })
}

fn painted_levels() -> Vec<Vec<u8>> {
    let mut texels = paint();
    let mut side = SIZE;
    let mut levels = Vec::new();
    loop {
        levels.push(texels.iter().flatten().map(|v| byte(*v)).collect());
        if side == 1 {
            return levels;
        }
        texels = halve(&texels, side);
        side /= 2;
    }
}

/// Uploads the grain to the device.
pub fn upload(device: &wgpu::Device, queue: &wgpu::Queue, levels: &[Vec<u8>]) -> wgpu::TextureView {
    PaintedTexture { label: "grain", side: SIZE, array: false, levels }.upload(device, queue)
}

/// Paints the picture in full size.
fn paint() -> Vec<[f32; 4]> {
    let mut random = rng::stream(0, "render.grain");
    let mut white = |n: usize| -> Vec<f32> { (0..n).map(|_| random.uniform(0.0, 1.0) as f32).collect() };
    let grit = white(SIZE * SIZE);
    let octaves: Vec<(usize, Vec<f32>)> = [7, 13, 27, 53, 107].map(|cells| (cells, white(cells * cells))).into();
    let ridges: Vec<(usize, Vec<f32>)> = [6, 13, 29].map(|cells| (cells, white(cells * cells))).into();
    let line = |y: usize| -> Vec<[f32; 3]> {
        let texel = |x: usize| {
            let (u, v) = (x as f32 / SIZE as f32, y as f32 / SIZE as f32);
            let fbm = |layers: &[(usize, Vec<f32>)], gain: f32| {
                let mut weight = 1.0;
                let (mut sum, mut total) = (0.0, 0.0);
                for (cells, lattice) in layers {
                    sum += weight * smooth(lattice, *cells, *cells, u, v);
                    total += weight;
                    weight *= gain;
                }
                sum / total
            };
            let clouds = 0.5 + (fbm(&octaves, 0.55) - 0.5) * 1.7;
            let ridge = (fbm(&ridges, 0.5) - 0.5).abs();
            [grit[y * SIZE + x], clouds, (ridge / 0.012).min(1.0)]
        };
        (0..SIZE).map(texel).collect()
    };
    let (blades, lines): (Vec<f32>, Vec<[f32; 3]>) =
        rayon::join(blades, || (0..SIZE).into_par_iter().flat_map_iter(line).collect());
    let mut texels: Vec<[f32; 4]> = lines.iter().zip(blades).map(|([r, g, b], a)| [*r, *g, *b, a]).collect();
    // The few large cells of the clouds do not average out: the mean is set to 0.5.
    let mean = texels.iter().map(|t| t[1]).sum::<f32>() / texels.len() as f32;
    texels.iter_mut().for_each(|t| t[1] += 0.5 - mean);
    texels
}

/// Paints grass seen from above: tufts of blades that lean outwards, dark at the foot and light at the tip, each tuft
/// over the ones before. Tiles; mean 0.5.
fn blades() -> Vec<f32> {
    const TUFTS: usize = 1500;
    const BLADES: usize = 15;
    let mut random = rng::stream(0, "render.grain.blades");
    let mut draw = |low: f32, high: f32| random.uniform(f64::from(low), f64::from(high)) as f32;
    let mut picture = vec![0.15f32; SIZE * SIZE];
    for _ in 0..TUFTS {
        let middle = Vec2::new(draw(0.0, SIZE as f32), draw(0.0, SIZE as f32));
        let (size, light) = (draw(0.6, 1.25), draw(0.75, 1.15));
        for blade in 0..BLADES {
            let way = Vec2::from_angle(std::f32::consts::TAU * (blade as f32 / BLADES as f32) + draw(-0.5, 0.5));
            let (length, bend, own) = (draw(9.0, 26.0) * size, draw(-7.0, 7.0), light * draw(0.55, 1.0));
            let foot = middle + way * draw(0.0, 5.0);
            let steps = (length * 1.6) as usize;
            for step in 0..steps {
                let t = step as f32 / steps as f32;
                let at = foot + way * (length * t) + way.perp() * (bend * t * t);
                let shade = own * (0.35 + 0.65 * t);
                let thick = 0.85 * (1.0 - 0.6 * t);
                let cell = at.floor();
                let f = at - cell;
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let share = (if dx == 0 { 1.0 - f.x } else { f.x }) * (if dy == 0 { 1.0 - f.y } else { f.y });
                    let wrap = |v: f32, d: i32| (v as i32 + d).rem_euclid(SIZE as i32) as usize;
                    let texel = &mut picture[wrap(cell.y, dy) * SIZE + wrap(cell.x, dx)];
                    *texel += (shade - *texel) * (share * thick).min(1.0);
                }
            }
        }
    }
    let n = picture.len() as f32;
    let mean = picture.iter().sum::<f32>() / n;
    let sd = (picture.iter().map(|v| (v - mean) * (v - mean)).sum::<f32>() / n).sqrt();
    picture.iter().map(|v| (0.5 + (v - mean) * 0.21 / sd).clamp(0.0, 1.0)).collect()
}

/// Interpolates a random lattice of `nx` by `ny` points smoothly; tiles over 0 to 1.
#[inline]
pub(in crate::render) fn smooth(lattice: &[f32], nx: usize, ny: usize, u: f32, v: f32) -> f32 {
    let (x, y) = (u * nx as f32, v * ny as f32);
    let (ix, iy) = (x as usize, y as usize);
    let ease = |t: f32| t * t * (3.0 - 2.0 * t);
    let (fx, fy) = (ease(x - ix as f32), ease(y - iy as f32));
    let at = |i: usize, j: usize| lattice[(j % ny) * nx + i % nx];
    let low = at(ix, iy) + (at(ix + 1, iy) - at(ix, iy)) * fx;
    let high = at(ix, iy + 1) + (at(ix + 1, iy + 1) - at(ix, iy + 1)) * fx;
    low + (high - low) * fy
}

/// Returns the picture at half the side: means of four texels.
fn halve(texels: &[[f32; 4]], side: usize) -> Vec<[f32; 4]> {
    let half = side / 2;
    let mut out = Vec::with_capacity(half * half);
    for y in 0..half {
        for x in 0..half {
            let at = |dx: usize, dy: usize| texels[(2 * y + dy) * side + 2 * x + dx];
            let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
            let mean = |i: usize| (a[i] + b[i] + c[i] + d[i]) / 4.0;
            out.push([mean(0), mean(1), mean(2), mean(3)]);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grain_fades_to_its_mean_and_is_always_the_same() {
        let texels = paint();
        assert_eq!(texels, paint());
        let mut level = texels;
        let mut side = SIZE;
        while side > 1 {
            level = halve(&level, side);
            side /= 2;
        }
        for (channel, mean) in level[0].iter().enumerate() {
            let wanted = if channel == 2 { 0.97 } else { 0.5 };
            assert!((mean - wanted).abs() < 0.05, "channel {channel} fades to {mean}");
        }
    }
}
