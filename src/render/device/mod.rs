//! The graphics device and the parts common to all passes. In: a display, shader files, bytes. Out: a
//! [`Gpu`](gpu::Gpu), pipelines, targets, times and counts of a picture.

mod adapter;
pub mod cost;
pub mod gpu;
pub mod layout;
pub mod pipeline;
pub mod shader;
pub(super) mod targets;
pub mod timing;
