// Where far trees are: depth alone, see `cover.wgsl`.

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let there = textureSample(pictures, leaf_sampler, in.uv, chosen(in)).a;
    let cover = clamp((there - 0.5) / max(0.88 * fwidth(there), 0.07) + 0.5, 0.0, 1.0);
    if cover < LEAST_COVER || gone(in.clip.xy, in.tint.w) {
        discard;
    }
    return vec4f(0.0, 0.0, 0.0, cover);
}
