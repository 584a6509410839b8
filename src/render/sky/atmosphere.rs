//! The light of the sky by atmospheric scattering, on the CPU. In: the direction to the sun and the visibility. Out:
//! the light of sun or moon, the sky's light by direction and as harmonics for surfaces, and the extinction along a
//! horizontal view.
//!
//! Rayleigh scattering, haze and ozone in a spherical atmosphere: single scattering along each ray, all higher orders
//! by the closed sum of Hillaire 2020 (A Scalable and Production Ready Sky and Atmosphere Rendering Technique, section
//! 5.5). The amount of haze follows from the visibility by Koschmieder 1924: a contrast of 2 % is left at that
//! distance. Below 1 km a layer of fog lies under the hazy air, whose light is that of an overcast sky. Lengths inside are
//! kilometres; radiance is in units of about a white sheet in full daylight.

use super::twilight::{DUSK, LUX, SkyLight, adaptation, to_shining};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};

/// Side of the sky's picture, texels; a power of two.
pub const SIZE: usize = 64;
/// Radius of the horizon in that picture as a share of half its side; beyond it the horizon continues, for the filter.
pub const RIM: f32 = 0.96;

/// Radiance of a white sheet that faces the sun above the atmosphere, for a camera balanced for daylight at the ground.
const SUN: Vec3 = Vec3::new(1.56, 1.70, 1.86);
/// Radii of the ground and of the top of the atmosphere.
const GROUND_KM: f32 = 6360.0;
const TOP_KM: f32 = 6440.0;
/// Rayleigh scattering at the ground, 1/km, at 680, 550 and 440 nm, and its scale height (Hillaire 2020, table 1, as in
/// Bruneton 2017). Together they give an optical depth a tenth above the measured one (Hansen and Travis 1974).
const RAYLEIGH: Vec3 = Vec3::new(5.802e-3, 13.558e-3, 33.1e-3);
const RAYLEIGH_KM: f32 = 8.0;
/// Absorption of ozone at an altitude of 25 km, 1/km (the same table).
const OZONE: Vec3 = Vec3::new(0.650e-3, 1.881e-3, 0.085e-3);
/// Haze: colour of its extinction, scattering albedo, asymmetry (Henyey-Greenstein), scale height. The colour is an
/// Angstrom exponent of 0.25, for coarse grains: finer ones would make the air around a low sun white, although its own
/// light is yellow.
const HAZE: Vec3 = Vec3::new(0.95, 1.0, 1.06);
const HAZE_ALBEDO: f32 = 0.92;
const HAZE_FORWARD: f32 = 0.76;
const HAZE_KM: f32 = 1.2;
/// Visibility below which there is fog, by its definition, and height of its layer.
const FOG_BELOW_KM: f32 = 1.0;
const FOG_KM: f32 = 0.4;
/// Optical depth of rain clouds: a fifth of the light of a high sun arrives (docs/references.md: rain).
const RAIN_CLOUDS: f32 = 40.0;
/// Asymmetry of the scattering by droplets.
const FOG_FORWARD: f32 = 0.85;
/// Albedo of the land.
const LAND: Vec3 = Vec3::new(0.115, 0.135, 0.065);
/// Number of tabulated altitudes, from the ground to the top, denser near the ground.
const LEVELS: usize = 40;
/// Weights of the luminance of a colour.
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Light at one time of day.
#[derive(Clone, Debug)]
pub struct Sky {
    /// Unit direction towards the sun.
    pub to_sun: Vec3,
    /// Distance at which 2 % of a contrast is left, m.
    pub visibility_m: f32,
    /// True under a closed layer of rain clouds.
    pub is_overcast: bool,
    /// Unit direction towards the light that casts shadows, the sun or the moon.
    pub to_shining: Vec3,
    /// Radiance of a white sheet that faces that light, without the sky's.
    pub sun: Vec3,
    /// Extinction along a horizontal view at the ground, 1/m.
    pub extinction_per_m: Vec3,
    /// Coefficients of 1, y, z, x, xy, yz, 3z^2 - 1, xz, x^2 - y^2 for the radiance of a white sheet that faces (x, y,
    /// z), without the sun: sky above, sunlit land below.
    pub harmonics: [Vec3; 9],
    /// Factor on all light; maps the current daylight near the middle of the scale.
    pub exposure: f32,
    /// Radiance of a white sheet in a light of 1 lx. All radiance here is raised by a gain, by day 1, because pictures hold no light as weak as
    /// that of a night.
    pub one_lux: f32,
    /// Radiance of a white sheet on the ground, without the gain.
    daylight: f32,
    gain: f32,
    /// Air as each light in the sky fills it, and its share of a sun's light.
    airs: Vec<(AtmosphereTables, f32)>,
    fog: Fog,
}

