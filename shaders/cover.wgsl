// Where trees are: depth alone, so that the colour pass after it shades every pixel once. On software rendering a discarded
// pixel costs as much as a shaded one.

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let cover = sharpened(textureSample(leaves, leaf_sampler, in.uv, in.layer).r);
    if cover < LEAST_COVER || gone(in.clip.xy, in.tint.w) {
        discard;
    }
    return vec4f(0.0, 0.0, 0.0, cover);
}
