//! Creation of pipelines: when a renderer is made, when its shaders are reloaded and when a night begins, not while it draws. In: a
//! [`PipelineDesc`]. Out: a pipeline.

use super::shader::{ShaderFault, ShaderSources};
use rayon::prelude::*;

/// Colour format of pictures before the tone curve.
pub const HDR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Depth format of pictures and shadow maps.
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Settings that differ between the pipelines of this program.
#[derive(Clone)]
pub struct PipelineDesc<'a> {
    /// Name of a program in [`PROGRAMS`](super::shader::PROGRAMS); also the label.
    pub program: &'static str,
    /// Layout of the bind groups.
    pub layout: &'a wgpu::PipelineLayout,
    /// Vertex and instance buffers.
    pub buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    /// Colour format and blending; `None` for depth alone.
    pub colour: Option<(wgpu::TextureFormat, Option<wgpu::BlendState>)>,
    /// Colour channels that are written; empty for a depth-only pass with a colour target.
    pub writes: wgpu::ColorWrites,
    /// Depth test; `None` without depth.
    pub depth: Option<wgpu::DepthStencilState>,
    /// Faces that are culled.
    pub cull: Option<wgpu::Face>,
    /// Number of samples per pixel.
    pub samples: u32,
    /// True if the colour's alpha is the share of a pixel's samples that are covered, or, without a colour, if the
    /// fragment shader discards pixels.
    pub cut_out: bool,
    /// Values of the shader's `override` constants.
    pub constants: &'a [(&'static str, f64)],
}

/// Creates pipelines from shaders.
pub struct PipelineBuilder<'a> {
    /// Device that the pipelines belong to.
    pub device: &'a wgpu::Device,
    /// Source text of the shaders.
    pub sources: &'a ShaderSources,
}

impl PipelineBuilder<'_> {
    /// Creates a pipeline for each description, in the same order. They are made in parallel if the shaders are the
    /// tested built-in ones: the device's error scope, which catches faults of reloaded shaders, covers one thread
    /// only.
    ///
    /// # Errors
    /// A mistake in a shader, with file and line.
    pub fn pipelines<const N: usize>(
        &self,
        descriptions: [PipelineDesc; N],
    ) -> Result<[wgpu::RenderPipeline; N], ShaderFault> {
        let made: Result<Vec<_>, _> = match self.sources.tested() {
            true => descriptions.par_iter().map(|desc| self.pipeline(desc)).collect(),
            false => descriptions.iter().map(|desc| self.pipeline(desc)).collect(),
        };
        made.map(|list| list.try_into().expect("one for each description"))
    }

    /// Runs both, in parallel under the same condition as [`PipelineBuilder::pipelines`].
    pub fn both<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        if self.sources.tested() { rayon::join(a, b) } else { (a(), b()) }
    }

    /// Creates a pipeline; entry points are `vertex` and `fragment`.
    ///
    /// # Errors
    /// A mistake in the shader, with file and line.
    pub fn pipeline(&self, desc: &PipelineDesc) -> Result<wgpu::RenderPipeline, ShaderFault> {
        let module = self.sources.module(self.device, desc.program)?;
        let options =
            wgpu::PipelineCompilationOptions { constants: desc.constants, zero_initialize_workgroup_memory: false };
        let targets: Vec<_> = desc
            .colour
            .iter()
            .map(|&(format, blend)| Some(wgpu::ColorTargetState { format, blend, write_mask: desc.writes }))
            .collect();
        Ok(self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(desc.program),
            layout: Some(desc.layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: options.clone(),
                buffers: desc.buffers,
            },
            primitive: wgpu::PrimitiveState { cull_mode: desc.cull, ..Default::default() },
            depth_stencil: desc.depth.clone(),
            multisample: wgpu::MultisampleState {
                count: desc.samples,
                alpha_to_coverage_enabled: desc.cut_out && desc.colour.is_some(),
                ..Default::default()
            },
            fragment: (desc.colour.is_some() || desc.cut_out).then_some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: options,
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        }))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    #[test]
    fn pipelines_are_made_here_by_new_by_reload_and_at_nightfall() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/render");
        let files = |folder: &Path| {
            let entries = std::fs::read_dir(folder).expect("a folder");
            entries.map(|entry| entry.expect("a file").path()).collect::<Vec<_>>()
        };
        let mut all = files(&root);
        all.extend(all.clone().iter().filter(|path| path.is_dir()).flat_map(|folder| files(folder)));
        assert!(all.len() > 25, "{all:?}");
        for file in all.iter().filter(|path| path.is_file()) {
            let text = std::fs::read_to_string(file).expect("text");
            let name = file.strip_prefix(&root).expect("below it").to_string_lossy().replace('\\', "/");
            // Split in two, so that this test does not find itself.
            let made = text.matches(concat!("create_render_", "pipeline")).count();
            assert_eq!(made, usize::from(name == "device/pipeline.rs"), "{name}");
            let builders = text.matches(concat!("PipelineBuilder ", "{ device")).count();
            let allowed = match name.as_str() {
                "mod.rs" => 3,
                "post/preview.rs" => 1,
                _ => 0,
            };
            assert_eq!(builders, allowed, "{name}: new, and in mod.rs reload_shaders_from and draw");
        }
    }
}