/// Layer of fog on the ground, with the rain clouds above it.
#[derive(Clone, Copy, Debug, Default)]
struct Fog {
    /// Optical depth, straight up; 0 without fog.
    depth: f32,
    /// Radiance of an infinitely thick layer at the zenith.
    glow: Vec3,
}

impl Fog {
    /// Returns the radiance seen through the layer at an elevation with sine `up`. The layer's own has the distribution of the CIE's overcast sky.
    fn over(&self, clear: Vec3, up: f32) -> Vec3 {
        if self.depth == 0.0 {
            return clear;
        }
        let left = (-self.depth / up.max(1e-3)).exp();
        clear * left + self.glow * ((1.0 - left) * (1.0 + 2.0 * up.max(0.0)) / 3.0)
    }

    /// Returns the share of the light of a sun at an elevation with sine `up` that arrives at the ground, scattered or not: Eddington's
    /// approximation for droplets that absorb nothing, above dark ground.
    fn transmittance(&self, up: f32) -> f32 {
        let direct = (-self.depth / up).exp();
        (2.0 + 3.0 * up + (2.0 - 3.0 * up) * direct) / (4.0 + 3.0 * (1.0 - FOG_FORWARD) * self.depth)
    }
}

/// The atmosphere with its tables.
#[derive(Clone, Debug)]
struct AtmosphereTables {
    to_sun: Vec3,
    /// Haze at the ground: extinction, 1/km, and scale height, km.
    haze: Vec3,
    haze_km: f32,
    /// By altitude: transmitted share of the sun's light, and radiance scattered more than once.
    sun: [Vec3; LEVELS],
    many: [Vec3; LEVELS],
}

impl Sky {
    /// Computes the sky for a sun at `to_sun` and this visibility, clear or under rain clouds.
    pub fn new(to_sun: Vec3, visibility_m: f32, is_overcast: bool) -> Self {
        let (visibility_km, clear_km) = (visibility_m / 1000.0, (visibility_m / 1000.0).max(FOG_BELOW_KM));
        let to_shining = to_shining(to_sun);
        let (mut airs, mut above_fog) = (Vec::new(), Vec3::ZERO);
        for light in SkyLight::of_the_hour(to_sun) {
            let air = AtmosphereTables::new(light.towards, clear_km);
            let [scattered, direct] = light.shares(|| air.on_ground() * LUX);
            above_fog += SUN * air.sun[0] * direct;
            airs.push((air, scattered));
        }
        let fog_per_km = 3.912 / visibility_km - 3.912 / clear_km;
        let clouds = if is_overcast { RAIN_CLOUDS } else { 0.0 };
        let mut fog = Fog { depth: fog_per_km * FOG_KM + clouds, glow: Vec3::ZERO };
        let sun = above_fog * (-fog.depth / to_shining.z).exp();
        const N: usize = 1000;
        let share = 4.0 / N as f32;
        let directions: Vec<Vec3> = sphere(N).collect();
        let clear: Vec<(Vec3, Option<Vec3>)> =
            directions.into_par_iter().map(|d| (d, (d.z > 0.0).then(|| clear_radiance(&airs, d)))).collect();
        let on_ground = |fog: &Fog, share_of_clear: f32| -> Vec3 {
            let above = clear.iter().filter_map(|(d, light)| Some((d, (*light)? * share_of_clear)));
            above.map(|(d, light)| fog.over(light, d.z) * share * d.z).sum()
        };
        if fog.depth > 0.0 {
            let arriving =
                (above_fog * to_shining.z + on_ground(&Fog::default(), 1.0)) * fog.transmittance(to_shining.z);
            let of_a_unit = on_ground(&Fog { glow: Vec3::ONE, ..fog }, 0.0);
            fog.glow = ((arriving - sun * to_shining.z - on_ground(&fog, 1.0)) / of_a_unit).max(Vec3::ZERO);
        }
        let through_fog = |(d, light): (Vec3, Option<Vec3>)| (d, light.map(|light| fog.over(light, d.z) * share));
        let seen: Vec<(Vec3, Option<Vec3>)> = clear.iter().copied().map(through_fog).collect();
        let from_sky: Vec3 = seen.iter().filter_map(|(d, light)| light.map(|light| light * d.z)).sum();
        let land = LAND * (sun * to_shining.z + from_sky);
        let mut harmonics = [Vec3::ZERO; 9];
        for (d, light) in seen {
            let light = light.unwrap_or(land * share);
            // Ramamoorthi and Hanrahan 2001: squares of the basis' factors times the cosine lobe's, over pi.
            let squares = d.x * d.x - d.y * d.y;
            let basis = [1.0, d.y, d.z, d.x, d.x * d.y, d.y * d.z, 3.0 * d.z * d.z - 1.0, d.x * d.z, squares];
            let weight = [0.25, 0.5, 0.5, 0.5, 0.9375, 0.9375, 0.078_125, 0.9375, 0.234_375];
            for k in 0..9 {
                harmonics[k] += light * (basis[k] * weight[k]);
            }
        }
        let daylight = LUMINANCE.dot(sun * to_shining.z + from_sky);
        let (gain, exposure) = adaptation(daylight);
        fog.glow *= gain;
        Self {
            to_sun,
            visibility_m,
            is_overcast,
            to_shining,
            sun: sun * gain,
            extinction_per_m: (airs[0].0.extinction(0.0) + fog_per_km) / 1000.0,
            harmonics: harmonics.map(|harmonic| harmonic * gain),
            exposure,
            one_lux: gain / LUX,
            daylight,
            gain,
            airs,
            fog,
        }
    }

