//! Upload of pictures painted on the CPU. In: bytes, four per texel, for each mip level. Out: a texture view with all
//! of them.

/// A painted texture before it is uploaded.
#[derive(Clone, Copy, Debug)]
pub struct PaintedTexture<'a> {
    /// Label on the device.
    pub label: &'static str,
    /// Side of the full size, texels.
    pub side: usize,
    /// True for an array of pictures, false for one picture.
    pub array: bool,
    /// Texels of all layers for each mip level, the full size first. An empty level is not written.
    pub levels: &'a [Vec<u8>],
}

/// Converts a share, 0 to 1, to a byte.
#[inline]
pub fn byte(share: f32) -> u8 {
    (share.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// Returns `make` of 0, 1, ... `n` - 1, computed in parallel on threads of its own: for tables that are made once and
/// then shared. On a thread pool this could deadlock: a thread that waits for a part of the table may run another task,
/// and if that task needs the table too, it waits for itself.
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
    /// Creates the texture, uploads its levels, and returns its view.
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
