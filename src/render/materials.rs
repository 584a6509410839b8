//! Pipelines of the scene by material. In: the scene's bindings, the quality. Out: [`MaterialPipelines`]. Each has a
//! short shader of its own: on software rendering a branch costs time even if no pixel of a draw takes it.

use super::{
    device::{
        layout::{instance_buffer, mesh_buffers, person_buffers},
        pipeline::{DEPTH, HDR, PipelineBuilder, PipelineDesc},
        shader::ShaderFault,
    },
    quality::Quality,
};
use crate::scene::cockpit::wipers;

/// Width of a pixel from which blades of grass are no longer visible, m.
pub(super) const AFAR_M: f32 = 0.075;

/// Variant for a parallel lens from above.
const FROM_ABOVE: (&str, f64) = ("FROM_ABOVE", 1.0);

/// Blending of a surface over what it mirrors, of which it lets the share in its alpha channel through.
const OVER_MIRRORED: wgpu::BlendState = wgpu::BlendState {
    color: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::SrcAlpha,
        operation: wgpu::BlendOperation::Add,
    },
    alpha: wgpu::BlendComponent::REPLACE,
};

/// Blending of light that is added to a picture.
const ADDED: wgpu::BlendState = wgpu::BlendState {
    color: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    },
    alpha: wgpu::BlendComponent::OVER,
};

/// All pipelines of the scene.
#[derive(Debug)]
pub struct MaterialPipelines {
    pub(super) bodies: BodyPipelines,
    pub(super) ground: GroundPipelines,
    pub(super) plants: PlantPipelines,
    pub(super) sky: wgpu::RenderPipeline,
    /// Pipelines for rain alone.
    pub(super) rain: Option<RainPipelines>,
}

/// The area hidden by the mirror, cars, people, uncoated parts (posts, wheels), buildings, and windows of vehicles.
#[derive(Debug)]
pub(super) struct BodyPipelines {
    pub hidden: wgpu::RenderPipeline,
    pub car: wgpu::RenderPipeline,
    pub person: wgpu::RenderPipeline,
    pub uncoated: wgpu::RenderPipeline,
    /// Walls with their openings, and all else of buildings.
    pub building: [wgpu::RenderPipeline; 2],
    pub glass: wgpu::RenderPipeline,
}

/// Road and land, and the shade at the foot of objects on them. Road has a second pipeline for a parallel lens from
/// above.
#[derive(Debug)]
pub(super) struct GroundPipelines {
    pub road: [wgpu::RenderPipeline; 2],
    /// Land; the second is for a parallel lens from above where a pixel is at least [`AFAR_M`] wide.
    pub land: [wgpu::RenderPipeline; 2],
    pub contact: wgpu::RenderPipeline,
    pub root: wgpu::RenderPipeline,
}

/// Near and far trees, and grass: depth first (`cover`), then colour where the depth is equal. Far trees have a second
/// pipeline for a parallel lens from above.
#[derive(Debug)]
pub(super) struct PlantPipelines {
    pub cover: wgpu::RenderPipeline,
    pub tree: wgpu::RenderPipeline,
    pub far_cover: [wgpu::RenderPipeline; 2],
    pub impostor: [wgpu::RenderPipeline; 2],
    pub grass: wgpu::RenderPipeline,
}

/// Pipelines for rain: what the wet road mirrors (sky and trees, bodies, streaks of lamps, then depth as if nothing had been drawn), the depth of
/// the road, drops in the air and on the windscreen, spray.
#[derive(Debug)]
pub(super) struct RainPipelines {
    pub mirrored_sky: wgpu::RenderPipeline,
    pub mirrored_car: wgpu::RenderPipeline,
    pub streak: wgpu::RenderPipeline,
    pub nothing: wgpu::RenderPipeline,
    pub road_depth: wgpu::RenderPipeline,
    pub drops: wgpu::RenderPipeline,
    pub windscreen: wgpu::RenderPipeline,
    pub spray: wgpu::RenderPipeline,
}