    /// Returns the factor on all light in a picture from above. Such a picture has no sky to compare with and is read
    /// like a map: it keeps less of the evening's darkness, and noon is as light as in other pictures.
    pub fn plan_exposure(&self) -> f32 {
        // Daylight to the power of -0.85 rather than -0.5, in the dark of -1.
        let dusk = self.daylight.max(DUSK);
        1.06 * 1.8 * dusk.powf(-0.85) * (dusk / self.daylight) / self.gain
    }

    /// Returns true if daylight is so weak that the light of headlamps is visible in it.
    pub fn shows_headlamps(&self) -> bool {
        const MOST_LUX: f32 = 5000.0;
        self.daylight * LUX < MOST_LUX
    }

    /// Returns the factor on the light that lamps show in a picture from above: at night its exposure is so long that they would be blots.
    pub fn lamps_in_plans(&self) -> f32 {
        (self.daylight / DUSK * self.gain).min(1.0)
    }

    /// Returns the radiance of the sky in a direction, without the sun's disc; below the horizon, the radiance at the
    /// horizon.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.fog.over(clear_radiance(&self.airs, direction) * self.gain, direction.z)
    }

    /// Returns the radiance of thick fog or clouds at the zenith, and how thick they are: 0 without them, 1 if nothing above is seen through them.
    pub fn fog(&self) -> (Vec3, f32) {
        (self.fog.glow, ((self.fog.depth - 3.0) / 3.0).clamp(0.0, 1.0))
    }

    /// Returns the radiance of a white sheet that faces `normal`, without the sun.
    pub fn ambient(&self, normal: Vec3) -> Vec3 {
        let Vec3 { x, y, z } = normal;
        let basis = [1.0, y, z, x, x * y, y * z, 3.0 * z * z - 1.0, x * z, x * x - y * y];
        self.harmonics.iter().zip(basis).map(|(c, b)| *c * b).sum::<Vec3>().max(Vec3::ZERO)
    }

    /// Returns the sky as a picture of `SIZE` by `SIZE`: the zenith in the middle, east to the right, north downwards.
    pub fn picture(&self) -> Vec<Vec3> {
        let half = SIZE as f32 / 2.0;
        let texel = |i: usize| {
            let at = (Vec2::new((i % SIZE) as f32, (i / SIZE) as f32) + 0.5 - half) / (half * RIM);
            let r2 = at.length_squared().min(1.0);
            let up = (1.0 - r2) / (1.0 + r2);
            let level = (1.0 - up * up).max(0.0).sqrt();
            self.radiance((at.normalize_or_zero() * level).extend(up))
        };
        (0..SIZE * SIZE).into_par_iter().map(texel).collect()
    }
}

