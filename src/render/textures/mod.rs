//! Textures that are painted once, on the CPU, from fixed seeds: noise of surfaces, leaves, far trees, light of street lamps. In: seeds and
//! meshes. Out: views with all their mip levels.

pub mod impostor;
pub mod lamp_light;
pub mod leaf_textures;
pub mod noise_texture;
pub(super) mod upload;
