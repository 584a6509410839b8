//! Second and third pass: the scene in high dynamic range, once for the main camera, once for each mirror. In: cars,
//! trees, road and land, shadow maps, a camera. Out: a texture of light ([`HDR`](super::device::pipeline::HDR)), one
//! sample per pixel.

use super::{
    device::{
        cost::{CountedPass, PassCost},
        layout::Frame,
        pipeline::PipelineBuilder,
        shader::ShaderFault,
        targets::{RenderTargets, uniform_buffer},
    },
    headlamps::beams,
    instances::{InstanceCollector, SceneContents, Visibility},
    level_of_detail::{CarDetail, DetailShares, InstanceBatches, TreeDetail},
    materials::{AFAR_M, MaterialPipelines, MaterialsDesc, PipelineWeather},
    models::ModelMesh,
    quality::Quality,
    shadow::ShadowLookup,
    sky::{
        atmosphere::Sky,
        sky_pass::{self, SkyPass},
    },
    static_meshes::StaticMeshes,
    view_projection::ViewFrustum,
    wall_horizon::WallHorizon,
};
use crate::scene::{View, ViewKind, WiperMotion};
use glam::Vec3;

/// Visibility of the ego in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EgoVisibility {
    /// From outside, like any other car.
    Outside,
    /// From the driver's seat.
    Inside,
    /// Not visible at all.
    Nowhere,
}

/// Bind group layouts and samplers of the scene's pipelines.
#[derive(Debug)]
pub struct SceneBindings {
    group: wgpu::BindGroupLayout,
    pipeline: wgpu::PipelineLayout,
    sky_pipeline: wgpu::PipelineLayout,
    shadow_sampler: wgpu::Sampler,
    grain_sampler: wgpu::Sampler,
    leaf_sampler: wgpu::Sampler,
}

/// Inputs of one picture of the scene.
#[derive(Clone, Copy)]
pub struct SceneInputs<'a> {
    /// Pipelines of the scene.
    pub materials: &'a MaterialPipelines,
    /// Static meshes and textures.
    pub meshes: &'a StaticMeshes,
    /// Objects, light and weather of the moment.
    pub view: &'a View,
    /// Camera and picture size.
    pub frustum: &'a ViewFrustum,
    /// Transforms for looking up shadows.
    pub lights: &'a ShadowLookup,
    /// Light of the hour.
    pub sky: &'a Sky,
    /// Light and weather that the pipelines are made for.
    pub weather: PipelineWeather,
}

/// One picture of the scene, with its own camera, instances and targets.
#[derive(Debug)]
pub struct ScenePass {
    label: &'static str,
    samples: u32,
    grass_m: f32,
    /// Factor on the size of trees, see [`Quality::detail`].
    detail: f32,
    frame: wgpu::Buffer,
    group: wgpu::BindGroup,
    clouds: wgpu::BindGroup,
    instances: InstanceCollector,
    targets: RenderTargets,
}

impl SceneBindings {
    /// Creates the bindings of `common.wgsl`.
    pub fn new(device: &wgpu::Device, quality: &Quality) -> Self {
        use wgpu::{BindingType, SamplerBindingType, ShaderStages, TextureSampleType, TextureViewDimension};
        let texture =
            |sample_type, view_dimension| BindingType::Texture { sample_type, view_dimension, multisampled: false };
        let uniform = BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let entries = [
            uniform,
            texture(TextureSampleType::Depth, TextureViewDimension::D2Array),
            BindingType::Sampler(SamplerBindingType::Comparison),
            texture(TextureSampleType::Float { filterable: true }, TextureViewDimension::D2),
            BindingType::Sampler(SamplerBindingType::Filtering),
            uniform,
            uniform,
            texture(TextureSampleType::Float { filterable: true }, TextureViewDimension::D2),
            BindingType::Sampler(SamplerBindingType::Filtering),
            texture(TextureSampleType::Float { filterable: true }, TextureViewDimension::D2Array),
            BindingType::Sampler(SamplerBindingType::Filtering),
            texture(TextureSampleType::Float { filterable: true }, TextureViewDimension::D2Array),
            texture(TextureSampleType::Float { filterable: true }, TextureViewDimension::D2),
        ];
        let entries: Vec<_> = entries
            .into_iter()
            .enumerate()
            .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
                binding: binding as u32,
                visibility: ShaderStages::VERTEX_FRAGMENT,
                ty,
                count: None,
            })
            .collect();
        let group = device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("scene"), entries: &entries });
        let between = if quality.fine { wgpu::MipmapFilterMode::Linear } else { wgpu::MipmapFilterMode::Nearest };
        Self {
            pipeline: device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("scene"),
                bind_group_layouts: &[Some(&group)],
                immediate_size: 0,
            }),
            sky_pipeline: device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("sky"),
                bind_group_layouts: &[Some(&group), Some(&sky_pass::clouds_layout(device))],
                immediate_size: 0,
            }),
            group,
            shadow_sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("shadow"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                compare: Some(wgpu::CompareFunction::LessEqual),
                ..Default::default()
            }),
            grain_sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("grain"),
                address_mode_u: wgpu::AddressMode::Repeat,
                address_mode_v: wgpu::AddressMode::Repeat,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: between,
                anisotropy_clamp: quality.anisotropy.max(1),
                ..Default::default()
            }),
            leaf_sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("leaves"),
                address_mode_u: wgpu::AddressMode::Repeat,
                address_mode_v: wgpu::AddressMode::Repeat,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: between,
                ..Default::default()
            }),
        }
    }
}

