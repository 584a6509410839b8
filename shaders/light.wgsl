// Sun, sky and haze (`render/sky/mod.rs`). The unit of radiance is about that of a white sheet in full daylight at 10 h. The proportions
// are those of a photograph: sky overhead 0.1 to 0.4, horizon 0.6, asphalt 0.1, meadow 0.1.

const PI = 3.14159265;
// Radius of the horizon in the sky's picture, see `RIM` in `render/sky/atmosphere.rs`.
const RIM = 0.96;

// Returns the light from a direction of the cloudless sky, blurred by mip levels of its picture.
fn sky_light_blurred(direction: vec3f, level: f32) -> vec3f {
    return textureSampleLevel(sky, sky_sampler, sky_place(direction), level).rgb;
}

// Returns the place of a direction in the sky's picture; directions below the horizon get the place on the horizon.
fn sky_place(direction: vec3f) -> vec2f {
    let up = clamp(direction.z, 0.0, 1.0);
    let flat_way = direction.xy * inverseSqrt(max(dot(direction.xy, direction.xy), 1e-12));
    return 0.5 + 0.5 * RIM * flat_way * sqrt((1.0 - up) / (1.0 + up));
}

fn sky_light(direction: vec3f) -> vec3f {
    return sky_light_blurred(direction, 0.0);
}

// Returns the light of sky and land on a white sheet in the open that faces `normal`.
fn ambient(normal: vec3f) -> vec3f {
    let n = normal;
    var light = air.harmonics[0].rgb + n.y * air.harmonics[1].rgb + n.z * air.harmonics[2].rgb + n.x * air.harmonics[3].rgb;
    light += n.x * n.y * air.harmonics[4].rgb + n.y * n.z * air.harmonics[5].rgb;
    light += (3.0 * n.z * n.z - 1.0) * air.harmonics[6].rgb + n.x * n.z * air.harmonics[7].rgb;
    light += (n.x * n.x - n.y * n.y) * air.harmonics[8].rgb;
    return max(light, vec3f(0.0));
}

// Returns the light that a surface of this roughness mirrors from a direction: sky, a dark belt of trees, ground.
fn mirrored(direction: vec3f, ground: vec3f, rough: f32) -> vec3f {
    let above = sky_light_blurred(direction, 5.0 * sqrt(rough));
    let belt = vec3f(0.055, 0.075, 0.035) * ambient(vec3f(0.0, 0.0, 1.0)) * 2.0 + 0.12 * above;
    let soft = 0.5 * rough;
    let over_ground = mix(belt, above, smoothstep(0.06 - soft, 0.17 + soft, direction.z));
    return mix(ground, over_ground, smoothstep(-0.05 - soft, 0.02 + soft, direction.z));
}

// Above 0.5, a shadow map is sampled as a mean of 4 by 4 texels, else of 2 by 2, which costs less. `shadow_layer` returns the share of the
// sun that a map lets through at a place in it (xy clip coordinates, z depth; w the distance from its centre, 1 at the edge); all of it
// beyond the edge.
override SOFT: f32 = 1.0;
// Share of the sun that a crown lets through to the ground.
const FLECKS = 0.16;

fn shadow_layer(layer: i32, at: vec4f) -> f32 {
    let uv = at.xy * vec2f(0.5, -0.5) + 0.5;
    var lit = 0.0;
    if SOFT > 0.5 {
        let step = 0.75 / frame.shadow.w;
        lit += 0.25 * textureSampleCompareLevel(shadow_maps, shadow_sampler, uv + vec2f(-step, -0.35 * step), layer, at.z);
        lit += 0.25 * textureSampleCompareLevel(shadow_maps, shadow_sampler, uv + vec2f(0.35 * step, -step), layer, at.z);
        lit += 0.25 * textureSampleCompareLevel(shadow_maps, shadow_sampler, uv + vec2f(step, 0.35 * step), layer, at.z);
        lit += 0.25 * textureSampleCompareLevel(shadow_maps, shadow_sampler, uv + vec2f(-0.35 * step, step), layer, at.z);
    } else {
        lit = textureSampleCompareLevel(shadow_maps, shadow_sampler, uv, layer, at.z);
    }
    return mix(lit, 1.0, smoothstep(0.9, 0.99, at.w));
}

// Returns the share of sunlight that arrives, 0 to 1. Without branches, as software rendering executes both sides. `cars` is a constant:
// true if moving vehicles can cast a shadow here.
fn sunshine_past(world: vec3f, normal: vec3f, cars: bool) -> f32 {
    let x = frame.light_from_world[0].xyz;
    let y = frame.light_from_world[1].xyz;
    let z = frame.light_from_world[2].xyz;
    let p = vec3f(dot(x, world), dot(y, world), dot(z, world));
    let facing = vec3f(dot(x, normal), dot(y, normal), dot(z, normal));
    // Offset from the surface by texels, against shadow acne; it is larger where the sun grazes. The view looks along the sunlight, down
    // -z.
    let off = facing * (2.3 - 1.6 * clamp(facing.z, 0.0, 1.0));
    let near = (p + off * frame.shadow.y) * frame.light_scale[1].xyz + frame.light_shift[1].xyz;
    let far = (p + off * frame.shadow.z) * frame.light_scale[2].xyz + frame.light_shift[2].xyz;
    let beyond = max(abs(near.x), abs(near.y)) > 0.9;
    let standing = select(near, far, beyond);
    let layer = i32(select(frame.light_shift[1].w, frame.light_shift[2].w, beyond));
    let trees = shadow_layer(layer, vec4f(standing, max(abs(standing.x), abs(standing.y)) - select(1.0, 0.0, beyond)));
    // Shade under trees has flecks of sun, and light through leaves.
    let dappled = mix(FLECKS, 1.0, trees);
    if !cars {
        return trees;
    }
    let moving = (p + off * frame.shadow.x) * frame.light_scale[0].xyz + frame.light_shift[0].xyz;
    return min(shadow_layer(0, vec4f(moving, max(abs(moving.x), abs(moving.y)))), dappled);
}

