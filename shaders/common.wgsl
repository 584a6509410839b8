// Shared inputs of all programs of the scene: the camera's uniform, the shadow maps, the grain.

// Beam of a vehicle's headlamps, and the vehicle that stands in it.
struct Beam {
    // xyz position of the lamps, metres; w distance to that vehicle
    place: vec4f,
    // xyz unit vector ahead; w tangent of the vehicle's bearing, positive along `inner`
    ahead: vec4f,
    // xyz unit vector towards the oncoming traffic; w tangent of half of the angle that the vehicle takes, 0 without one
    inner: vec4f,
    // x share of its light, less than 1 for the last of the nearest beams; y 1 with the main beam, else 0
    share: vec4f,
}

struct Frame {
    clip_from_world: mat4x4f,
    // Rows of the transform from the world into the sun's view. Place and depth in a shadow map are that, scaled and shifted. The shift has
    // the map's layer in w.
    light_from_world: array<vec4f, 3>,
    light_scale: array<vec4f, 3>,
    light_shift: array<vec4f, 3>,
    // xyz eye position; w 1 for a perspective lens, 0 for a parallel one
    eye: vec4f,
    // w: speed of the wind, m/s
    forward: vec4f,
    right: vec4f,
    up: vec4f,
    // xyz unit direction to the sun, or to the moon after sunset; w seconds
    to_sun_time: vec4f,
    // xyz width of a shadow texel in metres (moving objects, static objects near by, static objects far away); w texels per side
    shadow: vec4f,
    // x radiance of a dipped head lamp, 0 if off; y factor on the light that lamps show; z radiance of a white sheet in a light of 1 lx;
    // w height of the highest street lamp over the lowest, m
    lamps: vec4f,
    // xyz velocity of the eye, m/s; w intensity of the rain, mm/h
    motion: vec4f,
    // x time from the begin of a sweep of the wipers to the next, y duration of a sweep, s
    wipers: vec4f,
    // xy south-west corner of the picture of the street lamps' light, m; z 1 over its side, 1/m; w height of the lowest lamp, m
    street_lamps: vec4f,
    beams: array<Beam, 16>,
}

// The light of the hour (`render/sky/mod.rs`).
struct Air {
    // rgb: extinction of a view along the ground, 1/m
    extinction: vec4f,
    // rgb: radiance of thick fog at the zenith; w 1 in thick fog, 0 without fog
    fog: vec4f,
    // Spherical harmonics of the light on a white sheet by its normal, without the sun.
    harmonics: array<vec4f, 9>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var shadow_maps: texture_depth_2d_array;
@group(0) @binding(2) var shadow_sampler: sampler_comparison;
@group(0) @binding(3) var grain: texture_2d<f32>;
@group(0) @binding(4) var grain_sampler: sampler;
@group(0) @binding(5) var<uniform> air: Air;
// Radiance of a white sheet that faces the sun, or the moon after sunset.
@group(0) @binding(6) var<uniform> SUN: vec3f;
@group(0) @binding(7) var sky: texture_2d<f32>;
@group(0) @binding(8) var sky_sampler: sampler;

// True for a parallel lens from above, with no air between. It is a constant, as software rendering executes both sides of a branch.
override FROM_ABOVE: bool = false;

// Speed of a falling drop of 2 mm, m/s.
const FALL = 6.5;

// An instance: rows of the mesh-to-world transform; paint; for vehicles, w has the number on the plates plus half of the brake lamps'
// light.
struct Placed {
    @location(5) x: vec4f,
    @location(6) y: vec4f,
    @location(7) z: vec4f,
    @location(8) colour_brake: vec4f,
}

fn place(at: Placed, p: vec3f) -> vec3f {
    let q = vec4f(p, 1.0);
    return vec3f(dot(at.x, q), dot(at.y, q), dot(at.z, q));
}

fn turn(at: Placed, n: vec3f) -> vec3f {
    return vec3f(dot(at.x.xyz, n), dot(at.y.xyz, n), dot(at.z.xyz, n));
}

// Returns the grain: r grit, g clouds, b cracks, a streaks. It fades to its mean with distance by the texture's mip levels.
fn grain_at(uv: vec2f) -> vec4f {
    // Slightly sharper than the filter's choice: on asphalt and grass some shimmer is less visible than blur.
    return textureSampleBias(grain, grain_sampler, uv, -0.6);
}

// Returns 0..1 from an integer, for choices that must be the same in every picture.
fn hash(n: i32) -> f32 {
    var h = u32(n) * 747796405u + 2891336453u;
    h = ((h >> ((h >> 28u) + 4u)) ^ h) * 277803737u;
    return f32((h >> 22u) ^ h) / 4294967295.0;
}

// Returns the unit direction from a point to the eye.
fn to_eye(world: vec3f) -> vec3f {
    if FROM_ABOVE {
        return -frame.forward.xyz;
    }
    return normalize(mix(-frame.forward.xyz, frame.eye.xyz - world, frame.eye.w));
}

// Returns the share of light that comes through the air from a surface at this distance, m.
fn through_air_from(distance: f32) -> vec3f {
    return exp(-air.extinction.rgb * (distance * frame.eye.w));
}

// Returns the corners of a square of half side 1, as two triangles.
fn square_corner(index: u32) -> vec2f {
    let corners = array(vec2f(-1.0, -1.0), vec2f(1.0, -1.0), vec2f(1.0, 1.0), vec2f(-1.0, -1.0), vec2f(1.0, 1.0), vec2f(-1.0, 1.0));
    return corners[index];
}
