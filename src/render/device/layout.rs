//! What crosses from the CPU to the shaders: uniforms, instances and the vertex layouts. In: scene types. Out: bytes.
//! The test at the end compares every offset with the shader's own (naga), so no comment has to be kept in step.
//! glam's types are not used as fields: their alignment depends on the features that other crates switch on.

use crate::scene::Vertex;
use glam::{Affine3A, Mat4, Vec3};

/// What one camera's pass knows (`Frame` in `common.wgsl`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Frame {
    /// World to clip space, depth reversed.
    pub clip_from_world: [[f32; 4]; 4],
    /// Rows of the rotation that looks along the sunlight.
    pub light_from_world: [[f32; 4]; 3],
    /// From there to the shadow maps, factors: moving things, standing things near by, standing things far off.
    pub light_scale: [[f32; 4]; 3],
    /// And what is added after them; w is the layer.
    pub light_shift: [[f32; 4]; 3],
    /// Eye, metres; w is 1 for a perspective lens, 0 for a parallel one.
    pub eye: [f32; 4],
    /// Optical axis; w is the speed of the wind, m/s.
    pub forward: [f32; 4],
    /// To the right edge of the picture at distance 1 along the axis (zero for a parallel lens).
    pub right: [f32; 4],
    /// To the upper edge, likewise.
    pub up: [f32; 4],
    /// Unit direction to the sun; w is the time in seconds.
    pub to_sun_time: [f32; 4],
    /// Width of a shadow texel in metres, likewise; texels per map side.
    pub shadow: [f32; 4],
}

/// The light of the hour (`Air` in `common.wgsl`), see [`Sky`](crate::render::sky::atmosphere::Sky).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Air {
    /// What the air takes from a view along the ground, 1/m.
    pub extinction: [f32; 4],
    /// Light on a white sheet by its normal, without the sun.
    pub harmonics: [[f32; 4]; 9],
}

/// Camera of a shadow map (`Light` in `shadow.wgsl`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Light {
    /// World to the map, depth 0 at the sun's end.
    pub clip_from_world: [[f32; 4]; 4],
}

/// Where and how a developed picture lies in the target (`Print` in `tonemap.wgsl`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Print {
    /// Width and height, pixels.
    pub size: [f32; 2],
    /// 1 to flip left and right, else 0.
    pub flip: f32,
    /// Width of the frame around the picture, pixels; 0 for none.
    pub border: f32,
    /// Radius of the corners, pixels.
    pub corner: f32,
    /// Factor on the light before the tone curve.
    pub exposure: f32,
    /// 1 to filter the steps along edges, else 0.
    pub soften: f32,
    /// Light of a halo where its texture holds a 1; 0 for a picture without one.
    pub bloom: f32,
    /// A mirror's glass, see [`Glass`](crate::render::post::tonemap::MirrorGlass): tangents of half its angles, curvature, share of the
    /// drawn picture that is seen in its middle.
    pub lens: [f32; 4],
    /// Upper left corner in clip space.
    pub corner_clip: [f32; 4],
    /// What a pixel to the right adds to that, and one down.
    pub right_clip: [f32; 4],
    /// See `right_clip`.
    pub down_clip: [f32; 4],
}

/// One placed mesh: a car's body, a wheel, a tree, the road.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Instance {
    /// Rows of the mesh-to-world map.
    pub rows: [[f32; 4]; 3],
    /// Paint or tint, linear; w of a car is the number on its plates plus half of its brake lamps' light (0..1).
    pub colour_brake: [f32; 4],
}

impl Instance {
    /// An instance at `world_from_mesh`.
    pub fn new(world_from_mesh: Affine3A, colour: [f32; 3], brake: f32) -> Self {
        let m = Mat4::from(world_from_mesh).transpose();
        Self {
            rows: [m.x_axis, m.y_axis, m.z_axis].map(|row| row.to_array()),
            colour_brake: [colour[0], colour[1], colour[2], brake],
        }
    }

    /// Where the mesh's origin is, world axes.
    pub fn origin(&self) -> Vec3 {
        Vec3::new(self.rows[0][3], self.rows[1][3], self.rows[2][3])
    }
}

/// Attributes of [`Vertex`], locations 0 to 4.
const VERTEX: [wgpu::VertexAttribute; 5] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Float32x2, 4 => Uint32];
/// Attributes of [`Instance`], locations 5 to 8.
const INSTANCE: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![5 => Float32x4, 6 => Float32x4, 7 => Float32x4, 8 => Float32x4];

/// Buffers of a placed mesh: vertices, then instances.
pub fn mesh_buffers() -> [Option<wgpu::VertexBufferLayout<'static>>; 2] {
    [
        Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<Vertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &VERTEX,
        }),
        Some(instance_buffer()),
    ]
}

/// Buffer of instances alone, for shapes that the shader makes itself.
pub fn instance_buffer() -> wgpu::VertexBufferLayout<'static> {
    wgpu::VertexBufferLayout {
        array_stride: size_of::<Instance>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &INSTANCE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::device::shader::ShaderSources;
    use std::mem::offset_of;
    use wgpu::naga;

    /// Offsets and size of a struct as the shader lays it out.
    fn shader_layout(program: &str, name: &str) -> (Vec<(String, u32)>, u32) {
        let module = ShaderSources::built_in().parse(program).expect("the shader parses");
        let found = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name)).expect("the struct exists");
        let naga::TypeInner::Struct { members, span } = &found.1.inner else { panic!("{name} is no struct") };
        (members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect(), *span)
    }

    macro_rules! same_layout {
        ($rust:ty, $program:literal, $name:literal, [$($field:ident),+]) => {
            let (members, span) = shader_layout($program, $name);
            let ours = vec![$((stringify!($field).to_owned(), offset_of!($rust, $field) as u32)),+];
            assert_eq!(members, ours, $name);
            assert_eq!(span as usize, size_of::<$rust>(), $name);
        };
    }

    #[test]
    fn uniforms_lie_in_memory_as_the_shaders_read_them() {
        same_layout!(
            Frame,
            "road",
            "Frame",
            [clip_from_world, light_from_world, light_scale, light_shift, eye, forward, right, up, to_sun_time, shadow]
        );
        same_layout!(Air, "road", "Air", [extinction, harmonics]);
        same_layout!(Light, "shadow", "Light", [clip_from_world]);
        same_layout!(
            Print,
            "tonemap",
            "Print",
            [size, flip, border, corner, exposure, soften, bloom, lens, corner_clip, right_clip, down_clip]
        );
    }

    #[test]
    fn vertex_attributes_lie_where_the_structs_have_them() {
        let vertex: Vec<u64> = VERTEX.iter().map(|a| a.offset).collect();
        let ours = [
            offset_of!(Vertex, position),
            offset_of!(Vertex, normal),
            offset_of!(Vertex, colour),
            offset_of!(Vertex, uv),
            offset_of!(Vertex, material),
        ];
        assert_eq!(vertex, ours.map(|o| o as u64));
        let instance: Vec<u64> = INSTANCE.iter().map(|a| a.offset).collect();
        assert_eq!(instance, [0, 16, 32, 48]);
        assert_eq!(offset_of!(Instance, colour_brake), 48);
        assert_eq!(size_of::<Instance>(), 64);
    }

    #[test]
    fn an_instance_carries_its_place() {
        let at = Instance::new(Affine3A::from_translation(Vec3::new(1.0, 2.0, 3.0)), [0.0; 3], 0.0);
        assert_eq!(at.origin(), Vec3::new(1.0, 2.0, 3.0));
    }
}
