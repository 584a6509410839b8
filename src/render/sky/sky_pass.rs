//! The sky on the device: its picture with mip levels for dull reflections, its clouds, and the uniforms of the light.
//! In: a view's sun, visibility and rain. Out: bindings. They are filled when the time of day changes, i.e. once a drive,
//! without new allocations on the device.

use super::{
    atmosphere::{SIZE, Sky},
    clouds,
};
use crate::render::device::{cost::CountedQueue, layout::Air, targets::uniform_buffer};
use crate::scene::View;
use glam::Vec3;

/// Offset of the sun's colour in the buffer, bytes: uniforms are bound at multiples of this.
const SUN_AT: u64 = 256;
/// Number of mip levels of the sky: the smallest is 4 by 4.
const LEVELS: u32 = SIZE.ilog2() - 1;

/// Sky and light on the device.
#[derive(Debug)]
pub struct SkyPass {
    uniform: wgpu::Buffer,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    sampler: wgpu::Sampler,
    clouds: wgpu::Texture,
    clouds_group: wgpu::BindGroup,
    sky: Option<Sky>,
}

/// Creates the layout of the clouds' picture, group 1 of the sky's program.
pub fn clouds_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("clouds"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: true },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        }],
    })
}

impl SkyPass {
    /// Creates empty buffers and textures; the clouds' picture is `clouds_side` texels wide.
    pub fn new(device: &wgpu::Device, clouds_side: u32) -> Self {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("sky"),
            size: wgpu::Extent3d { width: SIZE as u32, height: SIZE as u32, depth_or_array_layers: 1 },
            mip_level_count: LEVELS,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let clouds = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("clouds"),
            size: wgpu::Extent3d { width: clouds_side, height: clouds_side, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let clouds_view = clouds.create_view(&wgpu::TextureViewDescriptor::default());
        let clouds_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("clouds"),
            layout: &clouds_layout(device),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&clouds_view) }],
        });
        Self {
            clouds,
            clouds_group,
            uniform: uniform_buffer(device, "air", SUN_AT as usize + 16),
            view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            texture,
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("sky"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            }),
            sky: None,
        }
    }

    /// Returns the uniforms of the light, the sun's colour, the sky's picture and its sampler.
    pub fn resources(&self) -> [wgpu::BindingResource<'_>; 4] {
        let part = |offset, size| {
            let size = wgpu::BufferSize::new(size);
            wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer: &self.uniform, offset, size })
        };
        [
            part(0, size_of::<Air>() as u64),
            part(SUN_AT, 16),
            wgpu::BindingResource::TextureView(&self.view),
            wgpu::BindingResource::Sampler(&self.sampler),
        ]
    }

    /// Returns the clouds, for the sky's program.
    pub fn clouds(&self) -> &wgpu::BindGroup {
        &self.clouds_group
    }

    /// Computes and uploads the sky of a view, unless it is the current one; returns it.
    pub fn fit(&mut self, queue: &CountedQueue, view: &View) -> &Sky {
        let (to_sun, visibility_m, is_overcast) = (view.to_sun, view.visibility_m, view.rain_mmph > 0.0);
        let same = |sky: &Sky| (sky.to_sun, sky.visibility_m, sky.is_overcast) == (to_sun, visibility_m, is_overcast);
        if !self.sky.as_ref().is_some_and(same) {
            let sky = Sky::new(to_sun, visibility_m, is_overcast);
            self.upload(queue, &sky);
            self.sky = Some(sky);
        }
        self.sky.as_ref().expect("made above")
    }

    /// Writes a sky to the device.
    fn upload(&self, queue: &CountedQueue, sky: &Sky) {
        let wide = |v: Vec3| v.extend(0.0).to_array();
        let (glow, thick) = sky.fog();
        let air = Air {
            extinction: wide(sky.extinction_per_m),
            fog: glow.extend(thick).to_array(),
            harmonics: sky.harmonics.map(wide),
        };
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&air));
        queue.write_buffer(&self.uniform, SUN_AT, bytemuck::bytes_of(&wide(sky.sun)));
        let side = self.clouds.width();
        let clouds: Vec<[u16; 4]> = clouds::paint(sky, side as usize).iter().map(|t| t.to_array().map(half)).collect();
        queue.write_texture(
            self.clouds.as_image_copy(),
            bytemuck::cast_slice(&clouds),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(side * 8), rows_per_image: None },
            self.clouds.size(),
        );
        let mut texels = sky.picture();
        let mut side = SIZE;
        for level in 0..LEVELS {
            let halves: Vec<[u16; 4]> = texels.iter().map(|t| [half(t.x), half(t.y), half(t.z), half(1.0)]).collect();
            queue.write_texture(
                wgpu::TexelCopyTextureInfo { mip_level: level, ..self.texture.as_image_copy() },
                bytemuck::cast_slice(&halves),
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(side as u32 * 8), rows_per_image: None },
                wgpu::Extent3d { width: side as u32, height: side as u32, depth_or_array_layers: 1 },
            );
            side /= 2;
            let at = |x: usize, y: usize| texels[y * 2 * side + x];
            texels = (0..side * side)
                .map(|i| (2 * (i % side), 2 * (i / side)))
                .map(|(x, y)| (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) / 4.0)
                .collect();
        }
    }
}

/// Converts a number from 0 to 65504 to a 16-bit float, truncated.
fn half(value: f32) -> u16 {
    let bits = value.clamp(0.0, 65504.0).to_bits();
    // From a bias of 127 and 23 bits to one of 15 and 10; below 2^-14 the result is only roughly right, near 0.
    ((bits >> 13).saturating_sub((127 - 15) << 10)) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_half_is_the_number_within_a_thousandth() {
        for value in [0.0001f32, 0.03, 0.5, 1.0, 1.5, 37.2, 60000.0] {
            let bits = u32::from(half(value));
            let exponent = (bits >> 10) as i32 - 15;
            let back = (1.0 + (bits & 1023) as f32 / 1024.0) * 2f32.powi(exponent);
            assert!((back / value - 1.0).abs() < 1e-3, "{value} {back}");
        }
        assert_eq!(half(0.0), 0);
    }
}
