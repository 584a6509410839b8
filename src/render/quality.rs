//! Settings of the picture's quality. In: a preset or single settings. Out: numbers that the passes read when they are made.
//! `codrive bench` measures them. On software rendering every pixel costs about 160 ns at low and at medium, a third of that
//! for leaves and their shadows, and corners of triangles cost as much again as the pixels of trees.

/// Settings of the renderer; changing one needs a new [`Renderer`](super::Renderer).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Quality {
    /// Samples a pixel: 1 or 4 (other numbers are not everywhere available).
    pub msaa: u32,
    /// Side of each of the three shadow maps, texels.
    pub shadow_size: u32,
    /// Resolution of the mirror's picture in pixels of the inset, 0.25 to 2; up to 1 also where the mirror is the whole
    /// picture.
    pub mirror_scale: f32,
    /// Most pixels of the main picture: one of more is drawn smaller, by one factor on both sides, and filtered up when it
    /// is developed. Dial and panel are drawn over it at full size.
    pub most_pixels: u32,
    /// Anisotropy of the ground's grain, 1 to 16. The renderer takes 1 where graphics run in software.
    pub anisotropy: u16,
    /// Shadow edges are means of 4 by 4 texels and textures are filtered between their reduced sizes; otherwise of 2 by 2
    /// and not, which software rendering draws in half the time.
    #[serde(default = "fine")]
    pub fine: bool,
    /// Up to this distance tufts of grass are drawn, metres.
    #[serde(default = "grass_m")]
    pub grass_m: f32,
    /// Factor on the size by which the levels of trees are chosen, up to 1: at 0.5, a level serves until it is twice as
    /// large. Those of cars are the same everywhere.
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
    /// For tests and software rendering.
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
    /// Smooth edges; the picture of `codrive render`.
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
    /// Medium where the processor draws: edges are filtered when the picture is developed, and a picture of more than
    /// 1280x720 is drawn at that size.
    pub const MEDIUM_SOFTWARE: Self =
        Self { msaa: 1, most_pixels: 1280 * 720, fine: false, grass_m: 24.0, detail: 0.4, ..Self::MEDIUM };
    /// For a GPU.
    pub const HIGH: Self = Self { shadow_size: 3072, anisotropy: 8, grass_m: 60.0, ..Self::MEDIUM };
}

impl Quality {
    /// Size in which a main picture of `size` pixels is drawn, which may be that of a `mirror` alone.
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
