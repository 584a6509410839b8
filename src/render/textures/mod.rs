//! Textures that are painted once, on the processor, from fixed seeds: noise of surfaces, leaves, far trees. Out: views with all
//! their reduced sizes.

pub mod impostor;
pub mod leaf_textures;
pub mod noise_texture;
pub(super) mod upload;
