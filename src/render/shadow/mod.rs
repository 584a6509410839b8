//! First pass: shadow maps. In: cars and trees. Out: depth maps seen from the sun.
//!
//! One map holds moving objects (cars) and is drawn every frame around the camera. Two hold static objects (trees),
//! near and far; they follow the camera in steps. Their next map is drawn onto a spare layer, a part in each frame,
//! while the old one is still in use: a forest has thousands of vertices, and no frame should wait for all of them. If
//! no map can be used (at first, under another sun, after a jump of the camera), one is drawn whole at once. All maps
//! move by whole texels: the edges of shadows stay on the ground while the camera drives, and a new map has the same
//! shadows as the old one where they overlap.

mod cover;

use super::{
    device::{
        cost::{CountedPass, PassCost},
        layout::{Light, mesh_buffers, person_buffers},
        pipeline::{DEPTH, PipelineBuilder, PipelineDesc},
        shader::ShaderFault,
        targets::uniform_buffer,
        timing::{PassTimings, TimedPass},
    },
    instances::{InstanceCollector, SceneContents, Visibility},
    level_of_detail::{CarDetail, DetailShares, InstanceBatches, TreeDetail},
    models::ModelMesh,
    quality::Quality,
    static_meshes::StaticMeshes,
    view_projection::ViewFrustum,
};
use crate::scene::View;
use cover::{STEP_M, ShadowCover, covers};
use glam::Vec3;

/// Level of the trees in the near and the far map, where leaf cards cast shadows.
const SHADES: [TreeDetail; 2] = [TreeDetail::Near, TreeDetail::Mid];
/// Texel width from which cars cast the shadow of their far level, where shadows are not fine, m.
const FAR_M: f32 = 0.025;
/// Texel width from which all cars cast the shadow of their coarse shape, m.
const COARSE_M: f32 = 0.05;
/// Texel width from which cars cast the shadow of their outline, m.
const PLAN_M: f32 = 0.16;
/// Number of frames over which a map of static objects is drawn.
const PARTS: usize = 12;
/// Maximum lag of such a map, in steps of its grid: enough for 250 km/h at 60 frames a second and for 60 km/h at 15.
const MOST_STEPS: f32 = 2.5;
/// Number of layers: moving objects, near and far static objects, spare.
const LAYERS: u32 = 4;

/// Pipelines of the pass; created anew when shaders are reloaded.
#[derive(Debug)]
pub struct ShadowPipeline {
    solid: wgpu::RenderPipeline,
    person: wgpu::RenderPipeline,
    /// Pipeline for leaf cards; `None` if trees cast the shadows of solid shapes.
    leaves: Option<wgpu::RenderPipeline>,
}

/// Shadow pass with its maps.
#[derive(Debug)]
pub struct ShadowPass {
    layout: wgpu::PipelineLayout,
    maps: wgpu::TextureView,
    /// Layers of the maps; the first one holds the moving objects.
    layers: [ShadowLayer; LAYERS as usize],
    /// Near and far map of static objects.
    standing: [StaticShadowMap; 2],
    /// Index of the unused layer.
    spare: usize,
    next: Option<PendingShadowMap>,
    size: u32,
    /// True if leaf cards cast shadows with gaps; otherwise solid shapes do, at a tenth of the work.
    fine: bool,
}

/// Map of static objects in use.
#[derive(Clone, Copy, Debug)]
struct StaticShadowMap {
    layer: usize,
    /// Ground that it covers; `None` before it has been drawn.
    cover: Option<ShadowCover>,
}

/// Map that is being drawn and will replace another.
#[derive(Debug)]
struct PendingShadowMap {
    /// Index of the static map that it will replace.
    place: usize,
    cover: ShadowCover,
    batches: InstanceBatches,
    /// Number of parts that have been drawn.
    done: usize,
}

/// Pass to be drawn in this frame.
struct ShadowWork {
    layer: usize,
    batches: InstanceBatches,
    /// True to clear the map first, false to add to it.
    clear: bool,
    /// Ground whose buildings are drawn.
    buildings: Option<ShadowCover>,
}

/// Transforms with which the other passes look up shadows.
#[derive(Clone, Copy, Debug)]
pub struct ShadowLookup {
    /// Rows of the rotation from the world into the sun's view.
    pub rows: [Vec3; 3],
    /// Scale from the sun's view to each map: moving, near static, far static.
    pub scale: [Vec3; 3],
    /// Offset added after the scale, by map.
    pub shift: [Vec3; 3],
    /// Layer in the maps' texture, by map.
    pub layer: [usize; 3],
    /// Width of a texel, m, by map.
    pub texel_m: [f32; 3],
    /// Number of texels along a map's side.
    pub size: u32,
}

#[derive(Debug)]
struct ShadowLayer {
    view: wgpu::TextureView,
    uniform: wgpu::Buffer,
    group: wgpu::BindGroup,
    instances: InstanceCollector,
}

