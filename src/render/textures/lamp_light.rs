//! Light of street lamps as a picture of the ground from above: a place costs one sample, however many lamps there are. In: the lamps'
//! heads. Out: a texture, and its place in the world.

use super::upload::{PaintedTexture, byte};
use crate::scene::STREET_LAMP_M;
use glam::{Vec2, Vec3};

/// Width of a texel, m, and the largest number of texels along a side; larger towns have wider texels.
const TEXEL_M: f32 = 0.5;
const MOST_TEXELS: usize = 2048;
/// Intensity of a lamp downwards and to all sides below the horizon, cd.
const INTENSITY_CD: f32 = 900.0;
/// Distance at which a lamp's light has faded to nothing, m.
const REACH_M: f32 = 26.0;
/// Illuminance of a full texel, lx. Texels hold the square root of its share.
const MOST_LX: f32 = 40.0;

/// Picture of the light on the ground.
#[derive(Debug)]
pub struct LampLight {
    /// Texels: share of light, height of the lamps over the lowest.
    texels: Vec<u8>,
    side: usize,
    /// Corner, scale and height for `Frame::street_lamps`.
    pub place: [f32; 4],
    /// Height of the highest lamp over the lowest, at least 1 m.
    pub rise_m: f32,
}

impl LampLight {
    /// Paints the light of lamps; without any, one dark texel.
    pub fn paint(heads: &[Vec3]) -> Self {
        let (low, high) = heads.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        if heads.is_empty() {
            return Self { texels: vec![0; 4], side: 1, place: [0.0, 0.0, 1e-9, 0.0], rise_m: 1.0 };
        }
        let low_corner = low.truncate() - REACH_M;
        let size_m = (high.truncate() + REACH_M - low_corner).max_element();
        let side = ((size_m / TEXEL_M).ceil() as usize).min(MOST_TEXELS);
        let texel_m = size_m / side as f32;
        let rise_m = (high.z - low.z).max(1.0);
        let mut light = vec![(0.0f32, 0.0f32); side * side];
        let reach = (REACH_M / texel_m).ceil() as i32;
        for head in heads {
            let at = (head.truncate() - low_corner) / texel_m;
            let (x, y) = (at.x as i32, at.y as i32);
            for row in (y - reach).max(0)..(y + reach + 1).min(side as i32) {
                for column in (x - reach).max(0)..(x + reach + 1).min(side as i32) {
                    let off = (Vec2::new(column as f32, row as f32) + 0.5 - at) * texel_m;
                    let lux = illuminance_lx(off.length());
                    let texel = &mut light[row as usize * side + column as usize];
                    *texel = (texel.0 + lux, texel.1 + lux * (head.z - low.z));
                }
            }
        }
        let texel = |(lux, height): &(f32, f32)| match *lux > 0.0 {
            // The height of the lamps that light it, weighted by their light.
            true => [byte((lux / MOST_LX).sqrt()), byte(height / lux / rise_m), 0, 255],
            false => [0, 0, 0, 255],
        };
        let place = [low_corner.x, low_corner.y, 1.0 / size_m, low.z];
        let texels: Vec<[u8; 4]> = light.iter().map(texel).collect();
        Self { texels: texels.into_flattened(), side, place, rise_m }
    }

    /// Uploads the picture to the device.
    pub fn upload(self, device: &wgpu::Device, queue: &wgpu::Queue) -> wgpu::TextureView {
        let levels = [self.texels];
        PaintedTexture { label: "street lamps", side: self.side, array: false, levels: &levels }.upload(device, queue)
    }
}

/// Returns the illuminance of level ground at this distance from below a lamp, lx: the inverse-square law with the cosine of incidence.
fn illuminance_lx(distance_m: f32) -> f32 {
    let square = STREET_LAMP_M * STREET_LAMP_M + distance_m * distance_m;
    let fading = (1.0 - distance_m / REACH_M).clamp(0.0, 1.0).min(0.3) / 0.3;
    INTENSITY_CD * STREET_LAMP_M / square.powf(1.5) * fading
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shader_reads_texels_with_the_light_they_were_painted_with() {
        let shader = include_str!("../../../shaders/lamps.wgsl");
        assert!(shader.contains(&format!("const MOST_LX = {MOST_LX:.1};")));
        // A town of 3 km has wider texels, not more of them.
        let light = LampLight::paint(&[Vec3::ZERO, Vec3::new(3000.0, 0.0, 2.0)]);
        assert_eq!((light.side, light.texels.len()), (MOST_TEXELS, 4 * MOST_TEXELS * MOST_TEXELS));
        assert_eq!((light.place[3], light.rise_m), (0.0, 2.0));
    }
}