/// Returns the radiance of air without fog in a direction.
fn clear_radiance(airs: &[(AtmosphereTables, f32)], direction: Vec3) -> Vec3 {
    airs.iter().map(|(air, share)| air.radiance(direction) * *share).sum()
}

impl AtmosphereTables {
    fn new(to_sun: Vec3, visibility_km: f32) -> Self {
        let haze = (3.912 / visibility_km - RAYLEIGH.y).max(0.002);
        let mut air = Self {
            to_sun,
            haze: HAZE * haze,
            // Dense haze is a shallow layer.
            haze_km: HAZE_KM * (visibility_km / 12.0).clamp(0.2, 1.0),
            sun: [Vec3::ONE; LEVELS],
            many: [Vec3::ZERO; LEVELS],
        };
        for level in 0..LEVELS {
            let depth: Vec3 = air.steps(altitude_km(level), to_sun, 32).map(|(h, step)| air.extinction(h) * step).sum();
            air.sun[level] = (-depth).exp();
        }
        // Multiple scattering varies slowly: computed at a few altitudes, interpolated linearly between them.
        const COARSE: usize = 3;
        for level in (0..LEVELS).step_by(COARSE) {
            air.many[level] = air.scattered_on(altitude_km(level));
        }
        for level in (0..LEVELS - 1).filter(|level| level % COARSE != 0) {
            let below = level / COARSE * COARSE;
            let share = (level - below) as f32 / COARSE as f32;
            air.many[level] = air.many[below].lerp(air.many[below + COARSE], share);
        }
        air
    }

    /// Returns the middle altitude and the length of each piece of a ray, up to the ground or out of the atmosphere.
    fn steps(&self, from_km: f32, direction: Vec3, n: usize) -> impl Iterator<Item = (f32, f32)> + use<> {
        let r = GROUND_KM + from_km;
        let b = r * direction.z;
        let inside = b * b - (r * r - GROUND_KM * GROUND_KM);
        let hits_ground = direction.z < 0.0 && inside > 0.0;
        let end = if hits_ground { -b - inside.sqrt() } else { -b + (b * b - (r * r - TOP_KM * TOP_KM)).sqrt() };
        let place = move |i: f32| end * (i / n as f32).powi(2);
        (0..n).map(move |i| {
            let t = place(i as f32 + 0.5);
            let altitude = (r * r + 2.0 * b * t + t * t).sqrt() - GROUND_KM;
            (altitude.max(0.0), place(i as f32 + 1.0) - place(i as f32))
        })
    }

    /// Returns the scattering of air and haze, 1/km.
    fn scattering(&self, h: f32) -> (Vec3, Vec3) {
        (RAYLEIGH * (-h / RAYLEIGH_KM).exp(), self.haze * (HAZE_ALBEDO * (-h / self.haze_km).exp()))
    }

    fn extinction(&self, h: f32) -> Vec3 {
        self.lost(h, self.scattering(h))
    }

    fn lost(&self, h: f32, (air, haze): (Vec3, Vec3)) -> Vec3 {
        air + haze / HAZE_ALBEDO + OZONE * (1.0 - (h - 25.0).abs() / 15.0).max(0.0)
    }

    /// Returns the light scattered into `direction` along a ray, and the transmitted share; `seen(air, haze, altitude)`
    /// is the light that a kilometre scatters.
    fn gathered(&self, from: f32, direction: Vec3, n: usize, seen: impl Fn(Vec3, Vec3, f32) -> Vec3) -> (Vec3, Vec3) {
        let (mut light, mut left) = (Vec3::ZERO, Vec3::ONE);
        for (h, step) in self.steps(from, direction, n) {
            let (air, haze) = self.scattering(h);
            let extinction = self.lost(h, (air, haze));
            let through = (-extinction * step).exp();
            light += left * seen(air, haze, h) * (Vec3::ONE - through) / extinction;
            left *= through;
        }
        (light, left)
    }

    /// Returns the radiance after two and more scatterings, equal in all directions (Hillaire 2020, equations 5 to 10).
    fn scattered_on(&self, h: f32) -> Vec3 {
        const N: usize = 40;
        let (mut second, mut share) = (Vec3::ZERO, Vec3::ZERO);
        for d in sphere(N) {
            let (light, left) =
                self.gathered(h, d, 12, |air, haze, h| (air + haze) * self.lookup(&self.sun, h) * SUN / 4.0);
            let ground = if d.z < -0.02 { LAND * SUN * self.sun[0] * self.to_sun.z * left } else { Vec3::ZERO };
            second += (light + ground) / N as f32;
            share += self.gathered(h, d, 12, |air, haze, _| air + haze).0 / N as f32;
        }
        second / (Vec3::ONE - share.min(Vec3::splat(0.95)))
    }

