// Functions shared by road, land and buildings.

// Returns the share of a pixel of width `wide` that lies within `half` of a line's centre, at distance `off` from it.
fn covered(off: f32, half: f32, wide: f32) -> f32 {
    let w = max(wide, 0.002);
    return clamp((min(off + 0.5 * w, half) - max(off - 0.5 * w, -half)) / w, 0.0, 1.0);
}

// Returns grain at a grazing angle. Its detail lies half way between the width and the length of the pixel's footprint.
fn grain_aslant(uv: vec2f) -> vec4f {
    let dx = dpdx(uv);
    let dy = dpdy(uv);
    let a = max(length(dx), 1e-6);
    let b = max(length(dy), 1e-6);
    let short = min(a, b);
    let kept = min(1.0, 1.3 * sqrt(short / max(a, b)));
    return textureSampleGrad(grain, grain_sampler, uv, dx * select(1.0, kept, a > b) * 0.7, dy * select(1.0, kept, b > a) * 0.7);
}
