//! First pass: what the sun does not reach. In: cars and trees. Out: three depth maps seen from the sun.
//!
//! Layer 0 holds what moves (cars), drawn every frame around the camera. Layers 1 and 2 hold what stands (trees), near by
//! and far off; they follow the camera in steps and are drawn anew only when they have moved, so that trees cost their
//! thousands of corners once every few seconds. All are functions of the view alone: the same view gives the same
//! shadows. Each moves by whole texels, so that the edges of shadows stay on the ground while the camera drives.

use super::{
    crowd::{Around, Batches, CarDetail, Crowd, Detail},
    layout::{Light, mesh_buffers},
    lens::Optics,
    pipeline::{DEPTH, Recipe, Workshop},
    quality::Quality,
    scenery::Scenery,
    timing,
};
use crate::scene::View;
use glam::{Mat4, Vec3, camera::rh};

/// Half the width of the map of moving things for a perspective picture, metres: 3.1 cm a texel at 2048.
const MOVING_M: f32 = 32.0;
/// Half the widths of the maps of standing things, metres: 6 cm and 18 cm a texel at 2048.
const STANDING_M: [f32; 2] = [64.0, 184.0];
/// Grids on which the maps of standing things follow the camera, metres.
const STEP_M: [f32; 2] = [12.0, 36.0];
/// What throws those shadows where leaves do.
const SHADES: [Detail; 2] = [Detail::Near, Detail::Mid];
/// Width of a texel from which cars throw the shadow of their coarsest body, metres.
const COARSE_M: f32 = 0.05;
/// And from which that of their plan.
const PLAN_M: f32 = 0.16;
/// Half the depth of both maps beyond their half width, metres: the highest tree's shadow.
const HEIGHT_M: f32 = 40.0;

/// The pipeline; made anew when shaders are reloaded.
#[derive(Debug)]
pub struct ShadowPipeline {
    solid: wgpu::RenderPipeline,
    /// For leaf cards; none where trees throw the shadows of solid lumps.
    leaves: Option<wgpu::RenderPipeline>,
}

/// The pass.
#[derive(Debug)]
pub struct ShadowPass {
    layout: wgpu::PipelineLayout,
    maps: wgpu::TextureView,
    moving: Layer,
    standing: [Layer; 2],
    size: u32,
    /// Leaf cards throw shadows with gaps; otherwise solid lumps do, at a tenth of the work.
    fine: bool,
    /// Where the standing maps were last drawn.
    drawn: [Option<Cover>; 2],
}

/// What the other passes need to look up shadows.
#[derive(Clone, Copy, Debug)]
pub struct Lights {
    /// Rows of the rotation from the world into the sun's view.
    pub rows: [Vec3; 3],
    /// From the sun's view to the maps: factors. Moving, standing near by, standing far off.
    pub scale: [Vec3; 3],
    /// And what is added after them.
    pub shift: [Vec3; 3],
    /// Width of a texel, metres, likewise.
    pub texel_m: [f32; 3],
    /// Texels on a side.
    pub size: u32,
}

#[derive(Debug)]
struct Layer {
    view: wgpu::TextureView,
    uniform: wgpu::Buffer,
    group: wgpu::BindGroup,
    crowd: Crowd,
}

/// The square of ground that a map covers, seen from the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cover {
    to_sun: Vec3,
    centre: Vec3,
    half_m: f32,
}