    fn radiance(&self, direction: Vec3) -> Vec3 {
        let up = direction.z.max(0.002);
        let level = direction.truncate().normalize_or(Vec2::X) * (1.0 - up * up).max(0.0).sqrt();
        let direction = level.extend(up);
        let cosine = direction.dot(self.to_sun);
        let rayleigh = 3.0 / (16.0 * PI) * (1.0 + cosine * cosine);
        let g = HAZE_FORWARD;
        let haze_phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5));
        let seen = |air: Vec3, haze: Vec3, h: f32| {
            let once = (air * rayleigh + haze * haze_phase) * self.lookup(&self.sun, h) * SUN * PI;
            once + (air + haze) * self.lookup(&self.many, h)
        };
        self.gathered(0.0, direction, 14, seen).0
    }

    /// Returns the radiance of a white sheet on the ground.
    fn on_ground(&self) -> f32 {
        const N: usize = 100;
        let above = sphere(N).filter(|d| d.z > 0.0);
        let from_sky: Vec3 = above.map(|d| self.radiance(d) * (4.0 / N as f32 * d.z)).sum();
        LUMINANCE.dot(SUN * self.sun[0] * self.to_sun.z + from_sky)
    }

    fn lookup(&self, table: &[Vec3; LEVELS], h: f32) -> Vec3 {
        let place = (h / (TOP_KM - GROUND_KM)).clamp(0.0, 1.0).sqrt() * (LEVELS - 1) as f32;
        let below = (place as usize).min(LEVELS - 2);
        table[below].lerp(table[below + 1], place - below as f32)
    }
}

fn altitude_km(level: usize) -> f32 {
    (TOP_KM - GROUND_KM) * (level as f32 / (LEVELS - 1) as f32).powi(2)
}

