//! Cost of one picture on the device, counted at submission: draws, instances, triangles and bytes. In: the calls of
//! the passes. Out: a [`FrameCost`]. The counts are the same on every machine, so that a test can hold a picture to a
//! budget without a clock.

use std::{
    cell::Cell,
    ops::{Add, AddAssign, Deref, DerefMut, Range},
};

/// Cost of one pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct PassCost {
    /// Number of draw calls.
    pub draws: u64,
    /// Number of meshes or shapes placed by the draw calls.
    pub instances: u64,
    /// Number of triangles drawn, including hidden ones and those outside the picture.
    pub triangles: u64,
}

/// Cost of one picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct FrameCost {
    /// All shadow maps that were drawn, whole or in part.
    pub shadow: PassCost,
    /// Picture of the main camera.
    pub main: PassCost,
    /// Pictures of the mirrors.
    pub mirror: PassCost,
    /// Halos, tone curve and placement of the mirrors.
    pub tonemap: PassCost,
    /// Dial and experimenter's panel.
    pub overlay: PassCost,
    /// Bytes written to the device: instances, uniforms, egui's output; the sky when the hour changes.
    pub uploaded_bytes: u64,
}

impl FrameCost {
    /// Returns the sum of all passes.
    pub fn total(&self) -> PassCost {
        self.shadow + self.main + self.mirror + self.tonemap + self.overlay
    }
}

impl Add for PassCost {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            draws: self.draws + other.draws,
            instances: self.instances + other.instances,
            triangles: self.triangles + other.triangles,
        }
    }
}

impl AddAssign for PassCost {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// A render pass of triangle lists that counts its draws; otherwise like wgpu's.
pub struct CountedPass<'e> {
    pass: wgpu::RenderPass<'e>,
    cost: PassCost,
}

impl<'e> CountedPass<'e> {
    /// Wraps a pass that has drawn nothing yet.
    pub fn new(pass: wgpu::RenderPass<'e>) -> Self {
        Self { pass, cost: PassCost::default() }
    }

    /// Counts and forwards `wgpu::RenderPass::draw`.
    pub fn draw(&mut self, vertices: Range<u32>, instances: Range<u32>) {
        self.count(vertices.len(), instances.len());
        self.pass.draw(vertices, instances);
    }

    /// Counts and forwards `wgpu::RenderPass::draw_indexed`.
    pub fn draw_indexed(&mut self, indices: Range<u32>, base_vertex: i32, instances: Range<u32>) {
        self.count(indices.len(), instances.len());
        self.pass.draw_indexed(indices, base_vertex, instances);
    }

    /// Returns the cost so far.
    pub fn cost(&self) -> PassCost {
        self.cost
    }

    fn count(&mut self, corners: usize, instances: usize) {
        let triangles = (corners / 3 * instances) as u64;
        self.cost += PassCost { draws: 1, instances: instances as u64, triangles };
    }
}

impl<'e> Deref for CountedPass<'e> {
    type Target = wgpu::RenderPass<'e>;

    fn deref(&self) -> &Self::Target {
        &self.pass
    }
}

impl DerefMut for CountedPass<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.pass
    }
}

/// A queue that counts the bytes written through it; otherwise like wgpu's.
#[derive(Debug)]
pub struct CountedQueue {
    queue: wgpu::Queue,
    bytes: Cell<u64>,
}

impl CountedQueue {
    /// Wraps a queue, with a count of 0.
    pub fn new(queue: wgpu::Queue) -> Self {
        Self { queue, bytes: Cell::new(0) }
    }

    /// Counts and forwards `wgpu::Queue::write_buffer`.
    pub fn write_buffer(&self, buffer: &wgpu::Buffer, offset: wgpu::BufferAddress, data: &[u8]) {
        self.bytes.update(|bytes| bytes + data.len() as u64);
        self.queue.write_buffer(buffer, offset, data);
    }

    /// Counts and forwards `wgpu::Queue::write_texture`.
    pub fn write_texture(
        &self,
        texture: wgpu::TexelCopyTextureInfo<'_>,
        data: &[u8],
        layout: wgpu::TexelCopyBufferLayout,
        size: wgpu::Extent3d,
    ) {
        self.bytes.update(|bytes| bytes + data.len() as u64);
        self.queue.write_texture(texture, data, layout, size);
    }

    /// Returns the bytes written since the last call.
    pub fn take_bytes(&self) -> u64 {
        self.bytes.take()
    }
}

impl Deref for CountedQueue {
    type Target = wgpu::Queue;

    fn deref(&self) -> &Self::Target {
        &self.queue
    }
}
