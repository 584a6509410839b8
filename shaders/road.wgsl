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

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let normal = normalize(in.normal);
    let view = to_eye(in.world);
    // Grit of 6 mm, stones and stains of 4 cm to 1 m, weathering of metres.
    let fine = grain_at(in.uv / 1.57);
    let coarse = grain_at(in.uv.yx / 9.7 + vec2f(0.13, 0.71));
    let broad = grain_at(in.uv / vec2f(61.0, 23.0));
    let cracks = grain_at(in.uv / vec2f(8.3, 6.1) + vec2f(0.4, 0.2)).b;
    let repair = patch_at(in.uv);

    let off = abs(abs(in.uv.y) - TRACK);
    let track = exp(-off * off / 0.075);
    let drip = exp(-in.uv.y * in.uv.y / 0.09);
    let grit = 0.55 * (fine.r - 0.5) + 0.42 * (coarse.r - 0.5);
    // The mesh's own colour already has the tracks and the pale edge.
    var tone = 1.0 + grit + 0.50 * (coarse.g - 0.5) + 0.45 * (broad.g - 0.5);
    tone *= 1.0 - 0.15 * track - 0.09 * drip * (0.6 + 0.8 * coarse.g);
    tone *= 1.0 - 0.45 * (1.0 - cracks) * smoothstep(0.42, 0.62, broad.g);
    tone = mix(tone, tone * 0.74, repair.x) * (1.0 - 0.55 * repair.y);
    let asphalt = in.colour * vec3f(1.09, 1.03, 0.93) * max(tone, 0.15);

    // Paint rubbed off on the tops of the grit.
    let worn = smoothstep(0.22, 0.5, 0.62 * coarse.g + 0.38 * fine.r + 0.06);
    let marking = mix(vec3f(0.11) * tone, in.colour * (0.93 + 0.14 * (coarse.g - 0.5)), 0.25 + 0.75 * worn);

    var albedo = in.colour * (1.0 + 0.7 * (fine.r - 0.5) + 0.9 * (coarse.r - 0.5) + 0.5 * (coarse.g - 0.5));
    albedo = select(albedo, asphalt, in.material == ASPHALT);
    albedo = select(albedo, marking, in.material == MARKING);

    let sun = sunshine(in.world, normal);
    let cosine = clamp(dot(normal, frame.to_sun_time.xyz), 0.0, 1.0);
    var light = albedo * (SUN * cosine * sun + ambient(normal));
    // Polished tracks shine more; all asphalt does at a flat angle.
    let gloss = select(0.0, 1.0, in.material == ASPHALT || in.material == MARKING);
    let mirror = fresnel(normal, view, 0.02) * 0.17 * gloss;
    light += mirror * (0.75 + 0.5 * track) * sky_light(vec3f(-view.xy, abs(view.z)));
    light += sun_glint(normal, view, 0.62 - 0.1 * track, 0.035) * sun * gloss;
    return vec4f(through_air(light, in.world), 1.0);
}