/// Returns directions that cover the sphere evenly (a spiral of the golden angle).
fn sphere(n: usize) -> impl Iterator<Item = Vec3> {
    (0..n).map(move |i| {
        let z = 1.0 - (2.0 * i as f32 + 1.0) / n as f32;
        let angle = TAU * (i as f32 * 0.618_034).fract();
        (Vec2::from_angle(angle) * (1.0 - z * z).sqrt()).extend(z)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(elevation_deg: f32, visibility_m: f32) -> Sky {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        Sky::new(Vec3::new(cos, 0.0, sin), visibility_m, false)
    }

    fn light(colour: Vec3) -> f32 {
        LUMINANCE.dot(colour)
    }

    #[test]
    fn the_sky_is_blue_above_pale_at_the_horizon_and_bright_around_the_sun() {
        let sky = at(42.0, 20_000.0);
        let [zenith, horizon] = [Vec3::Z, Vec3::Y].map(|d| sky.radiance(d));
        assert!(zenith.z > 2.0 * zenith.x && horizon.z < 1.6 * horizon.x, "{zenith} {horizon}");
        assert!(light(horizon) > 1.5 * light(zenith), "{zenith} {horizon}");
        assert!(light(sky.radiance(sky.to_sun)) > 2.0 * light(zenith));
        // The sky lights shade to between an eighth and a third of full daylight (CIE clear sky, haze of summer).
        let share = light(sky.ambient(Vec3::Z)) / light(sky.ambient(Vec3::Z) + sky.sun * sky.to_sun.z);
        assert!((0.125..0.34).contains(&share), "{share}");
    }

    #[test]
    fn a_low_sun_is_weak_and_red_and_thick_haze_whitens_the_sky() {
        let (noon, evening, haze) = (at(55.0, 40_000.0), at(7.0, 40_000.0), at(55.0, 3000.0));
        assert!(light(evening.sun) < 0.5 * light(noon.sun), "{} {}", evening.sun, noon.sun);
        assert!(evening.sun.x > 1.8 * evening.sun.z && noon.sun.x < 1.4 * noon.sun.z, "{} {}", evening.sun, noon.sun);
        let blue = |sky: &Sky| sky.radiance(Vec3::Z).z / sky.radiance(Vec3::Z).x;
        assert!(blue(&haze) < 0.7 * blue(&noon), "{} {}", blue(&haze), blue(&noon));
        assert!(light(haze.sun) < 0.8 * light(noon.sun));
    }

    #[test]
    fn two_percent_of_a_contrast_is_left_at_the_visibility() {
        for visibility_m in [50.0, 200.0, 3000.0, 20_000.0, 60_000.0] {
            let sky = at(40.0, visibility_m);
            let left = (-sky.extinction_per_m.y * visibility_m).exp();
            assert!((left - 0.02).abs() < 0.001, "{left}");
        }
    }

    #[test]
    fn fog_is_grey_without_a_sun_and_dims_the_day_as_an_overcast_sky() {
        // From thick to dense fog (docs/references.md: fog).
        for visibility_m in [200.0, 100.0, 50.0] {
            let (fog, clear) = (at(42.0, visibility_m), at(42.0, 30_000.0));
            let [below, above] = [Vec3::Y, Vec3::Z].map(|d| fog.radiance(d));
            for light_there in [below, above] {
                let colour = light_there / light(light_there);
                assert!((colour - Vec3::ONE).abs().max_element() < 0.1, "{visibility_m} m: {light_there}");
            }
            let on_ground = |sky: &Sky| light(sky.ambient(Vec3::Z) + sky.sun * sky.to_sun.z);
            // Under overcast skies there are 1,000 to 30,000 lux, with sunshine up to 100,000 (docs/references.md: fog). Thin fog is lighter.
            let share = on_ground(&fog) / on_ground(&clear);
            assert!(
                share > 0.01 && (visibility_m > 60.0 || share < 0.3),
                "{visibility_m} m: {share} of a clear day's light"
            );
            let direct = light(fog.sun) * fog.to_sun.z / on_ground(&fog);
            assert!(direct < 0.02, "{visibility_m} m: {direct} of the light is the sun's own");
        }
    }

    #[test]
    fn fog_lets_through_as_much_light_as_photons_that_are_followed_one_by_one() {
        const PHOTONS: u32 = 20_000;
        for (visibility_m, up) in [(50.0_f32, 0.669_f32), (200.0, 0.669), (100.0, 0.3)] {
            let fog = Sky::new(Vec3::new((1.0 - up * up).sqrt(), 0.0, up), visibility_m, false).fog;
            let mut random = crate::rng::stream(1, "photons");
            let mut unit = || random.uniform(0.0, 1.0) as f32;
            let mut arrived = 0;
            for _ in 0..PHOTONS {
                // Optical depth below the top of the layer, and cosine of the angle from straight down.
                let (mut depth, mut down) = (0.0, up);
                loop {
                    depth -= down * (1.0 - unit()).ln();
                    if !(0.0..fog.depth).contains(&depth) {
                        arrived += u32::from(depth > 0.0);
                        break;
                    }
                    // Henyey and Greenstein's distribution of the angle of scattering, which lies in any plane.
                    let g = FOG_FORWARD;
                    let chord = (1.0 - g * g) / (1.0 - g + 2.0 * g * unit());
                    let cosine = (1.0 + g * g - chord * chord) / (2.0 * g);
                    let aside = ((1.0 - cosine * cosine).max(0.0) * (1.0 - down * down).max(0.0)).sqrt();
                    down = (down * cosine + aside * (TAU * unit()).cos()).clamp(-1.0, 1.0);
                }
            }
            let share = arrived as f32 / PHOTONS as f32;
            // A fifth of a stop is less than the exposure's own choice; the approximation is for thick layers.
            let stops = (fog.transmittance(up) / share).log2();
            assert!(stops.abs() < 0.2, "{visibility_m} m: {share} of the photons, {stops:+} stops");
        }
    }

    #[test]
    fn the_harmonics_are_the_integral_of_the_light_on_a_surface() {
        let sky = at(30.0, 20_000.0);
        let n = 20_000;
        let whole: Vec3 =
            sphere(n).filter(|d| d.z > 0.0).map(|d| sky.radiance(d) * d.z).sum::<Vec3>() * (4.0 / n as f32);
        let error = (sky.ambient(Vec3::Z) / whole - 1.0).abs().max_element();
        assert!(error < 0.03, "{} {whole}", sky.ambient(Vec3::Z));
    }
}
