//! The shaders' loader: the one place where shared parts are put in front of a program. In: WGSL files, built in or from
//! the directory `shaders` (for reload while the program runs). Out: checked shader modules; a mistake is reported with
//! the file and line that a person edits, not those of the glued text.

use std::path::Path;
use wgpu::naga;

/// A program: its name and the files it consists of, in order.
type Program = (&'static str, &'static [&'static str]);

/// Every program and its parts. A part is a file in `shaders/` without its ending.
pub const PROGRAMS: [Program; 18] = [
    ("shadow", &["shadow"]),
    ("leaf_shadow", &["leaf_shadow"]),
    ("root", &["common", "root"]),
    ("sky", &["common", "light", "sky"]),
    ("road", &["common", "light", "corner", "mesh", "ground", "road"]),
    ("land", &["common", "light", "corner", "mesh", "ground", "land"]),
    ("car", &["common", "light", "corner", "mesh", "car"]),
    ("cover", &["common", "fade", "corner", "leaf", "cover"]),
    ("tree", &["common", "light", "foliage", "corner", "leaf", "tree"]),
    ("far_cover", &["common", "fade", "far", "far_cover"]),
    ("impostor", &["common", "light", "foliage", "fade", "far", "impostor"]),
    ("grass", &["common", "light", "corner", "grass"]),
    ("contact", &["common", "contact"]),
    ("hidden", &["hidden"]),
    ("glow", &["glow"]),
    ("develop", &["print", "edges", "develop"]),
    ("soften", &["print", "edges", "soften"]),
    ("miniature", &["miniature"]),
];

macro_rules! built_in {
    ($($name:literal),+ $(,)?) => {
        [$(($name, include_str!(concat!("../../shaders/", $name, ".wgsl")))),+]
    };
}

const FILES: [(&str, &str); 29] = built_in![
    "common",
    "light",
    "corner",
    "mesh",
    "shadow",
    "leaf_shadow",
    "root",
    "sky",
    "ground",
    "road",
    "land",
    "car",
    "foliage",
    "fade",
    "leaf",
    "cover",
    "tree",
    "far",
    "far_cover",
    "impostor",
    "grass",
    "contact",
    "hidden",
    "glow",
    "print",
    "edges",
    "develop",
    "soften",
    "miniature",
];

/// The text of all shader files.
#[derive(Clone, Debug)]
pub struct Sources {
    files: Vec<(&'static str, String)>,
    /// Built in: the tests below have checked every program.
    tested: bool,
}

impl Sources {
    /// The files as they were when the program was built.
    pub fn built_in() -> Self {
        Self { files: FILES.iter().map(|(name, text)| (*name, (*text).to_owned())).collect(), tested: true }
    }

    /// The files in `directory` as they are now.
    ///
    /// # Errors
    /// Names the file that cannot be read.
    pub fn from_directory(directory: &Path) -> Result<Self, String> {
        let read = |name: &'static str| {
            let path = directory.join(format!("{name}.wgsl"));
            match std::fs::read_to_string(&path) {
                Ok(text) => Ok((name, text)),
                Err(e) => Err(format!("{}: {e}; start the program where the directory `shaders` is", path.display())),
            }
        };
        Ok(Self { files: FILES.iter().map(|(name, _)| read(name)).collect::<Result<_, _>>()?, tested: false })
    }

    /// The glued text of a program.
    fn text(&self, program: &str) -> String {
        self.parts(program).iter().map(|(_, text)| format!("{}\n", text.trim_end())).collect()
    }

    fn parts(&self, program: &str) -> Vec<&(&'static str, String)> {
        let (_, parts) = PROGRAMS.iter().find(|(name, _)| *name == program).expect("a program in PROGRAMS");
        let file = |part: &&str| self.files.iter().find(|(name, _)| name == part).expect("a file in FILES");
        parts.iter().map(file).collect()
    }

    /// File and line of a line of the glued text.
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
    /// `shaders/FILE.wgsl:LINE: what is wrong`.
    pub fn parse(&self, program: &str) -> Result<naga::Module, String> {
        let text = self.text(program);
        let told = |line: Option<u32>, what: String| {
            let (file, line) = self.origin(program, line.unwrap_or(1) as usize);
            format!("shaders/{file}.wgsl:{line}: {what}")
        };
        let module = naga::front::wgsl::parse_str(&text)
            .map_err(|e| told(e.location(&text).map(|l| l.line_number), e.to_string()))?;
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default())
            .validate(&module)
            .map_err(|e| {
                let mut what = e.to_string();
                let mut cause = std::error::Error::source(e.as_inner());
                while let Some(deeper) = cause {
                    what = format!("{what}: {deeper}");
                    cause = deeper.source();
                }
                told(e.location(&text).map(|l| l.line_number), what)
            })?;
        Ok(module)
    }

    /// True if no program can be wrong.
    pub fn tested(&self) -> bool {
        self.tested
    }

    /// Checks a program that may be wrong and hands it to the device.
    ///
    /// # Errors
    /// As [`Sources::parse`].
    pub fn module(&self, device: &wgpu::Device, program: &'static str) -> Result<wgpu::ShaderModule, String> {
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
        let sources = Sources::built_in();
        for (program, _) in PROGRAMS {
            if let Err(message) = sources.parse(program) {
                panic!("{message}");
            }
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
        let mut sources = Sources::built_in();
        let road = sources.files.iter_mut().find(|(name, _)| *name == "road").expect("road");
        let line = road.1.lines().count() + 1;
        road.1 = format!("{}\nfn broken() -> f32 {{ return nowhere; }}\n", road.1.trim_end());
        let message = sources.parse("road").expect_err("the shader is broken");
        assert!(message.starts_with(&format!("shaders/road.wgsl:{line}: ")), "{message}");
        assert!(message.contains("nowhere"), "{message}");
        assert!(sources.parse("sky").is_ok(), "the other programs stay whole");
    }

    #[test]
    fn a_missing_directory_is_named() {
        let message = Sources::from_directory(Path::new("no-such-place")).expect_err("there is none");
        assert!(message.contains("no-such-place"), "{message}");
    }
}