impl ShadowPass {
    /// Maps of the size and fineness that the quality asks for.
    pub fn new(device: &wgpu::Device, scenery: &Scenery, quality: &Quality) -> Self {
        let size = quality.shadow_size;
        let visibility = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        let group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("light"),
            entries: &[
                entry(
                    0,
                    wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                ),
                entry(
                    1,
                    wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: true },
                        view_dimension: wgpu::TextureViewDimension::D2Array,
                        multisampled: false,
                    },
                ),
                entry(2, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
            ],
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("leaves"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow maps"),
            size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: 3 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let layer = |index| {
            let uniform = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("light"),
                size: size_of::<Light>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("light"),
                layout: &group_layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                    wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&scenery.leaves) },
                    wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(&sampler) },
                ],
            });
            let view = texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: index,
                array_layer_count: Some(1),
                ..Default::default()
            });
            Layer { view, uniform, group, crowd: Crowd::new(device, &scenery.forest, 64) }
        };
        Self {
            layout: device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("shadow"),
                bind_group_layouts: &[Some(&group_layout)],
                immediate_size: 0,
            }),
            maps: texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            }),
            moving: layer(0),
            standing: [layer(1), layer(2)],
            size,
            fine: quality.fine,
            drawn: [None; 2],
        }
    }

    /// The pass's pipeline.
    ///
    /// # Errors
    /// What is wrong with the shader.
    pub fn pipeline(&self, workshop: &Workshop) -> Result<ShadowPipeline, String> {
        let recipe = Recipe {
            program: "shadow",
            layout: &self.layout,
            buffers: &mesh_buffers(),
            colour: None,
            depth: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::LessEqual),
                stencil: Default::default(),
                // Against acne; the rest is done by the receiver's offset along its normal (`light.wgsl`).
                bias: wgpu::DepthBiasState { constant: 0, slope_scale: 1.5, clamp: 0.0 },
            }),
            cull: None,
            writes: wgpu::ColorWrites::ALL,
            samples: 1,
            cut_out: false,
            constants: &[],
        };
        let leaves = Recipe { program: "leaf_shadow", cut_out: true, ..recipe.clone() };
        let leaves = if self.fine { Some(workshop.pipeline(&leaves)?) } else { None };
        Ok(ShadowPipeline { solid: workshop.pipeline(&recipe)?, leaves })
    }

    /// All maps, for binding.
    pub fn maps(&self) -> &wgpu::TextureView {
        &self.maps
    }

    /// Forgets the standing maps, so that the next picture draws them anew.
    pub fn forget(&mut self) {
        self.drawn = [None; 2];
    }

    /// Draws what throws shadows into the picture of `optics`.
    pub fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        stamps: Option<wgpu::RenderPassTimestampWrites>,
        pipeline: &ShadowPipeline,
        scenery: &Scenery,
        view: &View,
        optics: &Optics,
    ) -> Lights {
        let covers = covers(view.to_sun, optics);
        let lens = covers.map(|cover| cover.lens(self.size));
        let lights = covers.map(|cover| cover.clip_from_world(self.size));
        let fine = self.fine;
        let batches = self.moving.gather(scenery, view, covers[0], lights[0], None, self.size);
        // One time for all: from the first map's begin to the last one's end.
        let stale = [0, 1].map(|i| self.drawn[i] != Some(covers[i + 1]));
        let last = stale.iter().rposition(|stale| *stale).map_or(0, |i| i + 1);
        let stamp = |map: usize| {
            let stamps = stamps.as_ref()?;
            match (map == 0, map == last) {
                (true, true) => Some(stamps.clone()),
                (true, false) => Some(timing::begin_only(stamps)),
                (false, true) => Some(timing::end_only(stamps)),
                (false, false) => None,
            }
        };
        self.moving.draw(encoder, stamp(0), pipeline, scenery, &batches);
        for (i, layer) in self.standing.iter_mut().enumerate() {
            let cover = covers[i + 1];
            if stale[i] {
                let batches = layer.gather(
                    scenery,
                    view,
                    cover,
                    lights[i + 1],
                    Some(if fine { SHADES[i] } else { Detail::Shade }),
                    self.size,
                );
                layer.draw(encoder, stamp(i + 1), pipeline, scenery, &batches);
                self.drawn[i] = Some(cover);
            }
        }
        let rotation = covers[0].view().transpose();
        Lights {
            rows: [rotation.x_axis, rotation.y_axis, rotation.z_axis].map(|row| row.truncate()),
            scale: lens.map(|lens| Vec3::new(lens.x_axis.x, lens.y_axis.y, lens.z_axis.z)),
            shift: lens.map(|lens| lens.w_axis.truncate()),
            texel_m: covers.map(|cover| cover.texel_m(self.size)),
            size: self.size,
        }
    }
}

impl Layer {
    fn gather(
        &mut self,
        scenery: &Scenery,
        view: &View,
        cover: Cover,
        light: Mat4,
        trees: Option<Detail>,
        size: u32,
    ) -> Batches {
        let queue = &scenery.queue;
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&Light { clip_from_world: light.to_cols_array_2d() }));
        let around = Around { forest: trees.map(|_| &scenery.forest), inside: None };
        let cars = if trees.is_some() { &[][..] } else { &view.cars };
        let detail = trees.unwrap_or(Detail::Shade);
        // Where a texel is as wide as a pillar, the coarsest body has the same shadow.
        let car = match cover.texel_m(size) {
            texel_m if texel_m > PLAN_M => CarDetail::Plan,
            texel_m if texel_m > COARSE_M => CarDetail::Far,
            _ => CarDetail::Mid,
        };
        self.crowd.gather(
            (&scenery.device, queue),
            &scenery.models,
            cars.iter(),
            around,
            |centre, radius_m| cover.touches(centre, radius_m).then_some(car),
            |centre, radius_m| [cover.touches(centre, radius_m).then_some((detail, 1.0)), None],
            cover.centre,
            |_, _| false,
        )
    }

    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stamps: Option<wgpu::RenderPassTimestampWrites>,
        pipeline: &ShadowPipeline,
        scenery: &Scenery,
        batches: &Batches,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shadow"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            timestamp_writes: stamps,
            ..Default::default()
        });
        pass.set_pipeline(&pipeline.solid);
        pass.set_bind_group(0, &self.group, &[]);
        scenery.models.bind(&mut pass);
        self.crowd.bind(&mut pass, 1);
        scenery.models.draw_uncoated(&mut pass, batches);
        scenery.models.draw_cars(&mut pass, batches);
        scenery.models.draw_tree_shades(&mut pass, &batches.trees);
        if let Some(leaves) = &pipeline.leaves {
            pass.set_pipeline(leaves);
            scenery.models.draw_trees(&mut pass, &batches.trees);
        }
    }
}