impl ShadowPass {
    /// Creates maps of the size and fineness that the quality asks for.
    pub fn new(device: &wgpu::Device, meshes: &StaticMeshes, quality: &Quality) -> Self {
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
            size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: LAYERS },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let layer = |index| {
            let uniform = uniform_buffer(device, "light", size_of::<Light>());
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("light"),
                layout: &group_layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                    wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&meshes.leaves) },
                    wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(&sampler) },
                ],
            });
            let view = texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: index,
                array_layer_count: Some(1),
                ..Default::default()
            });
            ShadowLayer { view, uniform, group, instances: InstanceCollector::new(device, &meshes.forest, 64) }
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
            layers: [0, 1, 2, 3].map(layer),
            standing: [1, 2].map(|layer| StaticShadowMap { layer, cover: None }),
            spare: 3,
            next: None,
            size,
            fine: quality.fine,
        }
    }

    /// Creates the pass's pipelines.
    ///
    /// # Errors
    /// A mistake in a shader.
    pub fn pipeline(&self, builder: &PipelineBuilder) -> Result<ShadowPipeline, ShaderFault> {
        let desc = PipelineDesc {
            program: "shadow",
            layout: &self.layout,
            buffers: &mesh_buffers(),
            colour: None,
            depth: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::LessEqual),
                stencil: Default::default(),
                // Against shadow acne; the receiver's offset along its normal does the rest (`light.wgsl`).
                bias: wgpu::DepthBiasState { constant: 0, slope_scale: 1.5, clamp: 0.0 },
            }),
            cull: None,
            writes: wgpu::ColorWrites::ALL,
            samples: 1,
            cut_out: false,
            constants: &[],
        };
        let leaves = PipelineDesc { program: "leaf_shadow", cut_out: true, ..desc.clone() };
        let leaves = if self.fine { Some(builder.pipeline(&leaves)?) } else { None };
        let person = PipelineDesc { program: "person_shadow", buffers: &person_buffers(), ..desc.clone() };
        Ok(ShadowPipeline { solid: builder.pipeline(&desc)?, person: builder.pipeline(&person)?, leaves })
    }

    /// Returns all maps, for binding.
    pub fn maps(&self) -> &wgpu::TextureView {
        &self.maps
    }

    /// Discards the static maps, so that the next picture draws them anew.
    pub fn forget(&mut self) {
        self.next = None;
        self.standing.iter_mut().for_each(|map| map.cover = None);
    }

    /// Draws the shadow casters for the picture of a frustum, in a light from the direction `to_shining`.
    pub fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        timing: Option<&PassTimings>,
        pipeline: &ShadowPipeline,
        meshes: &StaticMeshes,
        view: &View,
        (to_shining, frustum): (Vec3, &ViewFrustum),
    ) -> (ShadowLookup, PassCost) {
        let wanted = covers(to_shining, frustum);
        let batches = self.layers[0].gather(meshes, view, wanted[0], None, (self.size, self.fine));
        let mut works = vec![ShadowWork { layer: 0, batches, clear: true, buildings: None }];
        works.extend((0..2).filter_map(|place| self.at_once(meshes, view, wanted[place + 1], place)));
        works.extend(self.part_of_next(meshes, view, [wanted[1], wanted[2]]));
        // One time for all: from the first pass's begin to the last one's end.
        let last = works.len() - 1;
        let mut cost = PassCost::default();
        for (number, work) in works.iter().enumerate() {
            let stamps = timing.and_then(|timing| timing.stamps(TimedPass::Shadow, [number == 0, number == last]));
            cost += self.layers[work.layer].draw(encoder, stamps, pipeline, meshes, work);
        }
        let [near, far] = self.standing;
        let used = [Some(wanted[0]), near.cover, far.cover].map(|cover| cover.expect("drawn above"));
        let lens = used.map(|cover| cover.lens(self.size));
        let rotation = used[0].view().transpose();
        let lights = ShadowLookup {
            rows: [rotation.x_axis, rotation.y_axis, rotation.z_axis].map(|row| row.truncate()),
            scale: lens.map(|lens| Vec3::new(lens.x_axis.x, lens.y_axis.y, lens.z_axis.z)),
            shift: lens.map(|lens| lens.w_axis.truncate()),
            layer: [0, near.layer, far.layer],
            texel_m: used.map(|cover| cover.texel_m(self.size)),
            size: self.size,
        };
        (lights, cost)
    }

    /// Returns the work for a whole static map, if the one in use no longer serves.
    fn at_once(&mut self, meshes: &StaticMeshes, view: &View, wanted: ShadowCover, place: usize) -> Option<ShadowWork> {
        let most_m = MOST_STEPS * STEP_M[place];
        let map = &mut self.standing[place];
        let serves = map.cover.is_some_and(|cover| cover.serves(&wanted, most_m));
        // A pending map from before must not replace a newer one.
        self.next.take_if(|next| next.place == place && !(serves && next.cover.serves(&wanted, most_m)));
        if serves {
            return None;
        }
        map.cover = Some(wanted);
        let layer = map.layer;
        let batches = self.layers[layer].gather(meshes, view, wanted, Some(self.shade(place)), (self.size, self.fine));
        Some(ShadowWork { layer, batches, clear: true, buildings: Some(wanted) })
    }

    /// Returns the work for one part of the map that will replace a lagging one, and replaces it after the last part.
    fn part_of_next(&mut self, meshes: &StaticMeshes, view: &View, wanted: [ShadowCover; 2]) -> Option<ShadowWork> {
        let lags = |place: &usize| self.standing[*place].cover != Some(wanted[*place]);
        if self.next.is_none()
            && let Some(place) = (0..2).find(lags)
        {
            let (cover, shade) = (wanted[place], self.shade(place));
            let batches = self.layers[self.spare].gather(meshes, view, cover, Some(shade), (self.size, self.fine));
            self.next = Some(PendingShadowMap { place, cover, batches, done: 0 });
        }
        let next = self.next.as_mut()?;
        let batches = InstanceBatches { trees: next.batches.part_of_trees(next.done, PARTS), ..Default::default() };
        let clear = next.done == 0;
        let work = ShadowWork { layer: self.spare, batches, clear, buildings: clear.then_some(next.cover) };
        next.done += 1;
        if next.done == PARTS {
            let map = &mut self.standing[next.place];
            map.cover = Some(next.cover);
            std::mem::swap(&mut map.layer, &mut self.spare);
            self.next = None;
        }
        Some(work)
    }

    /// Returns the level of detail of the trees that cast shadows in a static map.
    fn shade(&self, place: usize) -> TreeDetail {
        if self.fine { SHADES[place] } else { TreeDetail::Shade }
    }
}

