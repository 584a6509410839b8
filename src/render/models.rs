//! The stage's meshes on the device: one vertex and one index buffer, filled once. In: a [`Stage`]. Out: [`Model`]s that
//! a pass draws by instances, and the ball that holds each, for culling.

use crate::scene::{Mesh, Stage, Vertex};
use glam::Vec3;
use std::ops::Range;

/// A mesh in the shared buffers.
#[derive(Clone, Debug)]
pub struct Model {
    indices: Range<u32>,
    first_vertex: i32,
    /// Centre of the ball that holds the mesh, in its own frame.
    pub centre: Vec3,
    /// Radius of that ball, metres.
    pub radius_m: f32,
}

/// All meshes.
#[derive(Debug)]
pub struct Models {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    /// Road with its markings.
    pub road: Model,
    /// Meadow and far ground.
    pub land: Model,
    /// A car without wheels.
    pub body: Model,
    /// One wheel.
    pub wheel: Model,
    /// Trees by kind: near by, far away.
    pub trees: Vec<[Model; 2]>,
}

impl Models {
    /// Uploads the meshes of a stage.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, stage: &Stage) -> Self {
        let mut vertices: Vec<Vertex> = Vec::new();
        let mut indices: Vec<u32> = Vec::new();
        let mut add = |mesh: &Mesh| {
            let first = indices.len() as u32;
            let first_vertex = vertices.len() as i32;
            vertices.extend_from_slice(&mesh.vertices);
            indices.extend_from_slice(&mesh.indices);
            let (centre, radius_m) = mesh.bounding_sphere();
            Model { indices: first..indices.len() as u32, first_vertex, centre, radius_m }
        };
        let road = add(&stage.road);
        let land = add(&stage.land);
        let body = add(&stage.car_body);
        let wheel = add(&stage.wheel);
        let trees = stage.trees.iter().zip(&stage.trees_far).map(|(near, far)| [add(near), add(far)]).collect();
        let buffer = |label, bytes: &[u8], usage| {
            // One spare vertex, so that an empty stage is no special case (a buffer may not be empty).
            let size = bytes.len().next_multiple_of(4) as u64 + size_of::<Vertex>() as u64;
            let usage = usage | wgpu::BufferUsages::COPY_DST;
            let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
            let buffer = device.create_buffer(&descriptor);
            queue.write_buffer(&buffer, 0, bytes);
            buffer
        };
        Self {
            vertices: buffer("vertices", bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX),
            indices: buffer("indices", bytemuck::cast_slice(&indices), wgpu::BufferUsages::INDEX),
            road,
            land,
            body,
            wheel,
            trees,
        }
    }

    /// Makes the meshes the source of the pass's draws.
    pub fn bind(&self, pass: &mut wgpu::RenderPass) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
    }

    /// Draws the trees of all kinds, both details.
    pub fn draw_trees(&self, pass: &mut wgpu::RenderPass, ranges: &[[Range<u32>; 2]]) {
        for (model, range) in self.trees.iter().flatten().zip(ranges.iter().flatten()) {
            model.draw(pass, range.clone());
        }
    }
}

impl Model {
    /// Draws the instances in `range`; nothing for an empty mesh or range.
    pub fn draw(&self, pass: &mut wgpu::RenderPass, range: Range<u32>) {
        if !range.is_empty() && !self.indices.is_empty() {
            pass.draw_indexed(self.indices.clone(), self.first_vertex, range);
        }
    }
}
