//! Functions that count pixels by colour and place.

use image::{Rgba, RgbaImage};

/// Left, top, right and bottom in pixels; right and bottom are exclusive.
pub type Region = [u32; 4];

/// Returns the places of the pixels for which `is` holds.
pub fn pixels(image: &RgbaImage, is: impl Fn([f32; 3]) -> bool) -> Vec<[u32; 2]> {
    let found = image.enumerate_pixels().filter(|(_, _, p)| is(rgb(p)));
    found.map(|(x, y, _)| [x, y]).collect()
}

pub fn rgb(pixel: &Rgba<u8>) -> [f32; 3] {
    [0, 1, 2].map(|i| f32::from(pixel.0[i]) / 255.0)
}

pub fn is_magenta([r, g, b]: [f32; 3]) -> bool {
    r > 0.2 && b > 0.2 && r > 1.8 * g && b > 1.6 * g
}

/// Checks for the red of the ego in the sun; an unlit brake lamp is darker.
pub fn is_red([r, g, b]: [f32; 3]) -> bool {
    r > 0.5 && r > 3.0 * g && r > 3.0 * b
}

/// Checks for the green of traffic in the bird's-eye view, which no meadow has.
pub fn is_car_green([r, g, b]: [f32; 3]) -> bool {
    g > 0.2 && g > 2.0 * r && g > 1.3 * b
}

pub fn inside(region: Region, [x, y]: [u32; 2]) -> bool {
    (region[0]..region[2]).contains(&x) && (region[1]..region[3]).contains(&y)
}

/// Returns the mean place, as a fraction of the picture.
pub fn centroid(image: &RgbaImage, points: &[[u32; 2]]) -> [f32; 2] {
    let n = points.len() as f32;
    let mean = |i: usize| points.iter().map(|p| p[i] as f32 + 0.5).sum::<f32>() / n;
    [mean(0) / image.width() as f32, mean(1) / image.height() as f32]
}

/// Groups points that are connected by steps of at most `reach` pixels.
pub fn blobs(points: &[[u32; 2]], reach: f32) -> Vec<Vec<[u32; 2]>> {
    let near = |a: [u32; 2], b: [u32; 2]| {
        let [dx, dy] = [0, 1].map(|i| a[i] as f32 - b[i] as f32);
        dx * dx + dy * dy <= reach * reach
    };
    let mut left: Vec<[u32; 2]> = points.to_vec();
    let mut blobs = Vec::new();
    while let Some(seed) = left.pop() {
        let mut blob = vec![seed];
        let mut next = 0;
        while next < blob.len() {
            let at = blob[next];
            let (joined, rest): (Vec<_>, Vec<_>) = left.iter().partition(|&&p| near(at, p));
            blob.extend(joined);
            left = rest;
            next += 1;
        }
        blobs.push(blob);
    }
    blobs
}

/// Returns the mean luminance of the square of `2 * half + 1` pixels around a place given as fractions of the picture.
pub fn brightness(image: &RgbaImage, [x, y]: [f32; 2], half: i32) -> f32 {
    let (cx, cy) = ((x * image.width() as f32) as i32, (y * image.height() as f32) as i32);
    let mut sum = 0.0;
    for dy in -half..=half {
        for dx in -half..=half {
            sum += luminance(rgb(image.get_pixel((cx + dx) as u32, (cy + dy) as u32)));
        }
    }
    sum / ((2 * half + 1) * (2 * half + 1)) as f32
}

pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Returns the largest difference of a channel between two pixels, 0 to 255.
pub fn difference(a: &Rgba<u8>, b: &Rgba<u8>) -> u8 {
    (0..3).map(|i| a.0[i].abs_diff(b.0[i])).max().unwrap_or(0)
}

/// Returns the light before the tone curve and after exposure for a grey of the screen, below the shoulder of the curve.
pub fn light(seen: f32) -> f32 {
    0.26 * (seen / (1.0 - seen).max(0.01)).powf(1.0 / 1.08)
}
