//! Light after sunset and its adaptation. In: the direction to the sun, daylight. Out: the lights in the sky, the gain of the picture.
//!
//! Twilight has the colours of the sky around a sun at the horizon and the measured illuminance. At night a full moon stands opposite the
//! sun. A picture holds light from a tenth to a few times that of its middle: the eye adapts, and so does the gain.

use glam::Vec3;

/// Illuminance of a white sheet per unit of its radiance, lx: above the atmosphere the sun gives 128,000 lx (docs/references.md: night) and a
/// radiance of 1.70.
pub(super) const LUX: f32 = 128_000.0 / 1.70;
/// Sine of the lowest elevation for which the scattering of light is computed.
const LOWEST: f32 = 0.02;
/// Illuminance on level ground under a clear sky by the sun's elevation, degrees and lx (docs/references.md: night).
const TWILIGHT: [(f32, f32); 4] = [(0.0, 500.0), (-6.0, 2.7), (-12.0, 0.008), (-18.0, 6e-4)];
/// Light of the full moon as a share of the sun's, 14 magnitudes less, and its factor in pictures: a screen shows less contrast than a night has,
/// and without it there would be neither sky nor land.
const MOON: f32 = 2.5e-6 * RAISED;
const RAISED: f32 = 12.0;

/// Daylight below which the gain rises above 1, as radiance of a white sheet on the ground: just before sunset.
pub(super) const DUSK: f32 = 0.01;
/// Daylight that has the same effect on the eye as what headlamps light on the road: some 1.5 lx.
const LIT_ROAD: f32 = 2e-5;
/// Exponent of the adaptation below that light.
const ADAPTATION: f32 = 0.95;

/// Light in the sky whose scattering is computed: the sun or the moon.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkyLight {
    /// Unit direction towards it; in twilight just above the horizon.
    pub towards: Vec3,
    /// Sine of its true elevation.
    up: f32,
    /// Light at the same elevation as a share of the sun's.
    strength: f32,
}

impl SkyLight {
    /// Returns the lights of the hour: the sun and, after sunset, the moon.
    pub fn of_the_hour(to_sun: Vec3) -> Vec<Self> {
        let light = |towards: Vec3, strength: f32| {
            let raised = towards.with_z(towards.z.max(LOWEST)).normalize();
            Self { towards: raised, up: towards.z, strength }
        };
        let sun = light(to_sun, 1.0);
        if to_sun.z < 0.0 { vec![sun, light(-to_sun, MOON)] } else { vec![sun] }
    }

    /// Returns the light that the air scatters and that shines on surfaces, as shares of the sun's in the direction `towards`. `lowest_lux` is
    /// the illuminance of a sun at [`LOWEST`], asked for in twilight alone.
    pub fn shares(&self, lowest_lux: impl FnOnce() -> f32) -> [f32; 2] {
        let dimmed = if self.up < LOWEST { twilight(self.up.asin().to_degrees(), lowest_lux()) } else { 1.0 };
        let scattered = self.strength * dimmed;
        [scattered, scattered * (self.up / LOWEST).clamp(0.0, 1.0)]
    }
}

/// Returns the unit direction towards the light that casts shadows: the sun, or the moon after sunset.
pub fn to_shining(to_sun: Vec3) -> Vec3 {
    let up = if to_sun.z < 0.0 { -to_sun } else { to_sun };
    up.with_z(up.z.max(LOWEST)).normalize()
}

/// Returns twilight as a share of the light of a sun at [`LOWEST`], which is `lowest_lux`.
fn twilight(elevation_deg: f32, lowest_lux: f32) -> f32 {
    let table = [(LOWEST.asin().to_degrees(), lowest_lux)].into_iter().chain(TWILIGHT).collect::<Vec<_>>();
    let below = table.windows(2).find(|pair| elevation_deg >= pair[1].0).unwrap_or(&table[table.len() - 2..]);
    let [(high_deg, high), (low_deg, low)] = [below[0], below[1]];
    let share = (elevation_deg - high_deg) / (low_deg - high_deg);
    10f32.powf(high.log10() + (low / high).log10() * share) / lowest_lux
}

/// Returns the gain of the picture's light and the exposure of the gained light, for daylight as radiance of a white sheet on the ground.
pub(super) fn adaptation(daylight: f32) -> (f32, f32) {
    // Like the eye, leave some of the evening's darkness.
    let exposure = 1.8 / daylight.max(DUSK).sqrt();
    let gain = ((DUSK + LIT_ROAD) / (daylight.min(DUSK) + LIT_ROAD)).powf(ADAPTATION);
    (gain, exposure)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::sky::atmosphere::Sky;

    fn at(elevation_deg: f32) -> Sky {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        Sky::new(Vec3::new(cos, 0.0, sin), 30_000.0, false)
    }

    /// Returns the illuminance on level ground, lx.
    fn lux(sky: &Sky) -> f32 {
        (sky.sun * sky.to_shining.z + sky.ambient(Vec3::Z)).dot(Vec3::new(0.2126, 0.7152, 0.0722)) / sky.one_lux
    }

    #[test]
    fn twilight_has_the_measured_illuminance() {
        // Glossary of the American Meteorological Society, "civil twilight": at sunset, and at its end (docs/references.md: night).
        let [sunset, end] = [0.0, -6.0].map(|deg| lux(&at(deg)));
        assert!((410.0..585.0).contains(&sunset) && (2.0..3.5).contains(&end), "{sunset} lx, {end} lx");
        // A full moon gives a quarter of a lux (docs/references.md: night), less where it is not at the zenith; pictures raise it.
        let night = lux(&at(-50.0)) / RAISED;
        assert!((0.1..0.4).contains(&night), "{night} lx");
    }

    #[test]
    fn the_picture_darkens_steadily_from_day_to_night() {
        let shown = |sky: &Sky| lux(sky) * sky.one_lux * sky.exposure;
        let mut before = shown(&at(8.0));
        for quarter_deg in (-72..31).rev() {
            let now = shown(&at(0.25 * quarter_deg as f32));
            // A quarter of a degree is one to two minutes. Half of a third of a stop, the step of a light meter.
            assert!(
                (now / before).log2().abs() < 1.0 / 6.0,
                "{} degrees: {before} to {now}",
                0.25 * quarter_deg as f32
            );
            before = now;
        }
        // Darker than by day in the end, but not black.
        assert!((0.01..0.2).contains(&before), "{before}");
    }

    #[test]
    fn the_moon_stands_opposite_the_sun_and_shines_after_sunset() {
        let evening = Vec3::new(-0.8, 0.0, -0.6);
        assert!(to_shining(evening).distance(-evening) < 1e-6);
        let day = Vec3::new(0.6, 0.0, 0.8);
        assert!(to_shining(day).distance(day) < 1e-6);
        assert!(at(-40.0).to_shining.distance(at(40.0).to_shining * Vec3::new(-1.0, 1.0, 1.0)) < 1e-5);
    }
}
