// Functions shared by road and land.

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