/// Objects that cast shadows into a map, at one level of detail.
struct ShadowVisibility {
    cover: ShadowCover,
    car: CarDetail,
    tree: TreeDetail,
}

impl Visibility for ShadowVisibility {
    fn eye(&self) -> Vec3 {
        self.cover.centre
    }

    fn sees(&self, centre: Vec3, radius_m: f32) -> bool {
        self.cover.touches(centre, radius_m)
    }

    fn car_detail(&self, _: Vec3, _: f32) -> Option<CarDetail> {
        Some(self.car)
    }

    fn tree_levels(&self, centre: Vec3, radius_m: f32) -> DetailShares {
        [self.sees(centre, radius_m).then_some((self.tree, 1.0)), None]
    }

    fn shows_grass(&self, _: Vec3, _: f32) -> bool {
        false
    }
}

impl ShadowLayer {
    fn gather(
        &mut self,
        meshes: &StaticMeshes,
        view: &View,
        cover: ShadowCover,
        trees: Option<TreeDetail>,
        (size, fine): (u32, bool),
    ) -> InstanceBatches {
        let (queue, light) = (&meshes.queue, cover.clip_from_world(size));
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&Light { clip_from_world: light.to_cols_array_2d() }));
        let around = SceneContents { forest: trees.map(|_| &meshes.forest), ..Default::default() };
        let (cars, parked): (&[_], &[_]) = match trees {
            Some(_) => (&[], &[]),
            None => (&view.cars, &meshes.parked_cars),
        };
        let detail = trees.unwrap_or(TreeDetail::Shade);
        // If a texel is as wide as a pillar, the coarse shape has the same shadow.
        let car = match cover.texel_m(size) {
            texel_m if texel_m > PLAN_M => CarDetail::Plan,
            texel_m if texel_m > COARSE_M => CarDetail::Shade,
            texel_m if texel_m > FAR_M && !fine => CarDetail::Far,
            _ => CarDetail::Mid,
        };
        self.instances.gather(
            (&meshes.device, queue),
            &meshes.models,
            cars.iter().chain(parked),
            around,
            &ShadowVisibility { cover, car, tree: detail },
        )
    }

    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stamps: Option<wgpu::RenderPassTimestampWrites>,
        pipeline: &ShadowPipeline,
        meshes: &StaticMeshes,
        work: &ShadowWork,
    ) -> PassCost {
        let batches = &work.batches;
        let mut pass = CountedPass::new(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shadow"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.view,
                depth_ops: Some(wgpu::Operations {
                    load: if work.clear { wgpu::LoadOp::Clear(1.0) } else { wgpu::LoadOp::Load },
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: stamps,
            ..Default::default()
        }));
        pass.set_pipeline(&pipeline.solid);
        pass.set_bind_group(0, &self.group, &[]);
        meshes.models.bind(&mut pass);
        self.instances.bind(&mut pass, 1);
        meshes.models.draw_uncoated(&mut pass, batches);
        meshes.models.draw_cars(&mut pass, batches);
        if let Some(cover) = work.buildings {
            let touches = |piece: &ModelMesh| cover.touches(piece.centre, piece.radius_m);
            meshes.models.buildings.iter().for_each(|part| part.draw(&mut pass, touches));
        }
        meshes.models.draw_tree_shades(&mut pass, &batches.trees);
        meshes.models.draw_people(&mut pass, batches, &pipeline.person);
        if let Some(leaves) = &pipeline.leaves {
            pass.set_pipeline(leaves);
            meshes.models.draw_trees(&mut pass, &batches.trees);
        }
        pass.cost()
    }
}
