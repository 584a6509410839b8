//! Data passed from the CPU to the shaders: uniforms, instances and the vertex layouts. In: scene types. Out: bytes.
//! The tests at the end compare every offset of the uniforms with the shader's own (naga), so that no comment has to be
//! kept in step. glam's types are not used as fields: their alignment depends on the features that other crates enable.

use crate::scene::Vertex;
use glam::{Affine3A, Mat4, Vec3};

/// Uniforms of one camera's pass (`Frame` in `common.wgsl`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Frame {
    /// World to clip space, reversed depth.
    pub clip_from_world: [[f32; 4]; 4],
    /// Rows of the rotation from world axes to the axes of the sunlight.
    pub light_from_world: [[f32; 4]; 3],
    /// Scale from light axes to each shadow map: moving objects, near static objects, far static objects.
    pub light_scale: [[f32; 4]; 3],
    /// Offset added after the scale; w is the layer.
    pub light_shift: [[f32; 4]; 3],
    /// Eye, m; w is 1 for a perspective lens, 0 for a parallel one.
    pub eye: [f32; 4],
    /// Optical axis; w is the wind speed, m/s.
    pub forward: [f32; 4],
    /// Vector to the right edge of the picture at distance 1 along the axis (zero for a parallel lens).
    pub right: [f32; 4],
    /// Vector to the upper edge, likewise.
    pub up: [f32; 4],
    /// Unit direction to the sun, or to the moon after sunset; w is the time, s.
    pub to_sun_time: [f32; 4],
    /// Width of a shadow texel for each map, m; w is the number of texels along a map's side.
    pub shadow: [f32; 4],
    /// Radiance of a dipped head lamp, 0 if off; factor on the light that lamps show; radiance of a white sheet in a light of 1 lx;
    /// height of the highest street lamp over the lowest, m.
    pub lamps: [f32; 4],
    /// Velocity of the eye, m/s; w is the intensity of the rain, mm/h.
    pub motion: [f32; 4],
    /// Time from the begin of a sweep of the wipers to the next, s; duration of a sweep, s; the others are unused.
    pub wipers: [f32; 4],
    /// Picture of the street lamps' light: its south-west corner, m; 1 over its side, 1/m; height of the lowest lamp, m.
    pub street_lamps: [f32; 4],
    /// Beams of headlamps near the picture.
    pub beams: [HeadlampBeam; MOST_BEAMS],
}

/// Largest number of beams in a picture.
pub const MOST_BEAMS: usize = 16;

/// Beam of a vehicle's headlamps, and the vehicle that stands in it (`Beam` in `common.wgsl`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct HeadlampBeam {
    /// Position of the lamps, m; w is the distance to the vehicle in the beam.
    pub place: [f32; 4],
    /// Unit vector ahead; w is the tangent of that vehicle's bearing, positive along `inner`.
    pub ahead: [f32; 4],
    /// Unit vector towards the oncoming traffic; w is the tangent of half of the angle that the vehicle takes, 0 without one.
    pub inner: [f32; 4],
    /// Share of its light, less than 1 for the last of the nearest beams; 1 with the main beam; the others are unused.
    pub share: [f32; 4],
}

/// Light for the time of day (`Air` in `common.wgsl`), see [`Sky`](crate::render::sky::atmosphere::Sky).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Air {
    /// Extinction along a horizontal view, 1/m.
    pub extinction: [f32; 4],
    /// Radiance of thick fog at the zenith, and 1 in thick fog, 0 without fog.
    pub fog: [f32; 4],
    /// Irradiance by the normal of a surface, without the sun: spherical harmonics.
    pub harmonics: [[f32; 4]; 9],
}

/// Camera of a shadow map (`Light` in `shadow.wgsl`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Light {
    /// World to the map, depth 0 at the sun's end.
    pub clip_from_world: [[f32; 4]; 4],
}

/// Placement and tone mapping of a picture on the target (`QuadUniform` in `quad.wgsl`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct QuadUniform {
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
    /// Light of a halo where its texture holds 1; 0 for a picture without halos.
    pub bloom: f32,
    /// Glass of a mirror, see [`MirrorGlass`](crate::render::post::tonemap::MirrorGlass): tangents of half its angles,
    /// curvature, share of the drawn picture that is seen in its middle.
    pub lens: [f32; 4],
    /// Upper left corner in clip space.
    pub corner_clip: [f32; 4],
    /// Clip-space offset of one pixel to the right.
    pub right_clip: [f32; 4],
    /// Clip-space offset of one pixel down.
    pub down_clip: [f32; 4],
}

