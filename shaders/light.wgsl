// Sun, sky and haze of a clear late morning. Radiance is in units of a white sheet lying in full daylight (1.0), which
// keeps the proportions of a photograph: sky overhead 0.1 to 0.4, horizon 0.6, asphalt 0.1, meadow 0.1.

const PI = 3.14159265;
// Radiance of a white sheet that faces the sun.
const SUN = vec3f(1.26, 1.15, 0.96);
const ZENITH = vec3f(0.095, 0.205, 0.47);
const MIDDLE = vec3f(0.21, 0.36, 0.62);
const HORIZON = vec3f(0.53, 0.64, 0.76);
// Irradiance (over pi) of the sky from above, of sky and land from the side, of the land from below.
const FROM_ABOVE = vec3f(0.245, 0.305, 0.40);
const FROM_BELOW = vec3f(0.095, 0.10, 0.065);
// Distance at which haze takes 63 % of a surface's contrast, metres.
const HAZE_M = 1100.0;

// Light from a direction of the cloudless sky; below the horizon, that of the horizon.
fn sky_light(direction: vec3f) -> vec3f {
    let height = max(direction.z, 0.0);
    let low = exp(-7.0 * height);
    let clear = mix(mix(ZENITH, MIDDLE, exp(-2.2 * height)), HORIZON, low);
    let toward_sun = max(dot(direction, frame.to_sun_time.xyz), 0.0);
    let t2 = toward_sun * toward_sun;
    let t8 = t2 * t2 * t2 * t2;
    let t32 = t8 * t8 * t8 * t8;
    let glow = 0.10 * t2 + 0.16 * t8 + 0.6 * t32 * t32 * t32;
    return clear + glow * vec3f(1.0, 0.9, 0.74) * (0.45 + 0.55 * low);
}

// Light from the surroundings without looking: sky, a dark belt of trees, ground. For reflections.
fn surroundings(direction: vec3f, ground: vec3f) -> vec3f {
    let belt = vec3f(0.045, 0.062, 0.035) + 0.12 * HORIZON;
    let above = mix(belt, sky_light(direction), smoothstep(0.05, 0.16, direction.z));
    return mix(ground, above, smoothstep(-0.06, 0.02, direction.z));
}

// Irradiance (over pi) from sky and ground on a surface in the open.
fn ambient(normal: vec3f) -> vec3f {
    let side = 0.5 * (FROM_ABOVE + FROM_BELOW);
    let up = normal.z;
    return select(mix(side, FROM_BELOW, -up), mix(side, FROM_ABOVE, up), up > 0.0);
}

fn shadow_layer(layer: i32, world: vec3f, normal: vec3f) -> f32 {
    let texel = select(frame.shadow.y, frame.shadow.x, layer == 0);
    // Off the surface, against acne: further where the sun grazes.
    let grazing = 1.0 - clamp(dot(normal, frame.to_sun_time.xyz), 0.0, 1.0);
    let p = world + normal * texel * (0.7 + 1.6 * grazing);
    let clip = frame.light_from_world[layer] * vec4f(p, 1.0);
    let uv = clip.xy * vec2f(0.5, -0.5) + 0.5;
    let step = 0.75 / frame.shadow.z;
    var sum = 0.0;
    sum += textureSampleCompareLevel(shadow_maps, shadow_sampler, uv + vec2f(-step, -0.35 * step), layer, clip.z);
    sum += textureSampleCompareLevel(shadow_maps, shadow_sampler, uv + vec2f(0.35 * step, -step), layer, clip.z);
    sum += textureSampleCompareLevel(shadow_maps, shadow_sampler, uv + vec2f(step, 0.35 * step), layer, clip.z);
    sum += textureSampleCompareLevel(shadow_maps, shadow_sampler, uv + vec2f(-0.35 * step, step), layer, clip.z);
    // Fade out where the map ends.
    let edge = max(abs(clip.x), abs(clip.y));
    return mix(sum * 0.25, 1.0, smoothstep(0.9, 0.99, edge));
}

// How much of the sun arrives: 1 all, 0 none.
fn sunshine(world: vec3f, normal: vec3f) -> f32 {
    return min(shadow_layer(0, world, normal), shadow_layer(1, world, normal));
}

// Microfacet reflection of the sun (GGX; Walter et al. 2007; Smith visibility after Karis 2013), times the cosine.
fn sun_glint(normal: vec3f, view: vec3f, roughness: f32, f0: f32) -> vec3f {
    let sun = frame.to_sun_time.xyz;
    let half_way = normalize(view + sun);
    let nh = clamp(dot(normal, half_way), 0.0, 1.0);
    let nl = clamp(dot(normal, sun), 0.0, 1.0);
    let nv = clamp(dot(normal, view), 0.02, 1.0);
    let a = roughness * roughness;
    let d = nh * nh * (a * a - 1.0) + 1.0;
    let k = 0.5 * a;
    let shape = a * a / (d * d) * 0.25 / ((nl * (1.0 - k) + k) * (nv * (1.0 - k) + k));
    let f = f0 + (1.0 - f0) * pow(1.0 - clamp(dot(view, half_way), 0.0, 1.0), 5.0);
    return min(SUN * (shape * f * nl), vec3f(14.0));
}

fn fresnel(normal: vec3f, view: vec3f, f0: f32) -> f32 {
    let x = 1.0 - clamp(dot(normal, view), 0.0, 1.0);
    let x2 = x * x;
    return f0 + (1.0 - f0) * x2 * x2 * x;
}

// The air between a surface and the eye: far land melts into the horizon.
fn through_air(colour: vec3f, world: vec3f) -> vec3f {
    let ray = world - frame.eye.xyz;
    let distance = length(ray);
    let reach = distance / HAZE_M;
    // Blue fades in first, as in air.
    let veil = (1.0 - exp(-reach * sqrt(reach) * vec3f(0.9, 1.0, 1.15))) * frame.eye.w;
    let air = sky_light(normalize(vec3f(ray.xy, max(ray.z, 0.0) + 0.004 * distance)));
    return mix(colour, air, veil);
}