impl SceneBindings {
    /// Creates all pipelines of the scene, for this light and weather.
    ///
    /// # Errors
    /// A mistake in a shader.
    pub fn materials(
        &self,
        builder: &PipelineBuilder,
        quality: &Quality,
        weather: PipelineWeather,
    ) -> Result<MaterialPipelines, ShaderFault> {
        MaterialsDesc { layout: &self.pipeline, sky_layout: &self.sky_pipeline, quality, weather }.pipelines(builder)
    }
}

impl ScenePass {
    /// Creates a picture that reads the shadow maps `shadows` and the light of `air`.
    pub fn new(
        label: &'static str,
        meshes: &StaticMeshes,
        bindings: &SceneBindings,
        shadows: &wgpu::TextureView,
        air: &SkyPass,
        quality: &Quality,
    ) -> Self {
        let device = &meshes.device;
        let frame = uniform_buffer(device, label, size_of::<Frame>());
        let resources = [
            frame.as_entire_binding(),
            wgpu::BindingResource::TextureView(shadows),
            wgpu::BindingResource::Sampler(&bindings.shadow_sampler),
            wgpu::BindingResource::TextureView(&meshes.grain),
            wgpu::BindingResource::Sampler(&bindings.grain_sampler),
        ];
        let leaves = [
            wgpu::BindingResource::TextureView(&meshes.leaves),
            wgpu::BindingResource::Sampler(&bindings.leaf_sampler),
            wgpu::BindingResource::TextureView(&meshes.far_trees),
            wgpu::BindingResource::TextureView(&meshes.street_light),
        ];
        let entries: Vec<_> = (0..)
            .zip(resources.into_iter().chain(air.resources()).chain(leaves))
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(label),
            layout: &bindings.group,
            entries: &entries,
        });
        Self {
            label,
            samples: quality.msaa,
            grass_m: quality.grass_m,
            detail: quality.detail,
            group,
            clouds: air.clouds().clone(),
            frame,
            instances: InstanceCollector::new(device, &meshes.forest, 64),
            targets: RenderTargets::new(device, label, [1, 1], quality.msaa),
        }
    }

    /// Resizes the targets to `size` pixels. Returns true if they are new.
    pub fn fit(&mut self, device: &wgpu::Device, size: [u32; 2]) -> bool {
        let stale = self.targets.size != size;
        if stale {
            self.targets = RenderTargets::new(device, self.label, size, self.samples);
        }
        stale
    }

    /// Returns the picture, for the tone-mapping pass.
    pub fn light(&self) -> &wgpu::TextureView {
        &self.targets.light
    }

    /// Draws the scene, except for the `hidden` area: left, top, width and height in pixels.
    pub fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        stamps: Option<wgpu::RenderPassTimestampWrites>,
        scene: &SceneInputs,
        ego: EgoVisibility,
        hidden: Option<[u32; 4]>,
    ) -> PassCost {
        let SceneInputs { materials, meshes, frustum, .. } = *scene;
        let frame = frame(scene);
        meshes.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame));
        let visible = PictureVisibility {
            frustum,
            horizon: WallHorizon::new(frustum, &meshes.walls),
            grass_m: self.grass_m,
            detail: self.detail,
            samples: self.samples,
        };
        let batches = self.gather(scene, ego, &visible);
        let models = &meshes.models;
        let seen = |piece: &ModelMesh| visible.sees_piece(piece);
        let instances = &self.instances;
        let clouds = &self.clouds;
        let draw_road = |pass: &mut CountedPass| {
            models.road.draw(pass, seen);
            models.route_line.draw_part(pass, scene.view.route_line.clone());
        };
        let mut pass = self.targets.begin(encoder, self.label, stamps);
        let pass = &mut pass;
        pass.set_bind_group(0, &self.group, &[]);
        models.bind(pass);
        instances.bind(pass, 1);
        let from_above = frustum.from_above();
        let rain = materials.rain.as_ref().filter(|_| !from_above);
        if let Some(rain) = rain {
            pass.set_pipeline(&rain.mirrored_sky);
            pass.draw(0..3, 0..1);
            pass.set_pipeline(&rain.mirrored_car);
            models.draw_mirrored(pass, &batches);
            pass.set_pipeline(&rain.streak);
            instances.bind(pass, 0);
            pass.draw(0..6, batches.streaks.clone());
            models.bind(pass);
            instances.bind(pass, 1);
            pass.set_pipeline(&rain.nothing);
            pass.draw(0..3, 0..1);
        }
        if let Some([left, top, width, height]) = hidden {
            pass.set_pipeline(&materials.bodies.hidden);
            pass.set_scissor_rect(left, top, width, height);
            pass.draw(0..3, 0..1);
            let [width, height] = self.targets.size;
            pass.set_scissor_rect(0, 0, width, height);
        }
        if let Some(rain) = rain {
            // Before all objects: through a wet road one would see their feet and foundations below it.
            pass.set_pipeline(&rain.road_depth);
            draw_road(pass);
        }
        // Near objects first, so that hidden pixels are not shaded; the sky last, where nothing else is.
        pass.set_pipeline(&materials.bodies.uncoated);
        models.draw_uncoated(pass, &batches);
        pass.set_pipeline(&materials.bodies.car);
        models.draw_cars(pass, &batches);
        models.posts.draw(pass, seen);
        models.lamp.draw(pass, batches.lamps.clone());
        models.draw_people(pass, &batches, &materials.bodies.person);
        for (pipeline, part) in materials.bodies.building.iter().zip(&models.buildings) {
            pass.set_pipeline(pipeline);
            part.draw_nearest_first(pass, frustum.camera.eye, seen);
        }
        pass.set_pipeline(&materials.plants.cover);
        models.draw_trees(pass, &batches.trees);
        pass.set_pipeline(&materials.plants.tree);
        models.draw_trees(pass, &batches.trees);
        let which = usize::from(from_above);
        for pipeline in [&materials.plants.far_cover[which], &materials.plants.impostor[which]] {
            pass.set_pipeline(pipeline);
            models.draw_far_trees(pass, &batches.trees, from_above);
        }
        pass.set_pipeline(&materials.plants.grass);
        models.tuft.draw(pass, batches.tufts.clone());
        pass.set_pipeline(&materials.ground.road[which]);
        draw_road(pass);
        let afar = from_above && frustum.pixels(frustum.camera.eye, AFAR_M) <= 1.0;
        pass.set_pipeline(&materials.ground.land[usize::from(afar)]);
        models.land.draw(pass, seen);
        pass.set_pipeline(&materials.ground.contact);
        instances.bind(pass, 0);
        pass.draw(0..6, batches.cars.clone());
        pass.set_pipeline(&materials.ground.root);
        pass.draw(0..6, batches.roots.clone());
        pass.set_pipeline(&materials.sky);
        pass.set_bind_group(1, clouds, &[]);
        pass.draw(0..3, 0..1);
        // Windows last, over everything behind them.
        pass.set_pipeline(&materials.bodies.glass);
        models.bind(pass);
        instances.bind(pass, 1);
        models.draw_glass(pass, &batches);
        if let Some(rain) = rain {
            pass.set_pipeline(&rain.spray);
            instances.bind(pass, 0);
            pass.draw(0..6, batches.spray.clone());
            pass.set_pipeline(&rain.drops);
            pass.draw(0..6, 0..falling_drops(scene.view.rain_mmph));
            pass.set_pipeline(&rain.windscreen);
            models.bind(pass);
            instances.bind(pass, 1);
            models.draw_windscreen(pass, &batches);
        }
        pass.cost()
    }

    /// Collects the cars, trees and tufts of grass in the picture.
    fn gather(&mut self, scene: &SceneInputs, ego: EgoVisibility, visible: &PictureVisibility) -> InstanceBatches {
        let SceneInputs { meshes, view, .. } = *scene;
        let cars =
            view.cars.iter().chain(&meshes.parked_cars).filter(|car| ego == EgoVisibility::Outside || !car.is_ego);
        let inside = view.seat.as_ref().filter(|_| ego == EgoVisibility::Inside);
        self.instances.gather(
            (&meshes.device, &meshes.queue),
            &meshes.models,
            cars,
            SceneContents {
                forest: Some(&meshes.forest),
                inside,
                lamps: &view.lamps,
                mirrored_lamps: &view.mirrored_lamps,
                spray: &view.spray,
            },
            visible,
        )
    }
}

