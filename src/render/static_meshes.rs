//! Resources that all passes share: the device, static meshes and textures. In: a [`StaticScene`]. Out: handles, lent
//! to each draw.

use super::{
    device::{cost::CountedQueue, gpu::Gpu},
    instances::PlacedTrees,
    models::ModelMeshes,
    sky::clouds,
    textures::{impostor, lamp_light::LampLight, leaf_textures, noise_texture},
    wall_horizon::UprightWall,
};
use crate::scene::{CarInstance, StaticScene};

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
    /// Walls that hide what is behind them.
    pub walls: Vec<UprightWall>,
    /// Cars parked beside houses.
    pub parked_cars: Vec<CarInstance>,
    /// Street lamps' light on the ground.
    pub street_light: wgpu::TextureView,
    /// Place of that light in the world: see `Frame::street_lamps`.
    pub lamp_place: [f32; 4],
    /// Height of the highest street lamp over the lowest, m.
    pub lamp_rise_m: f32,
}

impl StaticMeshes {
    /// Uploads a static scene.
    pub fn new(gpu: &Gpu, static_scene: &StaticScene) -> Self {
        let (device, queue) = (&gpu.device, &gpu.queue);
        // Painting on the CPU runs in parallel with the upload of the meshes.
        let ((grain, pictures), ((models, ()), lamp_light)) = rayon::join(
            || rayon::join(noise_texture::levels, || impostor::paint(&static_scene.trees)),
            || {
                rayon::join(
                    || rayon::join(|| ModelMeshes::new(device, queue, static_scene), clouds::prepare),
                    || LampLight::paint(&static_scene.street_lamps),
                )
            },
        );
        Self {
            device: device.clone(),
            queue: CountedQueue::new(queue.clone()),
            forest: PlacedTrees::new(static_scene, &models),
            grain: noise_texture::upload(device, queue, grain),
            leaves: leaf_textures::upload(device, queue),
            far_trees: impostor::upload(device, queue, &pictures),
            walls: UprightWall::of_mesh(&static_scene.buildings),
            parked_cars: static_scene.parked_cars.clone(),
            lamp_place: lamp_light.place,
            lamp_rise_m: lamp_light.rise_m,
            street_light: lamp_light.upload(device, queue),
            models,
        }
    }
}
