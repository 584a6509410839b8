//! Loader of the shaders: the only place that joins shared parts with a program. In: WGSL files, built in or from the
//! directory `shaders` (for reload while the program runs). Out: checked shader modules. A mistake is reported with the
//! line of the file that a person edits, not of the joined text.

use std::path::{Path, PathBuf};
use wgpu::naga;

/// A program: its name and the files it consists of, in order.
type ShaderProgram = (&'static str, &'static [&'static str]);

/// All programs and their parts. A part is a file in `shaders/` without its extension.
pub const PROGRAMS: [ShaderProgram; 29] = [
    ("shadow", &["sun_view", "shadow"]),
    ("person_shadow", &["sun_view", "posture", "person_shadow"]),
    ("leaf_shadow", &["leaf_shadow"]),
    ("root", &["common", "root"]),
    ("sky", &["common", "light", "ray", "sky"]),
    ("road", &["common", "light", "lamps", "corner", "surface", "mesh", "ground", "road"]),
    ("land", &["common", "light", "lamps", "corner", "surface", "mesh", "ground", "land"]),
    ("car", &["common", "light", "lamps", "corner", "surface", "mesh", "car"]),
    ("person", &["common", "light", "lamps", "corner", "surface", "posture", "person", "car"]),
    ("building", &["common", "light", "lamps", "corner", "surface", "mesh", "ground", "building"]),
    ("cover", &["common", "fade", "corner", "leaf", "cover", "sample_mask"]),
    ("cover_by_sample", &["common", "fade", "corner", "leaf", "cover", "sample_index"]),
    ("tree", &["common", "light", "lamps", "foliage", "corner", "leaf", "tree"]),
    ("far_cover", &["common", "fade", "far", "far_cover", "sample_mask"]),
    ("far_cover_by_sample", &["common", "fade", "far", "far_cover", "sample_index"]),
    ("impostor", &["common", "light", "lamps", "foliage", "fade", "far", "impostor"]),
    ("grass", &["common", "light", "lamps", "corner", "grass"]),
    ("contact", &["common", "contact"]),
    ("hidden", &["hidden"]),
    ("mirrored_sky", &["common", "light", "ray", "mirrored_sky"]),
    ("streak", &["common", "streak"]),
    ("depth_alone", &["common", "corner", "surface", "mesh", "depth_alone"]),
    ("rain", &["common", "light", "lamps", "rain"]),
    ("spray", &["common", "light", "lamps", "spray"]),
    ("windscreen", &["common", "light", "lamps", "corner", "surface", "mesh", "windscreen"]),
    ("bloom", &["bloom"]),
    ("tonemap", &["quad", "edges", "tonemap"]),
    ("soften", &["quad", "edges", "soften"]),
    ("preview", &["preview"]),
];

macro_rules! built_in {
    ($($name:literal),+ $(,)?) => {
        [$(($name, include_str!(concat!("../../../shaders/", $name, ".wgsl")))),+]
    };
}

const FILES: [(&str, &str); 45] = built_in![
    "common",
    "light",
    "lamps",
    "corner",
    "surface",
    "mesh",
    "posture",
    "person",
    "sun_view",
    "shadow",
    "person_shadow",
    "leaf_shadow",
    "root",
    "ray",
    "sky",
    "ground",
    "road",
    "land",
    "car",
    "building",
    "foliage",
    "fade",
    "leaf",
    "cover",
    "tree",
    "far",
    "far_cover",
    "sample_mask",
    "sample_index",
    "impostor",
    "grass",
    "contact",
    "hidden",
    "mirrored_sky",
    "streak",
    "depth_alone",
    "rain",
    "spray",
    "windscreen",
    "bloom",
    "quad",
    "edges",
    "tonemap",
    "soften",
    "preview",
];

/// Error of the shaders.
#[derive(Debug, thiserror::Error)]
pub enum ShaderFault {
    /// A file that cannot be read.
    #[error("{}: {source}; start the program in the folder that contains `shaders`", file.display())]
    Unreadable {
        /// Path of the file.
        file: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// A mistake in a file.
    #[error("shaders/{file}.wgsl:{line}: {what}")]
    Wrong {
        /// Name of the file without its extension.
        file: &'static str,
        /// Line number, from 1.
        line: usize,
        /// Message of the parser or validator.
        what: String,
    },
    /// Shaders that are valid, but refused by the device.
    #[error("{}: {words}", directory.display())]
    Refused {
        /// Directory of the shaders.
        directory: PathBuf,
        /// Message of the device.
        words: String,
    },
}

/// Source text of all shader files.
#[derive(Clone, Debug)]
pub struct ShaderSources {
    files: Vec<(&'static str, String)>,
    /// True for the built-in files: the tests below check every program.
    tested: bool,
}

impl ShaderSources {
    /// Returns the files as they were when the program was built.
    pub fn built_in() -> Self {
        Self { files: FILES.iter().map(|(name, text)| (*name, (*text).to_owned())).collect(), tested: true }
    }

    /// Reads the files in `directory` as they are now.
    ///
    /// # Errors
    /// Names the file that cannot be read.
    pub fn from_directory(directory: &Path) -> Result<Self, ShaderFault> {
        let read = |name: &'static str| {
            let file = directory.join(format!("{name}.wgsl"));
            match std::fs::read_to_string(&file) {
                Ok(text) => Ok((name, text)),
                Err(source) => Err(ShaderFault::Unreadable { file, source }),
            }
        };
        Ok(Self { files: FILES.iter().map(|(name, _)| read(name)).collect::<Result<_, _>>()?, tested: false })
    }

    /// Returns the joined text of a program.
    fn text(&self, program: &str) -> String {
        self.parts(program).iter().map(|(_, text)| format!("{}\n", text.trim_end())).collect()
    }

    fn parts(&self, program: &str) -> Vec<&(&'static str, String)> {
        let (_, parts) = PROGRAMS.iter().find(|(name, _)| *name == program).expect("a program in PROGRAMS");
        let file = |part: &&str| self.files.iter().find(|(name, _)| name == part).expect("a file in FILES");
        parts.iter().map(file).collect()
    }

    /// Returns file and line of a line of the joined text.
    fn origin(&self, program: &str, glued_line: usize) -> (&'static str, usize) {
        let mut line = glued_line;
        for (name, text) in self.parts(program) {
            let lines = text.trim_end().lines().count();
            if line <= lines {
                return (name, line);
            }
            line -= lines;
        }
        ("end of", line)
    }

    /// Parses and validates a program.
    ///
    /// # Errors
    /// `shaders/FILE.wgsl:LINE: message`.
    pub fn parse(&self, program: &str) -> Result<naga::Module, ShaderFault> {
        let text = self.text(program);
        let fault_at = |line: Option<u32>, what: String| {
            let (file, line) = self.origin(program, line.unwrap_or(1) as usize);
            ShaderFault::Wrong { file, line, what }
        };
        let module = naga::front::wgsl::parse_str(&text)
            .map_err(|e| fault_at(e.location(&text).map(|l| l.line_number), e.to_string()))?;
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default())
            .validate(&module)
            .map_err(|e| {
                let mut what = e.to_string();
                let mut cause = std::error::Error::source(e.as_inner());
                while let Some(deeper) = cause {
                    what = format!("{what}: {deeper}");
                    cause = deeper.source();
                }
                fault_at(e.location(&text).map(|l| l.line_number), what)
            })?;
        Ok(module)
    }

    /// Returns true for the built-in files, which the tests have validated.
    pub fn tested(&self) -> bool {
        self.tested
    }

    /// Creates a program's module on the device, after validation unless the files are built in.
    ///
    /// # Errors
    /// As [`ShaderSources::parse`].
    pub fn module(&self, device: &wgpu::Device, program: &'static str) -> Result<wgpu::ShaderModule, ShaderFault> {
        if !self.tested {
            self.parse(program)?;
        }
        let source = wgpu::ShaderSource::Wgsl(self.text(program).into());
        Ok(device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(program), source }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shader_is_valid() {
        let sources = ShaderSources::built_in();
        for (program, _) in PROGRAMS {
            if let Err(message) = sources.parse(program) {
                panic!("{message}");
            }
        }
    }

    /// Inputs of a value, as far as a driver knows them without running the program.
    #[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
    enum MadeOf {
        Constants,
        Uniforms,
        More,
    }

    fn made_of(module: &naga::Module, function: &naga::Function, value: naga::Handle<naga::Expression>) -> MadeOf {
        use naga::Expression as E;
        let all = |parts: &[naga::Handle<E>]| {
            parts.iter().map(|part| made_of(module, function, *part)).max().unwrap_or(MadeOf::Constants)
        };
        match &function.expressions[value] {
            E::Literal(_) | E::Constant(_) | E::Override(_) | E::ZeroValue(_) => MadeOf::Constants,
            E::GlobalVariable(place) => match module.global_variables[*place].space {
                naga::AddressSpace::Uniform => MadeOf::Uniforms,
                _ => MadeOf::More,
            },
            E::Access { base, index } => all(&[*base, *index]),
            E::AccessIndex { base: part, .. }
            | E::Load { pointer: part }
            | E::Splat { value: part, .. }
            | E::Swizzle { vector: part, .. }
            | E::Unary { expr: part, .. }
            | E::As { expr: part, .. }
            | E::Relational { argument: part, .. } => all(&[*part]),
            E::Binary { left, right, .. } => all(&[*left, *right]),
            E::Select { condition, accept, reject } => all(&[*condition, *accept, *reject]),
            E::Compose { components, .. } => all(components),
            E::Math { arg, arg1, arg2, arg3, .. } => {
                all(&[Some(*arg), *arg1, *arg2, *arg3].into_iter().flatten().collect::<Vec<_>>())
            }
            _ => MadeOf::More,
        }
    }

    /// Calls `found` with the condition of every branch in `block`.
    fn branches(block: &naga::Block, found: &mut impl FnMut(naga::Handle<naga::Expression>)) {
        use naga::Statement as S;
        for statement in block {
            match statement {
                S::Block(inner) => branches(inner, found),
                S::If { condition, accept, reject } => {
                    found(*condition);
                    branches(accept, found);
                    branches(reject, found);
                }
                S::Switch { selector, cases } => {
                    found(*selector);
                    cases.iter().for_each(|case| branches(&case.body, found));
                }
                S::Loop { body, continuing, break_if } => {
                    break_if.iter().for_each(|condition| found(*condition));
                    branches(body, found);
                    branches(continuing, found);
                }
                _ => (),
            }
        }
    }

    /// Returns the lines of a program's joined text with a branch that depends on uniforms alone.
    fn branches_on_uniforms(module: &naga::Module, text: &str) -> Vec<usize> {
        let functions = module.functions.iter().map(|(_, function)| function);
        let mut lines = Vec::new();
        for function in functions.chain(module.entry_points.iter().map(|entry| &entry.function)) {
            branches(&function.body, &mut |condition| {
                if made_of(module, function, condition) == MadeOf::Uniforms {
                    lines.push(function.expressions.get_span(condition).location(text).line_number as usize);
                }
            });
        }
        lines
    }

    #[test]
    fn no_branch_depends_on_uniforms_alone() {
        // Mesa's software renderer recompiles such a program at every draw, with the uniforms' values in it, and keeps
        // all of them: 1.5 MB a picture, and a tenth of its time (`update_inline_shader_state`, lavapipe 22.3).
        let sources = ShaderSources::built_in();
        let found: Vec<_> = PROGRAMS
            .iter()
            .flat_map(|(program, _)| {
                let module = sources.parse(program).expect("tested above");
                let lines = branches_on_uniforms(&module, &sources.text(program));
                lines.into_iter().map(|line| sources.origin(program, line)).collect::<Vec<_>>()
            })
            .collect();
        assert!(found.is_empty(), "a varying, `select` or an `override` serves: {found:?}");
    }

    #[test]
    fn a_branch_on_uniforms_is_found_through_expressions_and_names() {
        let lines = |condition: &str| {
            let text = format!(
                "override KIND: bool = true; struct Sheet {{ size: vec4f, border: f32 }}\n\
                 @group(0) @binding(0) var<uniform> sheet: Sheet;\n\
                 @fragment fn fragment(@location(0) at: vec2f) -> @location(0) vec4f {{\n\
                 let wide = max(sheet.size.x, 2.0) - sheet.border;\n\
                 for (var i = 0; i < 4; i++) {{\n\
                 if {condition} {{ return vec4f(at, 1.0, 1.0); }}\n\
                 }} return vec4f(0.0); }}"
            );
            branches_on_uniforms(&naga::front::wgsl::parse_str(&text).expect(condition), &text)
        };
        for hangs in
            ["sheet.border > 0.0", "wide > 0.0", "-wide * 2.0 < sheet.size[1]", "any(sheet.size.xy > vec2f(1.0))"]
        {
            assert_eq!(lines(hangs), [6], "{hangs}");
        }
        for free in ["KIND", "at.x > sheet.border", "wide > at.y", "i > 2"] {
            assert!(lines(free).is_empty(), "{free}");
        }
    }

    #[test]
    fn every_file_belongs_to_a_program() {
        for (file, _) in FILES {
            assert!(PROGRAMS.iter().any(|(_, parts)| parts.contains(&file)), "{file} is used by no program");
        }
    }

    #[test]
    fn a_mistake_is_reported_with_its_own_file_and_line() {
        let mut sources = ShaderSources::built_in();
        let road = sources.files.iter_mut().find(|(name, _)| *name == "road").expect("road");
        let line = road.1.lines().count() + 1;
        road.1 = format!("{}\nfn broken() -> f32 {{ return nowhere; }}\n", road.1.trim_end());
        let message = sources.parse("road").expect_err("the shader is broken").to_string();
        assert!(message.starts_with(&format!("shaders/road.wgsl:{line}: ")), "{message}");
        assert!(message.contains("nowhere"), "{message}");
        assert!(sources.parse("sky").is_ok(), "the other programs stay whole");
    }

    #[test]
    fn a_missing_directory_is_named() {
        let message = ShaderSources::from_directory(Path::new("no-such-place")).expect_err("there is none").to_string();
        assert!(message.contains("no-such-place"), "{message}");
    }
}
