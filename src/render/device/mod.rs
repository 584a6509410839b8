//! The graphics device and what every pass needs of it. In: a display, shader files, bytes. Out: a [`Gpu`](gpu::Gpu), pipelines,
//! targets, times and counts of a picture.

pub mod cost;
pub mod gpu;
pub mod layout;
pub mod pipeline;
pub mod shader;
pub(super) mod targets;
pub mod timing;
