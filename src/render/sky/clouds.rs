//! The picture of the sky with fair-weather clouds, painted on the CPU when the time of day changes. In: the light
//! ([`Sky`]). Out: a picture of the upper half of the sky, and the opacity of its clouds. Lengths are kilometres.
//!
//! Cumulus is ray-marched as a volume: flat bases at one height, tops that a three-dimensional noise breaks into heaps.
//! The sun lights it through its own depth (Beer's law, with a second, thinner exponential for light that is scattered
//! many times). Cirrus is a thin sheet far above. The clouds stand still: nothing on the screen moves that a driver
//! could take for motion of the vehicle.

use super::atmosphere::{self, Sky};
use crate::{render::textures::upload::side_by_side, rng};
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Radius of the horizon in the picture as a share of half its side.
pub const RIM: f32 = 0.98;

/// Height of the cumulus' bases, and of the highest tops above them.
const BASE_KM: f32 = 1.25;
const DEPTH_KM: f32 = 0.85;
/// Extinction of dense cloud, 1/km.
const DENSITY_PER_KM: f32 = 16.0;
/// Height of the cirrus.
const CIRRUS_KM: f32 = 7.0;
/// Period of the map of heaps, and of the noise that breaks them.
const MAP_KM: f32 = 17.0;
const NOISE_KM: f32 = 1.5;
/// Sides of the two tables, powers of two.
const MAP: usize = 256;
const NOISE: usize = 64;
/// Distances towards the sun at which a cloud's own shade is sampled.
const TOWARDS_SUN_KM: [f32; 4] = [0.05, 0.14, 0.30, 0.62];

/// Tables from which clouds are computed.
struct CloudTables {
    /// Map of heaps, 0 to 1, periodic.
    map: Vec<f32>,
    /// Billow noise, 0 to 1, periodic in three dimensions.
    noise: Vec<f32>,
}

/// Paints the picture, `side` by `side`, stereographic, with the zenith in the middle, east to the right, north
/// downwards. Each texel is the radiance, and the opacity of the clouds in w. Beyond the rim, the horizon continues.
pub fn paint(sky: &Sky, side: usize) -> Vec<Vec4> {
    let weather = CloudTables::shared();
    let clear = sky.picture();
    let half = side as f32 / 2.0;
    let texel = |i: usize| {
        let at = (Vec2::new((i % side) as f32, (i / side) as f32) + 0.5 - half) / (half * RIM);
        let at = at.clamp_length_max(1.0);
        let r2 = at.length_squared();
        let direction = (at * 2.0).extend(1.0 - r2) / (1.0 + r2);
        let open = smooth_between(&clear, (0.5 + 0.5 * atmosphere::RIM * at) * atmosphere::SIZE as f32 - 0.5);
        if sky.is_overcast {
            return (open * weather.under_rain(direction)).extend(1.0);
        }
        let cloud = weather.seen(direction, open, sky);
        (open * (1.0 - cloud.w) + cloud.truncate()).extend(cloud.w)
    };
    (0..side * side).into_par_iter().map(texel).collect()
}

/// Computes the shared tables of the clouds ahead of their use, in parallel with other work.
pub fn prepare() {
    CloudTables::shared();
}

