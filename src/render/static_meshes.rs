//! Resources that all passes share: the device, static meshes and textures. In: a [`StaticScene`]. Out: handles, lent
//! to each draw.

use super::{
    device::{cost::CountedQueue, gpu::Gpu},
    instances::PlacedTrees,
    models::ModelMeshes,
    sky::clouds,
    textures::{impostor, leaf_textures, noise_texture},
};
use crate::scene::StaticScene;

/// Device, meshes, trees and textures.
#[derive(Debug)]
pub struct StaticMeshes {
    /// Device of all passes.
    pub device: wgpu::Device,
    /// Queue that counts the uploaded bytes.
    pub queue: CountedQueue,
    /// Meshes of cars, trees and ground.
    pub models: ModelMeshes,
    /// Trees and tufts, placed.
    pub forest: PlacedTrees,
    /// Grain of the surfaces.
    pub grain: wgpu::TextureView,
    /// Masks of the leaf cards.
    pub leaves: wgpu::TextureView,
    /// Pictures of far trees.
    pub far_trees: wgpu::TextureView,
}

impl StaticMeshes {
    /// Uploads a static scene.
    pub fn new(gpu: &Gpu, static_scene: &StaticScene) -> Self {
        let (device, queue) = (&gpu.device, &gpu.queue);
        // Painting on the CPU runs in parallel with the upload of the meshes.
        let ((grain, pictures), models) = rayon::join(
            || rayon::join(noise_texture::levels, || impostor::paint(&static_scene.trees)),
            || rayon::join(|| ModelMeshes::new(device, queue, static_scene), clouds::prepare).0,
        );
        Self {
            device: device.clone(),
            queue: CountedQueue::new(queue.clone()),
            forest: PlacedTrees::new(static_scene, &models),
            grain: noise_texture::upload(device, queue, &grain),
            leaves: leaf_textures::upload(device, queue),
            far_trees: impostor::upload(device, queue, &pictures),
            models,
        }
    }
}
