// Depth pass of far trees, see `cover.wgsl`.

// Returns 1 on the picture. From above a tree is drawn on a triangle with corners beyond its picture.
fn on_picture(uv: vec2f) -> f32 {
    return select(0.0, 1.0, !FROM_ABOVE || all(abs(uv - 0.5) <= vec2f(0.5)));
}

// Texels per side of a picture (`SIZE` in `render/textures/impostor.rs`).
const SIDE = 128.0;

// Returns the share of a pixel that the tree covers. Where a pixel has several texels, twigs and gaps are finer than both. As with leaf
// cards, more pixels then let a little light through and fewer hide everything. Where a texel has several pixels, the reverse holds.
fn cover_of(there: f32, uv: vec2f) -> f32 {
    let texels = SIDE * max(length(dpdx(uv)), length(dpdy(uv)));
    let finer = clamp(log2(max(texels, 0.01)), -2.0, 1.0);
    let soft = max(0.88 * (1.0 + finer) * fwidth(there), 0.07);
    return clamp((there - 0.5 - 0.11 * finer) / soft + 0.5, 0.0, 1.0);
}

// Returns the samples of a pixel that the tree covers.
fn drawn_samples(in: Surface) -> u32 {
    let pixel = in.clip.xy;
    var samples = kept(pixel, in.tint.w);
    if SAMPLES == 1u {
        // As in `cover.wgsl`: one sample is covered or not.
        let there = textureSampleBias(pictures, leaf_sampler, in.uv, chosen(in), BLUNTED).a;
        samples &= covered_samples(pixel, on_picture(in.uv) * there, in.tint.w);
    } else if FROM_ABOVE {
        let there = cover_of(textureSample(pictures, leaf_sampler, in.uv, chosen(in)).a, in.uv);
        samples &= covered_samples(pixel, on_picture(in.uv) * there, in.tint.w);
    } else {
        let second = samples_of(turned(in), vec4f(1.0, 3.0, 0.0, 2.0), dithered(pixel + 31.0));
        let a = cover_of(textureSample(pictures, leaf_sampler, in.uv, 2 * i32(in.pictures.x + 0.5)).a, in.uv);
        let b = cover_of(textureSample(pictures, leaf_sampler, in.uv, 2 * i32(in.pictures.y + 0.5)).a, in.uv);
        samples &= (covered_samples(pixel, a, 1.0) & (15u - second)) | (covered_samples(pixel, b, 1.0) & second);
    }
    return samples;
}
