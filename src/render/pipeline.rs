//! Where pipelines are made: only when a renderer is made and when its shaders are reloaded, never while it draws. In: a
//! [`Recipe`]. Out: a pipeline.

use super::shader::Sources;
use rayon::prelude::*;

/// Colour of the pictures before the tone curve.
pub const HDR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Depth of pictures and shadow maps.
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Everything that a pass of ours varies in a pipeline.
#[derive(Clone)]
pub struct Recipe<'a> {
    /// A program in [`PROGRAMS`](super::shader::PROGRAMS); also the label.
    pub program: &'static str,
    /// Bindings.
    pub layout: &'a wgpu::PipelineLayout,
    /// Vertex and instance buffers.
    pub buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    /// Colour format and blending; none for depth alone.
    pub colour: Option<(wgpu::TextureFormat, Option<wgpu::BlendState>)>,
    /// What of the colour is kept; nothing where a pass is there for the depth.
    pub writes: wgpu::ColorWrites,
    /// Depth test.
    pub depth: Option<wgpu::DepthStencilState>,
    /// Which faces are left out.
    pub cull: Option<wgpu::Face>,
    /// Samples a pixel.
    pub samples: u32,
    /// True if the colour's alpha says how many of a pixel's samples are covered, or without a colour if the program leaves
    /// out pixels.
    pub cut_out: bool,
    /// Values of the shader's `override` constants.
    pub constants: &'a [(&'static str, f64)],
}

/// Makes pipelines from shaders.
pub struct Workshop<'a> {
    /// The device.
    pub device: &'a wgpu::Device,
    /// The shaders' text.
    pub sources: &'a Sources,
}

impl Workshop<'_> {
    /// A pipeline for each recipe, in their order: side by side where no shader can be wrong. The scope in which a device
    /// reports what it refuses is that of one thread.
    ///
    /// # Errors
    /// What is wrong with a shader, with file and line.
    pub fn pipelines<const N: usize>(&self, recipes: [Recipe; N]) -> Result<[wgpu::RenderPipeline; N], String> {
        let made: Result<Vec<_>, _> = match self.sources.tested() {
            true => recipes.par_iter().map(|recipe| self.pipeline(recipe)).collect(),
            false => recipes.iter().map(|recipe| self.pipeline(recipe)).collect(),
        };
        made.map(|list| list.try_into().expect("one for each recipe"))
    }

    /// A pipeline; entry points are `vertex` and `fragment`.
    ///
    /// # Errors
    /// What is wrong with the shader, with file and line.
    pub fn pipeline(&self, recipe: &Recipe) -> Result<wgpu::RenderPipeline, String> {
        let module = self.sources.module(self.device, recipe.program)?;
        let options =
            wgpu::PipelineCompilationOptions { constants: recipe.constants, zero_initialize_workgroup_memory: false };
        let targets: Vec<_> = recipe
            .colour
            .iter()
            .map(|&(format, blend)| Some(wgpu::ColorTargetState { format, blend, write_mask: recipe.writes }))
            .collect();
        Ok(self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(recipe.program),
            layout: Some(recipe.layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: options.clone(),
                buffers: recipe.buffers,
            },
            primitive: wgpu::PrimitiveState { cull_mode: recipe.cull, ..Default::default() },
            depth_stencil: recipe.depth.clone(),
            multisample: wgpu::MultisampleState {
                count: recipe.samples,
                alpha_to_coverage_enabled: recipe.cut_out && recipe.colour.is_some(),
                ..Default::default()
            },
            fragment: (recipe.colour.is_some() || recipe.cut_out).then_some(wgpu::FragmentState {
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
    fn pipelines_are_made_here_and_asked_for_only_by_new_and_reload() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/render");
        for file in std::fs::read_dir(folder).expect("the folder") {
            let file = file.expect("a file").path();
            let Ok(text) = std::fs::read_to_string(&file) else { continue };
            let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
            // Spelt in two parts, so that this test does not find itself.
            let made = text.matches(concat!("create_render_", "pipeline")).count();
            assert_eq!(made, usize::from(name == "pipeline.rs"), "{name}");
            let workshops = text.matches(concat!("Workshop ", "{ device")).count();
            let allowed = match name.as_str() {
                "mod.rs" => 2,
                "preview.rs" => 1,
                _ => 0,
            };
            assert_eq!(workshops, allowed, "{name}: new, and in mod.rs reload_shaders_from");
        }
    }
}
