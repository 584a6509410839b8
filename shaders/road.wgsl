// Asphalt and its markings. uv: metres along and across (0 in the middle of the lane, positive to the left).

// Where wheels run, metres from the middle of the lane.
const TRACK = 0.75;

// One repaired patch in every few stretches of road: 1 inside, and a tar seam in y.
fn patch_at(uv: vec2f) -> vec2f {
    let stretch = 13.0;
    let cell = i32(floor(uv.x / stretch));
    let along = uv.x - f32(cell) * stretch;
    let present = step(hash(cell * 7 + 1), 0.42);
    let start = 1.0 + 6.0 * hash(cell * 7 + 2);
    let end = start + 0.9 + 4.0 * hash(cell * 7 + 3);
    let middle = (hash(cell * 7 + 4) - 0.5) * 2.2;
    let half = 0.35 + 0.8 * hash(cell * 7 + 5);
    // Signed distance into the rectangle.
    let inside = min(min(along - start, end - along), half - abs(uv.y - middle));
    let soft = max(length(fwidth(uv)) * 0.7, 0.01);
    let seam = 1.0 - smoothstep(0.02, 0.02 + soft, abs(inside));
    return vec2f(smoothstep(-soft, soft, inside), seam * 0.03 / (0.03 + soft)) * present;
}

// Share of a pixel that lies within `half` of a line's middle, from which it is `off`, for a pixel `wide`.
fn covered(off: f32, half: f32, wide: f32) -> f32 {
    let w = max(wide, 0.002);
    return clamp((min(off + 0.5 * w, half) - max(off - 0.5 * w, -half)) / w, 0.0, 1.0);
}

// Grain seen at a flat angle: as fine as the pixel is wide rather than as it is long, half way.
fn grain_aslant(uv: vec2f) -> vec4f {
    let dx = dpdx(uv);
    let dy = dpdy(uv);
    let a = max(length(dx), 1e-6);
    let b = max(length(dy), 1e-6);
    let short = min(a, b);
    let kept = min(1.0, 2.2 * sqrt(short / max(a, b)));
    return textureSampleGrad(grain, grain_sampler, uv, dx * select(1.0, kept, a > b) * 0.7, dy * select(1.0, kept, b > a) * 0.7);
}

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let flat_normal = normalize(in.normal);
    let view = to_eye(in.world);
    // Stones of 7 and 15 mm, stains of 4 cm to 1 m, weathering of metres; askew, so that no repetition is seen.
    let fine = grain_aslant(in.uv / 1.83);
    let stones = grain_aslant(vec2f(0.8 * in.uv.x - 0.6 * in.uv.y, 0.6 * in.uv.x + 0.8 * in.uv.y) / 3.7);
    let coarse = grain_at(in.uv.yx / 9.7 + vec2f(0.13, 0.71));
    let broad = grain_at(in.uv / vec2f(61.0, 23.0));
    let cracks = grain_at(in.uv / vec2f(8.3, 6.1) + vec2f(0.4, 0.2)).b;
    let repair = patch_at(in.uv);

    let off = abs(abs(in.uv.y) - TRACK);
    let track = exp(-off * off / 0.075);
    let drip = exp(-in.uv.y * in.uv.y / 0.09);
    // Wheels press the stones into the tar: tracks are smoother and darker.
    let grit = (0.75 * (fine.r - 0.5) + 0.75 * (stones.r - 0.5)) * (1.0 - 0.35 * track) + 0.5 * (coarse.r - 0.5);
    // Some stones are pale.
    let pale = smoothstep(0.72, 0.95, stones.r) * (1.0 - 0.5 * track);
    // The mesh's own colour already has the tracks and the pale edge.
    var tone = 1.0 + grit + 0.35 * pale + 0.55 * (coarse.g - 0.5) + 0.45 * (broad.g - 0.5) + 0.2 * (stones.g - 0.5);
    tone *= 1.0 - 0.17 * track - 0.10 * drip * (0.6 + 0.8 * coarse.g);
    tone *= 1.0 - 0.5 * (1.0 - cracks) * smoothstep(0.42, 0.62, broad.g);
    // A repair is newer: darker, closer grained, with a seam of tar.
    tone = mix(tone, 0.70 + 0.5 * grit + 0.12 * (coarse.g - 0.5), repair.x) * (1.0 - 0.6 * repair.y);
    let line = in.material == MARKING;
    let bare = select(in.colour, vec3f(0.0902, 0.0902, 0.0946), line) * vec3f(1.08, 1.03, 0.95) * max(tone, 0.12);

    // The line, 12 cm wide, 16 cm into its strip: its edge broken by stones, its paint rubbed off on their tops.
    let frayed = in.colour.b - 0.22 + 0.030 * (coarse.g - 0.5) + 0.022 * (stones.r - 0.5);
    let there = covered(frayed, 0.058, fwidth(in.colour.b));
    let worn = smoothstep(0.18, 0.46, 0.55 * coarse.g + 0.25 * fine.r + 0.2 * stones.r + 0.05);
    let paint = in.colour.r * vec3f(1.0, 1.0, 0.96) * (0.92 + 0.20 * (coarse.g - 0.5) + 0.18 * (fine.r - 0.5));
    let marking = mix(bare, paint, there * (0.25 + 0.75 * worn));

    // Gravel, and grass that grows into it from its edge: the verge falls from 0 over -2 cm to -14 cm.
    let p = in.world.xy;
    let blades = grain_at(p / 2.3);
    let outwards = select(-0.5 - 40.0 * in.world.z, 0.3 - 11.0 * (in.world.z + 0.02), in.material == GRASS);
    let grown = smoothstep(-0.12, 0.12, outwards - 0.75 + 0.9 * (coarse.g - 0.5) + 0.9 * (blades.g - 0.5) + 0.5 * (stones.r - 0.5));
    let pebbles = vec3f(0.20, 0.18, 0.148) * (1.0 + 1.1 * (fine.r - 0.5) + 1.2 * (stones.r - 0.5) + 0.5 * (coarse.g - 0.5));
    let grass = vec3f(0.105, 0.158, 0.044) * max(0.35, 1.0 + 1.1 * (blades.a - 0.5) + 0.6 * (stones.r - 0.5) + 0.5 * (coarse.g - 0.5));
    let verge = mix(pebbles, grass, grown);

    let tarred = in.material == ASPHALT || line;
    var albedo = select(verge, bare, tarred);
    albedo = select(albedo, marking, line);

    // Stones stand up from the tar: their sides face this way and that.
    let rough_ground = select(0.5, 0.22 - 0.1 * track, tarred);
    let normal = normalize(flat_normal + rough_ground * vec3f(fine.r - 0.5, stones.r - 0.5, 0.0));
    let sun = sunshine(in.world, flat_normal);
    let cosine = clamp(dot(normal, frame.to_sun_time.xyz), 0.0, 1.0);
    var light = albedo * (SUN * cosine * sun + ambient(normal));
    // Polished tracks shine more; all asphalt does at a flat angle.
    let gloss = select(0.0, 1.0, tarred);
    let rough = steadied(0.66 - 0.1 * track - 0.12 * repair.x, normal);
    let mirror = fresnel(normal, view, 0.02) * 0.16 * gloss;
    light += mirror * (0.75 + 0.5 * track) * sky_light_blurred(vec3f(-view.xy, abs(view.z)), 3.0);
    light += sun_glint(normal, view, rough, 0.035) * sun * gloss;
    return vec4f(through_air(light, in.world), 1.0);
}