/// Inputs of the pipelines.
pub(super) struct MaterialsDesc<'a> {
    pub layout: &'a wgpu::PipelineLayout,
    pub sky_layout: &'a wgpu::PipelineLayout,
    pub quality: &'a Quality,
    pub weather: PipelineWeather,
}

/// Light and weather that pipelines are made for: by day and when it is dry, lamps and water would cost time without being visible.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PipelineWeather {
    /// Number of beams of headlamps that light the scene, 0 by day.
    pub beams: usize,
    /// True if it rains and the road mirrors.
    pub is_wet: bool,
}

impl MaterialsDesc<'_> {
    /// Creates all pipelines, in parallel if the builder allows it.
    ///
    /// # Errors
    /// A mistake in a shader.
    pub fn pipelines(&self, builder: &PipelineBuilder) -> Result<MaterialPipelines, ShaderFault> {
        let ((bodies, ground), (plants, sky)) = builder.both(
            || builder.both(|| self.bodies(builder), || self.ground(builder)),
            || builder.both(|| self.plants(builder), || self.sky(builder)),
        );
        let rain = if self.weather.is_wet { Some(self.rain(builder)?) } else { None };
        Ok(MaterialPipelines { bodies: bodies?, ground: ground?, plants: plants?, sky: sky?, rain })
    }

    fn bodies(&self, builder: &PipelineBuilder) -> Result<BodyPipelines, ShaderFault> {
        let (mesh, person, soft, beams) = (mesh_buffers(), person_buffers(), self.soft(), self.beams());
        let lit = [soft, beams];
        let solid = self.solid(&mesh, &lit);
        let [hidden, car, person, uncoated, walls, roofs, glass] = builder.pipelines([
            self.mask(&[]),
            PipelineDesc { program: "car", ..solid.clone() },
            PipelineDesc { program: "person", buffers: &person, ..solid.clone() },
            PipelineDesc { program: "car", constants: &[soft, beams, ("COATED", 0.0)], ..solid.clone() },
            PipelineDesc { program: "building", ..solid.clone() },
            PipelineDesc { program: "building", constants: &[soft, beams, ("OPENINGS", 0.0)], ..solid.clone() },
            PipelineDesc {
                program: "car",
                colour: Some((HDR, Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING))),
                depth: Some(depth(false, Default::default())),
                constants: &[soft, beams, ("SEEN_THROUGH", 1.0)],
                ..solid
            },
        ])?;
        Ok(BodyPipelines { hidden, car, person, uncoated, building: [walls, roofs], glass })
    }

    fn ground(&self, builder: &PipelineBuilder) -> Result<GroundPipelines, ShaderFault> {
        let (mesh, instances) = (mesh_buffers(), [Some(instance_buffer())]);
        let (soft, beams) = (self.soft(), self.beams());
        let lit = [soft, beams];
        let afar = ("AFAR_M", f64::from(AFAR_M));
        let solid = self.solid(&mesh, &lit);
        let above = wgpu::DepthBiasState { constant: 64, slope_scale: 2.0, clamp: 0.0 };
        let shade = |program, bias| PipelineDesc {
            program,
            buffers: &instances,
            colour: Some((HDR, Some(wgpu::BlendState::ALPHA_BLENDING))),
            depth: Some(depth(false, bias)),
            cull: None,
            constants: &[],
            ..solid.clone()
        };
        let wet = ("WET", f64::from(u8::from(self.weather.is_wet)));
        let road = PipelineDesc {
            program: "road",
            // A wet road lets some of what it mirrors through: its uppermost layer alone, of which the depth is drawn before.
            colour: Some((HDR, self.weather.is_wet.then_some(OVER_MIRRORED))),
            depth: Some(if self.weather.is_wet { equal_depth() } else { depth(true, Default::default()) }),
            constants: &[soft, beams, wet],
            ..solid.clone()
        };
        let [road, road_from_above, land, land_from_above, contact, root] = builder.pipelines([
            road,
            PipelineDesc { program: "road", constants: &[soft, FROM_ABOVE], ..solid.clone() },
            PipelineDesc { program: "land", constants: &[soft, beams, afar], ..solid.clone() },
            PipelineDesc { program: "land", constants: &[soft, FROM_ABOVE, afar, ("AFAR", 1.0)], ..solid.clone() },
            shade("contact", above),
            // The ground under the shade is not exactly the plane at the tree: the shade is drawn 1.8 % of the distance
            // nearer.
            shade("root", wgpu::DepthBiasState { constant: 150_000, ..above }),
        ])?;
        Ok(GroundPipelines { road: [road, road_from_above], land: [land, land_from_above], contact, root })
    }

    fn plants(&self, builder: &PipelineBuilder) -> Result<PlantPipelines, ShaderFault> {
        let (mesh, soft, beams) = (mesh_buffers(), self.soft(), self.beams());
        let samples = ("SAMPLES", f64::from(self.quality.msaa));
        let (lit, samples_alone) = ([soft, beams], [samples]);
        let solid = self.solid(&mesh, &lit);
        // Shaders for OpenGL cannot write a mask of samples: they decide on each sample instead.
        let [near_cover, far_cover] = match builder.device.adapter_info().backend {
            wgpu::Backend::Gl => ["cover_by_sample", "far_cover_by_sample"],
            _ => ["cover", "far_cover"],
        };
        let cover = PipelineDesc {
            program: near_cover,
            writes: wgpu::ColorWrites::empty(),
            cull: None,
            constants: &samples_alone,
            ..solid.clone()
        };
        let covered = PipelineDesc { depth: Some(equal_depth()), cull: None, ..solid.clone() };
        let cut_out = self.quality.msaa > 1;
        let least = ("LEAST_COVER", if cut_out { 0.1 } else { 0.5 });
        let reach = ("REACH_M", f64::from(self.quality.grass_m));
        let [cover, tree, far_cover, far_cover_from_above, impostor, impostor_from_above, grass] =
            builder.pipelines([
                cover.clone(),
                PipelineDesc { program: "tree", ..covered.clone() },
                PipelineDesc { program: far_cover, ..cover.clone() },
                PipelineDesc { program: far_cover, constants: &[samples, FROM_ABOVE], ..cover },
                PipelineDesc { program: "impostor", constants: &[soft, beams, samples], ..covered.clone() },
                PipelineDesc { program: "impostor", constants: &[soft, samples, FROM_ABOVE], ..covered },
                PipelineDesc {
                    program: "grass",
                    cull: None,
                    cut_out,
                    constants: &[soft, beams, least, reach],
                    ..solid
                },
            ])?;
        Ok(PlantPipelines {
            cover,
            tree,
            far_cover: [far_cover, far_cover_from_above],
            impostor: [impostor, impostor_from_above],
            grass,
        })
    }

    fn sky(&self, builder: &PipelineBuilder) -> Result<wgpu::RenderPipeline, ShaderFault> {
        let soft = [self.soft()];
        let [sky] = builder.pipelines([PipelineDesc {
            program: "sky",
            layout: self.sky_layout,
            depth: Some(depth(false, Default::default())),
            cull: None,
            ..self.solid(&[], &soft)
        }])?;
        Ok(sky)
    }

    fn rain(&self, builder: &PipelineBuilder) -> Result<RainPipelines, ShaderFault> {
        let (mesh, instances) = (mesh_buffers(), [Some(instance_buffer())]);
        let lit = [self.soft(), self.beams()];
        let solid = self.solid(&mesh, &lit);
        let in_water = [self.soft(), self.beams(), ("IN_WATER", 1.0)];
        let wipers = [
            ("AXLE_0", wipers::AXLES_M[0]),
            ("AXLE_1", wipers::AXLES_M[1]),
            ("ARM_0", wipers::ARMS_M[0]),
            ("ARM_1", wipers::ARMS_M[1]),
            ("BARE", wipers::BARE),
            ("SWEEP", wipers::SWEEP_RAD),
        ];
        let wipers = wipers.into_iter().map(|(name, value)| (name, f64::from(value)));
        let windscreen: Vec<_> = wipers.chain([self.beams()]).collect();
        let air = PipelineDesc {
            buffers: &[],
            colour: Some((HDR, Some(wgpu::BlendState::ALPHA_BLENDING))),
            depth: Some(depth(false, Default::default())),
            cull: None,
            ..solid.clone()
        };
        let [mirrored_sky, mirrored_car, streak, nothing, road_depth, drops, windscreen, spray] =
            builder.pipelines([
                PipelineDesc {
                    program: "mirrored_sky",
                    colour: Some((HDR, None)),
                    constants: &lit[..1],
                    ..air.clone()
                },
                // Mirrored triangles turn the other way.
                PipelineDesc {
                    program: "car",
                    colour: Some((HDR, Some(wgpu::BlendState::ALPHA_BLENDING))),
                    cull: Some(wgpu::Face::Front),
                    constants: &in_water,
                    ..solid.clone()
                },
                PipelineDesc {
                    program: "streak",
                    buffers: &instances,
                    colour: Some((HDR, Some(ADDED))),
                    constants: &[],
                    ..air.clone()
                },
                self.mask(&[("DEPTH", 0.0)]),
                PipelineDesc {
                    program: "depth_alone",
                    writes: wgpu::ColorWrites::empty(),
                    constants: &[],
                    ..solid.clone()
                },
                PipelineDesc { program: "rain", ..air.clone() },
                PipelineDesc { program: "windscreen", buffers: &mesh, constants: &windscreen, ..air.clone() },
                PipelineDesc { program: "spray", buffers: &instances, ..air },
            ])?;
        Ok(RainPipelines { mirrored_sky, mirrored_car, streak, nothing, road_depth, drops, windscreen, spray })
    }

    /// Returns the description of a mask, which sets the depth alone.
    fn mask<'a>(&'a self, constants: &'a [(&'static str, f64)]) -> PipelineDesc<'a> {
        PipelineDesc {
            program: "hidden",
            depth: Some(wgpu::DepthStencilState {
                depth_compare: Some(wgpu::CompareFunction::Always),
                ..depth(true, Default::default())
            }),
            writes: wgpu::ColorWrites::empty(),
            cull: None,
            ..self.solid(&[], constants)
        }
    }

    /// Returns the description for opaque surfaces seen from in front; the other pipelines are variants of it.
    fn solid<'a>(
        &'a self,
        buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
        constants: &'a [(&'static str, f64)],
    ) -> PipelineDesc<'a> {
        PipelineDesc {
            program: "road",
            layout: self.layout,
            buffers,
            colour: Some((HDR, None)),
            depth: Some(depth(true, Default::default())),
            cull: Some(wgpu::Face::Back),
            writes: wgpu::ColorWrites::ALL,
            samples: self.quality.msaa,
            cut_out: false,
            constants,
        }
    }

    /// Returns the constant for the number of beams.
    fn beams(&self) -> (&'static str, f64) {
        ("BEAMS", self.weather.beams as f64)
    }

    /// Returns the constant for soft shadow edges; programs without sunshine ignore it.
    fn soft(&self) -> (&'static str, f64) {
        ("SOFT", f64::from(u8::from(self.quality.fine)))
    }
}

fn depth(write: bool, bias: wgpu::DepthBiasState) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(write),
        depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
        stencil: Default::default(),
        bias,
    }
}

/// Returns the test of surfaces whose depth has been drawn before.
fn equal_depth() -> wgpu::DepthStencilState {
    wgpu::DepthStencilState { depth_compare: Some(wgpu::CompareFunction::Equal), ..depth(false, Default::default()) }
}