/// Objects that a camera shows: those in its picture which walls do not hide.
struct PictureVisibility<'a> {
    frustum: &'a ViewFrustum,
    horizon: WallHorizon,
    grass_m: f32,
    detail: f32,
    samples: u32,
}

impl PictureVisibility<'_> {
    /// Checks whether any part of a static mesh may be seen.
    fn sees_piece(&self, piece: &ModelMesh) -> bool {
        let [low, high] = piece.bounds;
        self.frustum.sees(piece.centre, piece.radius_m) && !self.horizon.hides(low, high)
    }
}

impl Visibility for PictureVisibility<'_> {
    fn eye(&self) -> Vec3 {
        self.frustum.camera.eye
    }

    fn sees(&self, centre: Vec3, radius_m: f32) -> bool {
        self.frustum.sees(centre, radius_m) && !self.horizon.hides(centre - radius_m, centre + radius_m)
    }

    fn car_detail(&self, centre: Vec3, radius_m: f32) -> Option<CarDetail> {
        CarDetail::seen(self.frustum, centre, radius_m)
    }

    fn tree_levels(&self, centre: Vec3, radius_m: f32) -> DetailShares {
        match self.sees(centre, radius_m) {
            true => TreeDetail::shares(self.frustum.pixels(centre, radius_m) * self.detail, self.samples),
            false => Default::default(),
        }
    }

    fn shows_grass(&self, centre: Vec3, radius_m: f32) -> bool {
        self.eye().distance_squared(centre) < self.grass_m * self.grass_m && self.sees(centre, radius_m)
    }
}

