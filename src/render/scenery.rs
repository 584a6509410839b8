//! What all passes share: the device and what stands on the stage. In: a [`Stage`]. Out: handles, lent to each draw.

use super::{crowd::Forest, gpu::Gpu, grain, impostor, leaves, models::Models};
use crate::scene::Stage;

/// Device, meshes, trees and grain.
#[derive(Debug)]
pub struct Scenery {
    /// Makes buffers.
    pub device: wgpu::Device,
    /// Takes data.
    pub queue: wgpu::Queue,
    /// Meshes.
    pub models: Models,
    /// Placed trees.
    pub forest: Forest,
    /// Grain of the surfaces.
    pub grain: wgpu::TextureView,
    /// What is cut out of leaf cards.
    pub leaves: wgpu::TextureView,
    /// What trees look like from afar.
    pub far_trees: wgpu::TextureView,
}

impl Scenery {
    /// Uploads a stage.
    pub fn new(gpu: &Gpu, stage: &Stage) -> Self {
        let models = Models::new(&gpu.device, &gpu.queue, stage);
        Self {
            device: gpu.device.clone(),
            queue: gpu.queue.clone(),
            forest: Forest::new(stage, &models),
            grain: grain::upload(&gpu.device, &gpu.queue),
            leaves: leaves::upload(&gpu.device, &gpu.queue),
            far_trees: impostor::upload(&gpu.device, &gpu.queue, &stage.trees),
            models,
        }
    }
}
