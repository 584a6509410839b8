//! Resources that all passes share: the device, static meshes and textures. In: a [`StaticScene`]. Out: handles, lent to
//! each draw.

use super::{
    device::{cost::CountedQueue, gpu::Gpu},
    instances::PlacedTrees,
    models::ModelMeshes,
    sky::clouds,
    textures::{impostor, leaf_textures, noise_texture},
};
use crate::scene::StaticScene;

/// Device, meshes, trees and grain.
#[derive(Debug)]
pub struct StaticMeshes {
    /// Makes buffers.
    pub device: wgpu::Device,
    /// Takes data, and counts it.
    pub queue: CountedQueue,
    /// Meshes.
    pub models: ModelMeshes,
    /// Placed trees.
    pub forest: PlacedTrees,
    /// Grain of the surfaces.
    pub grain: wgpu::TextureView,
    /// What is cut out of leaf cards.
    pub leaves: wgpu::TextureView,
    /// What trees look like from afar.
    pub far_trees: wgpu::TextureView,
}

impl StaticMeshes {
    /// Uploads a stage.
    pub fn new(gpu: &Gpu, stage: &StaticScene) -> Self {
        let (device, queue) = (&gpu.device, &gpu.queue);
        // What is painted on the processor, side by side with the meshes' way to the device.
        let ((grain, pictures), models) = rayon::join(
            || rayon::join(noise_texture::levels, || impostor::paint(&stage.trees)),
            || rayon::join(|| ModelMeshes::new(device, queue, stage), clouds::prepare).0,
        );
        Self {
            device: device.clone(),
            queue: CountedQueue::new(queue.clone()),
            forest: PlacedTrees::new(stage, &models),
            grain: noise_texture::upload(device, queue, &grain),
            leaves: leaf_textures::upload(device, queue),
            far_trees: impostor::upload(device, queue, &pictures),
            models,
        }
    }
}