/// Returns the number of drops that stand for all those around the eye: as many more in stronger rain as its extinction is more.
fn falling_drops(rain_mmph: f32) -> u32 {
    (700.0 * rain_mmph.powf(0.63)).min(6000.0) as u32
}

/// Radiance of a dipped head lamp, as pictures show it.
const HEAD_LAMP: f32 = 4.0;

fn frame(scene: &SceneInputs) -> Frame {
    let SceneInputs { view, frustum, lights, sky, .. } = *scene;
    let perspective = if frustum.parallel_m().is_some() { 0.0 } else { 1.0 };
    let [right, up] = frustum.spread();
    Frame {
        clip_from_world: frustum.clip_from_world().to_cols_array_2d(),
        light_from_world: lights.rows.map(|row| row.extend(0.0).to_array()),
        light_scale: lights.scale.map(|scale| scale.extend(0.0).to_array()),
        light_shift: std::array::from_fn(|i| lights.shift[i].extend(lights.layer[i] as f32).to_array()),
        eye: frustum.camera.eye.extend(perspective).to_array(),
        forward: frustum.camera.forward.extend(view.wind_mps).to_array(),
        right: right.extend(0.0).to_array(),
        up: up.extend(0.0).to_array(),
        to_sun_time: sky.to_shining.extend(view.time_s).to_array(),
        shadow: Vec3::from(lights.texel_m).extend(lights.size as f32).to_array(),
        lamps: [
            if view.headlamps.is_empty() { 0.0 } else { HEAD_LAMP },
            if view.kind == ViewKind::Birdseye { sky.lamps_in_plans() } else { 1.0 },
            // Exposed for the moon: what lamps light would be white, and the programs of road and land leave their light out.
            if frustum.from_above() { 0.0 } else { sky.one_lux },
            scene.meshes.lamp_rise_m,
        ],
        motion: view.velocity_mps.extend(view.rain_mmph).to_array(),
        wipers: WiperMotion::in_rain(view.rain_mmph)
            .map_or([1.0; 4], |wipers| [wipers.period_s as f32, wipers.sweep_s as f32, 0.0, 0.0]),
        street_lamps: scene.meshes.lamp_place,
        beams: beams(view, frustum, scene.weather.beams),
    }
}