impl CloudTables {
    /// Returns the shared tables, computed at the first call.
    fn shared() -> &'static Self {
        static WEATHER: OnceLock<CloudTables> = OnceLock::new();
        WEATHER.get_or_init(Self::new)
    }

    fn new() -> Self {
        let mut random = rng::stream(0, "render.clouds");
        let mut white = |n: usize| -> Vec<f32> { (0..n).map(|_| random.uniform(0.0, 1.0) as f32).collect() };
        let octaves = [9usize, 17, 35, 71].map(|n| (n, white(n * n)));
        let map = side_by_side(MAP * MAP, |i| {
            let p = Vec2::new((i % MAP) as f32, (i / MAP) as f32) / MAP as f32;
            let (mut sum, mut weight, mut total) = (0.0, 1.0, 0.0);
            for (n, lattice) in &octaves {
                sum += weight * plane(lattice, *n, p * *n as f32);
                total += weight;
                weight *= 0.52;
            }
            0.5 + 1.9 * (sum / total - 0.5)
        });
        let octaves = [6usize, 12, 24].map(|n| (n, white(n * n * n)));
        let noise = side_by_side(NOISE * NOISE * NOISE, |i| {
            let p = Vec3::new((i % NOISE) as f32, (i / NOISE % NOISE) as f32, (i / NOISE / NOISE) as f32);
            let (mut sum, mut weight, mut total) = (0.0, 1.0, 0.0);
            for (n, lattice) in &octaves {
                // Folded, so that heaps are round above and creased between.
                let v = solid(lattice, *n, p * (*n as f32 / NOISE as f32));
                sum += weight * (1.0 - (2.0 * v - 1.0).abs() * 1.6);
                total += weight;
                weight *= 0.5;
            }
            (sum / total).clamp(0.0, 1.0)
        });
        Self { map, noise }
    }

    /// Returns the light of rain clouds in a direction beside their mean: their undersides are uneven.
    fn under_rain(&self, direction: Vec3) -> f32 {
        const UNDERSIDE_KM: f32 = 0.7;
        let p = direction.truncate() * (UNDERSIDE_KM / (direction.z + 0.07));
        let at = |period_km: f32| fast_plane::<MAP>(&self.map, p * (MAP as f32 / period_km)) - 0.5;
        // Those near the horizon lie behind rain.
        let near = (direction.z / 0.25).min(1.0);
        (1.0 + near * (0.30 * at(29.0) + 0.16 * at(11.0))).clamp(0.6, 1.4)
    }

    /// Returns the height of the map above the threshold of a heap at a place; negative between heaps.
    fn heap(&self, p: Vec3) -> f32 {
        fast_plane::<MAP>(&self.map, p.truncate() * (MAP as f32 / MAP_KM)) - 0.61
    }

    /// Returns the density of cumulus at a place, 0 to 1.
    fn density(&self, p: Vec3) -> f32 {
        let h = (p.z - BASE_KM) / DEPTH_KM;
        let heap = self.heap(p);
        // Tops are as high as heaps are wide; bases are flat.
        let body = heap * 4.2 - h * 1.15;
        if heap <= 0.0 || body <= 0.0 || h <= 0.0 {
            return 0.0;
        }
        let coarse = fast_solid::<NOISE>(&self.noise, p * (NOISE as f32 / NOISE_KM));
        let fine = fast_solid::<NOISE>(&self.noise, Vec3::new(p.y, p.z, p.x) * (3.1 * NOISE as f32 / NOISE_KM));
        let left =
            body - 0.95 * (1.0 - coarse) * (0.25 + h.min(1.0)) - 0.40 * (1.0 - fine) * (0.35 + 0.65 * h.min(1.0));
        (left * 2.6).clamp(0.0, 1.0) * (h * 9.0).min(1.0)
    }

    /// Returns the light of the clouds in a direction, weighted with the opacity in w; `open` is the clear sky's light
    /// there.
    fn seen(&self, direction: Vec3, open: Vec3, sky: &Sky) -> Vec4 {
        let up = direction.z;
        // Clouds near the horizon fade into its haze.
        let clear = ((up - 0.018) / 0.09).clamp(0.0, 1.0);
        if clear == 0.0 {
            return Vec4::ZERO;
        }
        let cosine = direction.dot(sky.to_shining);
        let forward = |g: f32| (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cosine).powf(1.5);
        // For a thick cloud: light from all sides, and some forward scattering near the sun; 1 is a white sheet.
        let phase = 0.52 + 0.10 * forward(0.55).min(3.0);
        let sky_above = sky.ambient(Vec3::Z);
        let ground = sky.ambient(-Vec3::Z);
        let steps = (15.0 / up.max(0.12)).clamp(22.0, 72.0) as usize;
        let step_km = DEPTH_KM / up / steps as f32;
        let (mut light, mut left) = (Vec3::ZERO, 1.0f32);
        let mut step = 0;
        while step < steps {
            let h = (step as f32 + 0.5) / steps as f32;
            let p = direction * ((BASE_KM + DEPTH_KM * h) / up);
            // The further from a heap on the map, the longer the step.
            let heap = self.heap(p);
            step += 1 + (-heap * 6.0).max(0.0) as usize;
            let density = if heap > 0.0 { self.density(p) } else { 0.0 };
            if density <= 0.0 {
                continue;
            }
            let mut before = 0.0;
            let mut last = 0.0;
            for way in TOWARDS_SUN_KM {
                before += self.density(p + sky.to_shining * way) * (way - last);
                last = way;
            }
            let depth = before * DENSITY_PER_KM;
            let arrives = 0.62 * (-depth).exp() + 0.38 * (-0.22 * depth).exp();
            let around = sky_above * (0.42 + 0.50 * h) + ground * 0.30 * (1.0 - h);
            let own = sky.sun * (phase * arrives) + around * 0.72;
            let through = (-density * DENSITY_PER_KM * step_km.min(0.25)).exp();
            light += left * (1.0 - through) * own;
            left *= through;
            if left < 0.02 {
                left = 0.0;
                break;
            }
        }
        let opacity = 1.0 - left;
        let cirrus = self.cirrus(direction);
        let behind = (sky.sun * (0.42 + 0.05 * forward(0.7).min(6.0)) + sky_above * 0.6) * cirrus;
        let whole = (light + left * behind).extend(opacity + left * cirrus);
        // The air in front of the clouds; most of the haze lies below them.
        let far_m = 1000.0 * BASE_KM / up;
        let clean = (-sky.extinction_per_m * (far_m * 0.35)).exp();
        let colour = whole.truncate() * clean + open * (Vec3::ONE - clean) * whole.w;
        colour.extend(whole.w) * (clear * clear * (3.0 - 2.0 * clear))
    }

    /// Returns the opacity of the cirrus: threads drawn out by the wind, in fields.
    fn cirrus(&self, direction: Vec3) -> f32 {
        let p = direction.truncate() * (CIRRUS_KM / (direction.z + 0.06));
        let along = Vec2::new(0.83 * p.x + 0.56 * p.y, 0.83 * p.y - 0.56 * p.x);
        let at = |q: Vec2| fast_plane::<MAP>(&self.map, q * MAP as f32);
        let bend = at(along / 90.0);
        let threads = at(Vec2::new(along.x / 70.0, along.y / 17.0 + 0.22 * bend));
        let fine = at(Vec2::new(along.x / 24.0 + 0.3, along.y / 5.0 + 0.8 * bend));
        let field = ((at(along / 130.0 + Vec2::splat(0.37)) - 0.42) * 3.0).clamp(0.0, 1.0);
        ((threads * 0.7 + fine * 0.5 - 0.52) * 1.2).clamp(0.0, 1.0) * field * 0.34
    }
}