/// The ground that the maps cover: ahead of a perspective eye and some way behind it, for the mirror; all of a parallel
/// picture.
fn covers(to_sun: Vec3, optics: &Optics) -> [Cover; 3] {
    let ahead = optics.camera.forward.with_z(0.0).normalize_or_zero();
    let ground = optics.camera.eye.with_z(0.0);
    match optics.parallel_m() {
        None => {
            let standing = |i: usize| {
                let (half_m, step_m) = (STANDING_M[i], STEP_M[i]);
                let centre = ((ground + ahead * (0.45 * half_m)) / step_m).round() * step_m;
                Cover { to_sun, centre, half_m }
            };
            let moving = Cover { to_sun, centre: ground + ahead * (0.5 * MOVING_M), half_m: MOVING_M };
            [moving, standing(0), standing(1)]
        }
        Some(half_m) => [Cover { to_sun, centre: ground, half_m: half_m * 1.2 }; 3],
    }
}

impl Cover {
    fn view(&self) -> Mat4 {
        let up = if self.to_sun.z.abs() > 0.99 { Vec3::Y } else { Vec3::Z };
        rh::view::look_to_mat4(Vec3::ZERO, -self.to_sun, up)
    }

    fn texel_m(&self, size: u32) -> f32 {
        2.0 * self.half_m / size as f32
    }

    /// World to map.
    fn clip_from_world(&self, size: u32) -> Mat4 {
        self.lens(size) * self.view()
    }

    /// The sun's view to the map. The centre is moved to a whole texel, so that edges of shadows do not crawl while driving.
    fn lens(&self, size: u32) -> Mat4 {
        let view = self.view();
        let centre = view.transform_point3(self.centre);
        let texel = self.texel_m(size);
        let [x, y] = [centre.x, centre.y].map(|c| (c / texel).round() * texel);
        let h = self.half_m;
        let (near, far) = (-centre.z - h - HEIGHT_M, -centre.z + h + HEIGHT_M);
        rh::proj::directx::orthographic(x - h, x + h, y - h, y + h, near, far)
    }

    fn touches(&self, centre: Vec3, radius_m: f32) -> bool {
        let view = self.view();
        let off = (view.transform_point3(centre) - view.transform_point3(self.centre)).abs();
        off.x.max(off.y) < self.half_m + radius_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Lens};

    const TO_SUN: Vec3 = Vec3::new(0.48, 0.36, 0.8);

    fn optics(eye: Vec3, forward: Vec3, lens: Lens) -> Optics {
        let up = if forward.z.abs() > 0.5 { Vec3::Y } else { Vec3::Z };
        Optics::new(&Camera { eye, forward, up, lens }, [640, 360])
    }

    #[test]
    fn the_map_moves_by_whole_texels() {
        let lens = Lens::Perspective { fov_x_rad: 1.1 };
        let light = |x: f32| {
            let [moving, ..] = covers(TO_SUN, &optics(Vec3::new(x, 0.0, 1.2), Vec3::X, lens));
            moving.clip_from_world(1024)
        };
        let still = Vec3::new(20.0, 3.0, 0.0);
        for step in 1..50 {
            let moved = (light(step as f32 * 0.37).project_point3(still) - light(0.0).project_point3(still)) * 512.0;
            for texels in [moved.x, moved.y] {
                assert!((texels - texels.round()).abs() < 0.02, "moved by {texels} texels");
            }
        }
    }

    #[test]
    fn a_picture_in_plan_is_covered_whole() {
        let plan = optics(Vec3::new(10.0, 5.0, 400.0), Vec3::NEG_Z, Lens::Parallel { half_extent_m: 50.0 });
        for cover in covers(TO_SUN, &plan) {
            for corner in [Vec3::new(95.0, 55.0, 0.0), Vec3::new(-75.0, -45.0, 0.0)] {
                let clip = cover.clip_from_world(1024).project_point3(corner);
                assert!(clip.x.abs() <= 1.0 && clip.y.abs() <= 1.0 && (0.0..=1.0).contains(&clip.z), "{clip}");
                assert!(cover.touches(corner, 0.0));
            }
        }
    }

    #[test]
    fn what_stands_is_drawn_anew_only_every_few_metres() {
        let lens = Lens::Perspective { fov_x_rad: 1.1 };
        for (layer, most) in [(1, 10), (2, 4)] {
            let mut places: Vec<Cover> = Vec::new();
            for decimetre in 0..1000 {
                let covers = covers(TO_SUN, &optics(Vec3::new(decimetre as f32 * 0.1, 0.0, 1.2), Vec3::X, lens));
                if places.last() != Some(&covers[layer]) {
                    places.push(covers[layer]);
                }
            }
            assert!(places.len() <= most, "{} maps in 100 m", places.len());
        }
    }
}
