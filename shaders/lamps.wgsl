// Light of headlamps (`render/headlamps.rs`) and of street lamps (`render/textures/lamp_light.rs`).

// The street lamps' light from above: r square root of its share in MOST_LX, g height of the lamps over the lowest.
@group(0) @binding(12) var street_light: texture_2d<f32>;

// Number of beams, a constant: software rendering would compile a loop up to a uniform again with every draw. 0 by day, when their light
// is invisible, and costs nothing.
override BEAMS: i32 = 0;
// Colour of the light beside daylight.
const LAMPLIGHT = vec3f(1.05, 1.0, 0.88);
// Intensity of a pair of lamps just below the cut-off, and above it, cd (docs/references.md: night).
const HOT = 35500.0;
const STRAY = 500.0;

// Returns the intensity of a pair of dipped headlamps, cd, by the tangents of bearing (positive towards the oncoming traffic) and elevation.
fn dipped(bearing: f32, up: f32) -> f32 {
    // The cut-off lies 1 % below the horizon, and rises by 15 degrees on the outer side.
    let below = clamp(-0.268 * bearing, 0.0, 0.035) - 0.010 - up;
    let aside = bearing + 0.03;
    let wide = 1.0 / (1.0 + 8.2 * aside * aside);
    let hot = HOT * wide * wide / (1.0 + 55.0 * max(below, 0.0));
    return mix(STRAY * wide, hot, smoothstep(-0.004, 0.004, below));
}

// Intensity of a pair of main beams straight ahead, cd (docs/references.md: night).
const MAIN = 90000.0;

// Returns the intensity of a pair of main beams, which are as wide as high, cd, by the tangents of bearing and elevation.
fn main_beam(bearing: f32, up: f32) -> f32 {
    let off = (bearing * bearing + 3.0 * up * up) / (0.05 * 0.05);
    return MAIN / pow(1.0 + off, 1.3);
}

// Returns the light of a beam at a place: xyz unit direction towards the lamps, w illuminance of a sheet that faces them, lx.
fn beam_at(beam: Beam, world: vec3f) -> vec4f {
    let way = world - beam.place.xyz;
    let ahead = dot(way, beam.ahead.xyz);
    let aside = dot(way, beam.inner.xyz);
    let up = way.z - ahead * beam.ahead.z - aside * beam.inner.z;
    let slope = 1.0 / max(ahead, 0.5);
    // The vehicle in the beam shades what is behind its rear.
    let off = abs(aside * slope - beam.ahead.w);
    let shaded = (1.0 - smoothstep(0.75 * beam.inner.w, 1.05 * beam.inner.w + 0.001, off))
        * smoothstep(0.4, 1.2, ahead - beam.place.w) * step(up * slope, 0.8 / max(beam.place.w, 0.5));
    let square = max(dot(way, way), 1.0);
    let distance = sqrt(square);
    let through = exp(-air.extinction.g * distance);
    let intensity = dipped(aside * slope, up * slope) + beam.share.y * main_beam(aside * slope, up * slope);
    let lux = beam.share.x * intensity * smoothstep(0.0, 0.5, ahead) * (1.0 - shaded) * through / square;
    return vec4f(-way / distance, lux);
}

// Colour of street lamps beside daylight, and the light of a full texel, lx.
const STREET = vec3f(1.14, 0.97, 0.74);
const MOST_LX = 40.0;

// Returns the light of street lamps, lx: on level ground that of their picture, less on walls, none above the lamps.
fn street_light_at(world: vec3f, normal: vec3f, rough: f32) -> f32 {
    let place = (world.xy - frame.street_lamps.xy) * frame.street_lamps.z;
    let found = textureSampleLevel(street_light, grain_sampler, place, 0.0);
    let there = step(max(abs(place.x - 0.5), abs(place.y - 0.5)), 0.5);
    let over = world.z - frame.street_lamps.w - found.g * frame.lamps.w;
    let below = 1.0 - smoothstep(-0.6, 0.4, over);
    let faces = mix(0.45 + 0.55 * max(normal.z, 0.0), 1.0, 0.5 * rough);
    return MOST_LX * found.r * found.r * there * below * faces;
}

// Returns the light of all beams and of street lamps on a white sheet; the rougher the surface, the less it matters which way it faces.
fn lamplight(world: vec3f, normal: vec3f, rough: f32) -> vec3f {
    var lux = 0.0;
    if !FROM_ABOVE {
        for (var i = 0; i < BEAMS; i++) {
            let light = beam_at(frame.beams[i], world);
            lux += light.w * mix(max(dot(light.xyz, normal), 0.0), 1.0, rough);
        }
    }
    var street = 0.0;
    if BEAMS > 0 && !FROM_ABOVE {
        street = street_light_at(world, normal, rough);
    }
    return (LAMPLIGHT * lux + STREET * street) * frame.lamps.z;
}

// Returns the light that retroreflecting sheeting returns to the eye, as radiance of a white one. Sheeting of class RA1 has 70 cd/lx/m2 at
// 0.2 degrees between lamp and eye, 50 at 0.33 and 5 at 2 degrees.
fn returned_light(world: vec3f, view: vec3f) -> vec3f {
    var luminance = 0.0;
    if !FROM_ABOVE {
        for (var i = 0; i < BEAMS; i++) {
            let light = beam_at(frame.beams[i], world);
            let apart = 2.0 * max(1.0 - dot(light.xyz, view), 0.0);
            luminance += light.w * 75.0 / (1.0 + apart / 9.2e-5);
        }
    }
    return LAMPLIGHT * (PI * luminance * frame.lamps.z);
}