/// Interpolates the sky's picture at a place in texels by cubic B-splines: on texels this coarse, linear interpolation
/// shows its kinks.
fn smooth_between(picture: &[Vec3], p: Vec2) -> Vec3 {
    let cell = p.floor();
    let weights = |t: f32| {
        let (u, t2) = (1.0 - t, t * t);
        let (second, third) = (4.0 - 6.0 * t2 + 3.0 * t2 * t, 4.0 - 6.0 * u * u + 3.0 * u * u * u);
        [u * u * u / 6.0, second / 6.0, third / 6.0, t2 * t / 6.0]
    };
    let (across, down) = (weights(p.x - cell.x), weights(p.y - cell.y));
    let at = |i: f32| (i.max(0.0) as usize).min(atmosphere::SIZE - 1);
    let row = |y: f32| -> Vec3 {
        let texel = |k: usize| picture[at(y) * atmosphere::SIZE + at(cell.x + k as f32 - 1.0)];
        (0..4).map(|k| texel(k) * across[k]).sum()
    };
    (0..4).map(|k| row(cell.y + k as f32 - 1.0) * down[k]).sum()
}

/// Interpolates a periodic lattice of `n` by `n` smoothly, at a place in cells.
#[inline]
fn plane(lattice: &[f32], n: usize, p: Vec2) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let f = f * f * (Vec2::splat(3.0) - 2.0 * f);
    let wrap = |v: f32| (v as i32).rem_euclid(n as i32) as usize;
    let (x, y) = (wrap(cell.x), wrap(cell.y));
    let (x1, y1) = ((x + 1) % n, (y + 1) % n);
    let row = |y: usize| lattice[y * n + x] + (lattice[y * n + x1] - lattice[y * n + x]) * f.x;
    let (low, high) = (row(y), row(y1));
    low + (high - low) * f.y
}

