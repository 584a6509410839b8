//! Pictures painted on the processor, brought to the device. In: bytes, four a texel, for each reduced size. Out: a
//! texture view with all of them.

/// A painted texture before it is uploaded.
#[derive(Clone, Copy, Debug)]
pub struct PaintedTexture<'a> {
    /// Its name on the device.
    pub label: &'static str,
    /// Side of its full size, texels.
    pub side: usize,
    /// Whether it is an array of pictures, which may hold any number of them, or one picture.
    pub array: bool,
    /// Of each reduced size, the whole one first, the texels of all layers. Nothing is written for an empty one.
    pub levels: &'a [Vec<u8>],
}

/// A share, 0..1, as a byte.
#[inline]
pub fn byte(share: f32) -> u8 {
    (share.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// What `make` gives for 0, 1, ... `n` - 1, made side by side on threads of its own: for tables that are made once and then
/// shared. A thread of a pool that waits for a part of such a table may take up another task of the pool; if that needs the
/// table too, it waits for itself.
pub fn side_by_side<T: Send>(n: usize, make: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(16);
    let share = n.div_ceil(threads).max(1);
    std::thread::scope(|scope| {
        let make = &make;
        let part = |start: usize| scope.spawn(move || (start..(start + share).min(n)).map(make).collect::<Vec<T>>());
        let parts: Vec<_> = (0..n).step_by(share).map(part).collect();
        parts.into_iter().flat_map(|part| part.join().expect("painting does not panic")).collect()
    })
}

impl PaintedTexture<'_> {
    /// The texture's view.
    pub fn upload(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> wgpu::TextureView {
        let layers = (self.levels[0].len() / (4 * self.side * self.side)).max(1) as u32;
        let size = |side: u32| wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layers };
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some(self.label),
            size: size(self.side as u32),
            mip_level_count: self.levels.len() as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for (mip_level, bytes) in (0..).zip(self.levels).filter(|(_, bytes)| !bytes.is_empty()) {
            let side = self.side as u32 >> mip_level;
            queue.write_texture(
                wgpu::TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() },
                bytes,
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(side * 4), rows_per_image: Some(side) },
                size(side),
            );
        }
        let dimension = if self.array { wgpu::TextureViewDimension::D2Array } else { wgpu::TextureViewDimension::D2 };
        texture.create_view(&wgpu::TextureViewDescriptor { dimension: Some(dimension), ..Default::default() })
    }
}
