// Draws the samples that `drawn_samples` returns, by the pixel's mask.

@fragment
fn fragment(in: Surface) -> @builtin(sample_mask) u32 {
    let samples = drawn_samples(in);
    if samples == 0u {
        discard;
    }
    return samples;
}
