// Depth pass of trees. It writes depth alone, so that the colour pass shades every pixel once. On software rendering a discarded pixel
// costs as much as a shaded one.

// Returns the samples of a pixel that leaves or bark cover.
fn drawn_samples(in: Surface) -> u32 {
    var cover = textureSampleBias(leaves, leaf_sampler, in.uv, in.layer, select(0.0, BLUNTED, SAMPLES == 1u)).r;
    // With one sample, only whether it is more than half covered counts, which sharpening does not change.
    if SAMPLES > 1u {
        cover = sharpened(cover);
    }
    return covered_samples(in.clip.xy, cover, in.tint.w) & kept(in.clip.xy, in.tint.w);
}
