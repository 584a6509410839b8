//! Layers, colours and widths of road surfaces, and points in single precision. Metres; colours as linear albedo.
//!
//! Overlapping surfaces lie in layers a few millimetres apart, which prevents z-fighting: see [`Layer`].

use crate::{map, scene::colours::shade};

/// Layer of a surface. Its height above the lane's centre line is [`Layer::z_m`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Layer {
    /// Stop lines and crossings.
    Paint,
    /// Pavements, and walking areas that no vehicle crosses.
    Pavement,
    /// Lanes inside a junction that has a shared walking area.
    SharedWay,
    /// Walking areas that vehicles drive across.
    Shared,
    /// Lanes of streets, with their markings.
    Street,
    /// Area of a junction, inside its outline.
    Junction,
    /// Shoulder around the areas of junctions.
    Apron,
    /// Lanes inside junctions, visible where the junction's area has a gap.
    Way,
    /// Strips of asphalt under the seams between lanes.
    Seam,
    /// Upper edge of the verge, under the asphalt's edge.
    Verge,
}

impl Layer {
    /// Returns the height above the lane's centre line, metres.
    pub fn z_m(self) -> f32 {
        match self {
            Self::Paint => 0.006,
            Self::Pavement => 0.08,
            Self::Street => 0.0,
            Self::SharedWay => -0.002,
            Self::Shared => -0.004,
            Self::Junction => -0.006,
            Self::Apron => -0.009,
            Self::Way => -0.012,
            Self::Seam => -0.015,
            Self::Verge => -0.020,
        }
    }
}

/// Returns the colour of asphalt outside wheel tracks, linear albedo.
pub(super) fn plain_asphalt() -> [f32; 3] {
    shade(ASPHALT, 1.04)
}

/// Width of the shoulder: asphalt beyond the edge of the outermost lane, metres.
pub(super) const SHOULDER: f64 = map::SHOULDER_M;
/// Width of the shoulder in single precision, for meshes, metres.
pub(in crate::scene) const SHOULDER_M: f32 = map::SHOULDER_M as f32;

/// Half the width of every painted line along a road, metres.
pub(super) const LINE_HALF_M: f64 = 0.06;

/// Base colour of asphalt, linear albedo.
pub(super) const ASPHALT: [f32; 3] = [0.082, 0.082, 0.086];
/// Colour of pavements, linear albedo.
pub(super) const PAVING: [f32; 3] = [0.270, 0.262, 0.245];
/// Colour of kerb stones, linear albedo.
pub(super) const KERB: [f32; 3] = [0.36, 0.355, 0.34];
/// Paint of markings, linear albedo.
pub(super) const PAINT: [f32; 3] = [0.70, 0.70, 0.67];