fn sunshine(world: vec3f, normal: vec3f) -> f32 {
    return sunshine_past(world, normal, true);
}

// Returns the share of sunlight on a tree, which no vehicle shades.
fn sunshine_in_trees(world: vec3f, normal: vec3f) -> f32 {
    return sunshine_past(world, normal, false);
}

// Returns the roughness increased by the variation of the normal within a pixel, so that small bright reflections neither flicker nor crawl
// (after Tokuyoshi and Kaplanyan 2019).
fn steadied(rough: f32, normal: vec3f) -> f32 {
    let dx = dpdx(normal);
    let dy = dpdy(normal);
    let spread = min(0.5 * (dot(dx, dx) + dot(dy, dy)), 0.18);
    let a = rough * rough;
    return sqrt(sqrt(clamp(a * a + spread, 0.0, 1.0)));
}

// Returns the microfacet reflection of the sun (GGX; Walter et al. 2007; Smith visibility after Karis 2013), times the cosine. `edge` is
// the reflectance at grazing angles: 1, but 0 under a clear coat, which light passes steeply.
fn sun_gloss(normal: vec3f, view: vec3f, rough: f32, f0: vec3f, edge: f32) -> vec3f {
    let sun = frame.to_sun_time.xyz;
    let half_way = normalize(view + sun);
    let nh = clamp(dot(normal, half_way), 0.0, 1.0);
    let nl = clamp(dot(normal, sun), 0.0, 1.0);
    let nv = clamp(dot(normal, view), 0.02, 1.0);
    let a = max(rough * rough, 0.004);
    let d = nh * nh * (a * a - 1.0) + 1.0;
    let k = 0.5 * a;
    let shape = a * a / (d * d) * 0.25 / ((nl * (1.0 - k) + k) * (nv * (1.0 - k) + k));
    let x = 1.0 - clamp(dot(view, half_way), 0.0, 1.0);
    let x2 = x * x;
    let f = f0 + (1.0 - f0) * (edge * x2 * x2 * x);
    return min(SUN * (shape * nl) * f, vec3f(14.0));
}

fn sun_glint(normal: vec3f, view: vec3f, roughness: f32, f0: f32) -> vec3f {
    return sun_gloss(normal, view, roughness, vec3f(f0), 1.0);
}

// Returns the share of uniform surroundings that a rough surface mirrors: scale and offset of its reflectance at normal incidence (the fit
// of Karis 2014 to the integral of the microfacet model).
fn mirrors(normal: vec3f, view: vec3f, rough: f32) -> vec2f {
    let nv = clamp(dot(normal, view), 0.0, 1.0);
    let r = rough * vec4f(-1.0, -0.0275, -0.572, 0.022) + vec4f(1.0, 0.0425, 1.04, -0.04);
    let a = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
    return vec2f(-1.04, 1.04) * a + r.zw;
}

fn fresnel(normal: vec3f, view: vec3f, f0: f32) -> f32 {
    let x = 1.0 - clamp(dot(normal, view), 0.0, 1.0);
    let x2 = x * x;
    return f0 + (1.0 - f0) * x2 * x2 * x;
}

// Adds the air between a surface and the eye: far land fades into the horizon.
fn through_air(colour: vec3f, world: vec3f) -> vec3f {
    return through_air_over(colour, world, 1.0);
}

// Adds the air between the eye and a surface that hides this share of the picture behind it. That picture already contains the light of its own
// air, so that the surface adds its share alone: a pane in thick fog is as bright as the fog.
fn through_air_over(colour: vec3f, world: vec3f, hidden: f32) -> vec3f {
    if FROM_ABOVE {
        return colour;
    }
    let ray = world - frame.eye.xyz;
    let distance = length(ray);
    let left = through_air_from(distance);
    let way = vec3f(ray.xy, max(ray.z, 0.0) + 0.01 * distance) / max(distance, 0.01);
    var veil: vec3f;
    if SOFT > 0.5 {
        veil = sky_light(way);
    } else {
        // One unfiltered texel: in haze the borders of texels are invisible, and each texel costs time in software rendering.
        veil = textureLoad(sky, vec2i(sky_place(way) * vec2f(textureDimensions(sky))), 0).rgb;
        // In thick fog they would be visible, but there its light is known (`Fog` in `render/sky/atmosphere.rs`).
        veil = mix(veil, air.fog.rgb * ((1.0 + 2.0 * way.z) / 3.0), air.fog.w);
    }
    return mix(hidden * veil, colour, left);
}
