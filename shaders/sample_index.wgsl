// Draws the samples that `drawn_samples` returns, each on its own: for OpenGL, where naga cannot write a mask (it assigns a number to the
// array `gl_SampleMask`).

@fragment
fn fragment(in: Surface, @builtin(sample_index) sample: u32) {
    if (drawn_samples(in) >> sample & 1u) == 0u {
        discard;
    }
}