/// One placed mesh: a vehicle's body, a wheel, a tree, the road.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Instance {
    /// Rows of the transform from mesh to world.
    pub rows: [[f32; 4]; 3],
    /// Paint or tint, linear; w of a vehicle is the number on its plates, or the code of a person's posture, plus half of its brake lamps' light
    /// (0 to 1), negative for a parked car.
    pub colour_brake: [f32; 4],
}

impl Instance {
    /// Creates an instance at `world_from_mesh`.
    pub fn new(world_from_mesh: Affine3A, colour: [f32; 3], brake: f32) -> Self {
        let m = Mat4::from(world_from_mesh).transpose();
        Self {
            rows: [m.x_axis, m.y_axis, m.z_axis].map(|row| row.to_array()),
            colour_brake: [colour[0], colour[1], colour[2], brake],
        }
    }

    /// Returns the position of the mesh's origin, world axes.
    pub fn origin(&self) -> Vec3 {
        Vec3::new(self.rows[0][3], self.rows[1][3], self.rows[2][3])
    }
}

/// Attributes of [`Vertex`], locations 0 to 4.
const VERTEX: [wgpu::VertexAttribute; 5] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Float32x2, 4 => Uint32];
/// Position and normal of another [`Vertex`], locations 9 and 10 for the next phase of a person's gait, 11 and 12 for the standing posture.
const NEXT: [wgpu::VertexAttribute; 2] = wgpu::vertex_attr_array![9 => Float32x3, 10 => Float32x3];
const STANDING: [wgpu::VertexAttribute; 2] = wgpu::vertex_attr_array![11 => Float32x3, 12 => Float32x3];
/// Attributes of [`Instance`], locations 5 to 8.
const INSTANCE: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![5 => Float32x4, 6 => Float32x4, 7 => Float32x4, 8 => Float32x4];

/// Returns the buffers of a placed mesh: vertices, then instances.
pub fn mesh_buffers() -> [Option<wgpu::VertexBufferLayout<'static>>; 2] {
    [Some(vertex_buffer(&VERTEX)), Some(instance_buffer())]
}

/// Returns the buffers of a placed person: those of a mesh, then the vertices of the next phase of the gait and of the standing posture.
pub fn person_buffers() -> [Option<wgpu::VertexBufferLayout<'static>>; 4] {
    let [mesh, instances] = mesh_buffers();
    [mesh, instances, Some(vertex_buffer(&NEXT)), Some(vertex_buffer(&STANDING))]
}

fn vertex_buffer(attributes: &'static [wgpu::VertexAttribute]) -> wgpu::VertexBufferLayout<'static> {
    let step_mode = wgpu::VertexStepMode::Vertex;
    wgpu::VertexBufferLayout { array_stride: size_of::<Vertex>() as u64, step_mode, attributes }
}

/// Returns the buffer of instances alone, for shapes that the shader makes itself.
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

    /// Returns the offsets and size of a struct as the shader lays it out.
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
            [
                clip_from_world,
                light_from_world,
                light_scale,
                light_shift,
                eye,
                forward,
                right,
                up,
                to_sun_time,
                shadow,
                lamps,
                motion,
                wipers,
                street_lamps,
                beams
            ]
        );
        same_layout!(HeadlampBeam, "road", "Beam", [place, ahead, inner, share]);
        same_layout!(Air, "road", "Air", [extinction, fog, harmonics]);
        same_layout!(Light, "shadow", "Light", [clip_from_world]);
        same_layout!(
            QuadUniform,
            "tonemap",
            "QuadUniform",
            [size, flip, border, corner, exposure, soften, bloom, lens, corner_clip, right_clip, down_clip]
        );
    }

    #[test]
    fn vertex_attributes_have_the_offsets_of_the_structs() {
        let vertex: Vec<u64> = VERTEX.iter().map(|a| a.offset).collect();
        let ours = [
            offset_of!(Vertex, position),
            offset_of!(Vertex, normal),
            offset_of!(Vertex, colour),
            offset_of!(Vertex, uv),
            offset_of!(Vertex, material),
        ];
        assert_eq!(vertex, ours.map(|o| o as u64));
        for posture in [NEXT, STANDING] {
            assert_eq!(
                posture.map(|a| a.offset),
                [offset_of!(Vertex, position), offset_of!(Vertex, normal)].map(|o| o as u64)
            );
        }
        let instance: Vec<u64> = INSTANCE.iter().map(|a| a.offset).collect();
        assert_eq!(instance, [0, 16, 32, 48]);
        assert_eq!(offset_of!(Instance, colour_brake), 48);
        assert_eq!(size_of::<Instance>(), 64);
    }

    #[test]
    fn an_instance_carries_its_position() {
        let at = Instance::new(Affine3A::from_translation(Vec3::new(1.0, 2.0, 3.0)), [0.0; 3], 0.0);
        assert_eq!(at.origin(), Vec3::new(1.0, 2.0, 3.0));
    }
}
