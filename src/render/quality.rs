//! Settings of the picture's quality. In: a preset or single settings. Out: numbers that the passes read when they are
//! created. `codrive bench` measures them. On software rendering a pixel costs about 160 ns at low and at medium, a
//! third of that for leaves and their shadows; vertices of triangles cost as much again as the pixels of trees.

/// Settings of the renderer; changing one needs a new [`Renderer`](super::Renderer).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Quality {
    /// Samples per pixel: 1 or 4 (other numbers are not available everywhere).
    pub msaa: u32,
    /// Side of each of the shadow maps, texels.
    pub shadow_size: u32,
    /// Resolution of the mirror's picture in pixels per pixel of the inset, 0.25 to 2; limited to 1 where the mirror is
    /// the whole picture.
    pub mirror_scale: f32,
    /// Maximum number of pixels of the main picture: a larger one is drawn smaller, by one factor on both sides, and
    /// upscaled at tone mapping. Dial and panel are drawn over it at full size.
    pub most_pixels: u32,
    /// Anisotropic filtering of the ground's grain, 1 to 16. The renderer uses 1 on software rendering.
    pub anisotropy: u16,
    /// If true, shadow edges are means of 4 by 4 texels, textures are filtered between mip levels, and leaf cards cast
    /// shadows. Otherwise shadow edges are means of 2 by 2 texels, without that filtering, which software rendering
    /// draws in half the time.
    #[serde(default = "fine")]
    pub fine: bool,
    /// Maximum distance of tufts of grass, m.
    #[serde(default = "grass_m")]
    pub grass_m: f32,
    /// Factor on the size by which the levels of trees are chosen, up to 1: at 0.5, a level is used until the tree is
    /// twice as large. The levels of cars do not depend on it.
    #[serde(default = "detail")]
    pub detail: f32,
}

fn fine() -> bool {
    true
}

fn detail() -> f32 {
    Quality::MEDIUM.detail
}

fn grass_m() -> f32 {
    Quality::MEDIUM.grass_m
}

impl Quality {
    /// Preset for tests and software rendering.
    pub const LOW: Self = Self {
        msaa: 1,
        shadow_size: 1024,
        mirror_scale: 0.75,
        most_pixels: 768 * 432,
        anisotropy: 1,
        fine: false,
        grass_m: 13.0,
        detail: 0.3,
    };
    /// Smooth edges; the preset of `codrive render`.
    pub const MEDIUM: Self = Self {
        msaa: 4,
        shadow_size: 2048,
        mirror_scale: 1.0,
        most_pixels: u32::MAX,
        anisotropy: 1,
        fine: true,
        grass_m: 30.0,
        detail: 1.0,
    };
    /// Medium for software rendering: edges are filtered at tone mapping, and a picture of more than 1280x720 pixels is
    /// drawn with that many.
    pub const MEDIUM_SOFTWARE: Self =
        Self { msaa: 1, most_pixels: 1280 * 720, fine: false, grass_m: 24.0, detail: 0.4, ..Self::MEDIUM };
    /// Preset for a GPU.
    pub const HIGH: Self = Self { shadow_size: 3072, anisotropy: 8, grass_m: 60.0, ..Self::MEDIUM };
}

impl Quality {
    /// Returns the size in which a main picture of `size` pixels is drawn; `mirror` is true if it is a mirror's alone.
    pub fn drawn_size(&self, size: [u32; 2], mirror: bool) -> [u32; 2] {
        let pixels = (size[0] * size[1]) as f32;
        let most = if mirror { self.mirror_scale.min(1.0) } else { 1.0 };
        let scale = (self.most_pixels as f32 / pixels).sqrt().min(most);
        size.map(|side| ((side as f32 * scale).round() as u32).max(1))
    }
}

impl Default for Quality {
    fn default() -> Self {
        Self::MEDIUM
    }
}