/// Interpolates a periodic table linearly, with a side of a power of two: fast, because it is called millions of times.
#[inline]
fn fast_plane<const N: usize>(table: &[f32], p: Vec2) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let (x, y) = (cell.x as i32 as usize & (N - 1), cell.y as i32 as usize & (N - 1));
    let (x1, y1) = ((x + 1) & (N - 1), (y + 1) & (N - 1));
    let low = table[y * N + x] + (table[y * N + x1] - table[y * N + x]) * f.x;
    let high = table[y1 * N + x] + (table[y1 * N + x1] - table[y1 * N + x]) * f.x;
    low + (high - low) * f.y
}

#[inline]
fn fast_solid<const N: usize>(table: &[f32], p: Vec3) -> f32 {
    let cell = p.z.floor();
    let z = cell as i32 as usize & (N - 1);
    let layer = |z: usize| fast_plane::<N>(&table[z * N * N..(z + 1) * N * N], p.truncate());
    let (low, high) = (layer(z), layer((z + 1) & (N - 1)));
    low + (high - low) * (p.z - cell)
}

/// Interpolates a periodic lattice of `n` by `n` by `n` smoothly, at a place in cells.
fn solid(lattice: &[f32], n: usize, p: Vec3) -> f32 {
    let cell = p.z.floor();
    let f = p.z - cell;
    let f = f * f * (3.0 - 2.0 * f);
    let z = (cell as i32).rem_euclid(n as i32) as usize;
    let layer = |z: usize| plane(&lattice[z * n * n..(z + 1) * n * n], n, p.truncate());
    let (low, high) = (layer(z), layer((z + 1) % n));
    low + (high - low) * f
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clouds_leave_most_of_the_sky_free_and_are_lit_but_not_burnt() {
        for (height, visibility_m) in [(0.65f32, 30_000.0), (0.2, 30_000.0), (0.65, 3000.0)] {
            let sky = Sky::new(Vec3::new((1.0 - height * height).sqrt(), 0.0, height), visibility_m, false);
            let side = 128;
            let picture = paint(&sky, side);
            assert!(picture == paint(&sky, side), "the same clouds every time");
            let hidden: f32 = picture.iter().map(|t| t.w).sum();
            let cover = hidden / (picture.len() as f32 * std::f32::consts::PI / 4.0 * RIM * RIM);
            assert!((0.08..0.45).contains(&cover), "{cover}");
            for texel in &picture {
                assert!(texel.is_finite() && (0.0..=1.001).contains(&texel.w), "{texel}");
            }
            // Away from the sun's glare, clouds are at most half as bright again as a white sheet that faces the sun.
            let west = picture.iter().enumerate().filter(|(i, t)| i % side < side / 2 && t.w > 0.9);
            let brightest = west.fold(Vec3::ZERO, |most, (_, t)| most.max(t.truncate()));
            let sheet = sky.sun + sky.ambient(Vec3::Z);
            assert!((brightest / sheet).max_element() < 1.5, "{brightest} {sheet}");
            // Clouds end in the haze above the horizon, and the clear sky is the atmosphere's own.
            assert!(picture[side / 2].w < 0.02 && picture[side / 2 * side].w < 0.02);
            let middle = (side / 2) * side + side / 2;
            let open = |k: usize| (picture[k].truncate() / sky.radiance(Vec3::Z) - 1.0).abs().max_element();
            assert!(picture[middle].w > 0.01 || open(middle) < 0.05, "{}", open(middle));
        }
    }
}
