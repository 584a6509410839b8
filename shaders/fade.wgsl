// Blending between levels of detail of a tree, and partial cover of pixels by leaves.

// Samples per pixel, 1 or 4.
override SAMPLES: u32 = 1u;
// Share of a pixel that leaves must cover to be drawn with one sample per pixel.
const LEAST_COVER = 0.5;
// Bias towards smaller mip levels of leaves and pictures with one sample per pixel, where gaps finer than a pixel would be lone dark
// points.
const BLUNTED = 0.75;

// Returns 0..1 by the pixel, evenly spread among neighbours.
fn dithered(pixel: vec2f) -> f32 {
    return fract(52.9829189 * fract(dot(floor(pixel), vec2f(0.06711056, 0.00583715))));
}

// Returns the samples that make up a share of a pixel, those of the lowest turn first. The remaining part of a sample goes to some of the
// neighbours, so that the stipple is one sample deep, not a whole pixel.
fn samples_of(share: f32, turns: vec4f, luck: f32) -> u32 {
    let taken = (turns + luck) * 0.25 < vec4f(share);
    return dot(vec4u(taken), vec4u(1u, 2u, 4u, 8u));
}

// Returns the samples of a level. Between two levels of detail both are drawn, each sample by one of them: the finer one has its share in
// w, the coarser one the negative of that. A pixel of one sample cannot be shared without a stipple: see `least_cover`.
fn kept(pixel: vec2f, w: f32) -> u32 {
    if SAMPLES == 1u {
        return 15u;
    }
    let finer = samples_of(abs(w), vec4f(0.0, 2.0, 3.0, 1.0), dithered(pixel));
    return select(finer, 15u - finer, w < 0.0);
}

// Returns the share of a pixel of one sample that must be covered, for `w` as in `kept`. The coarser level's leaves grow from nothing to
// their size while the finer one is still whole; then the finer one's shrink.
fn least_cover(w: f32) -> f32 {
    let there = clamp(2.0 * select(w, 1.0 + w, w < 0.0), 0.0, 1.0);
    return mix(1.0, LEAST_COVER, there);
}

// Returns the samples that are covered at this share.
fn covered_samples(pixel: vec2f, cover: f32, w: f32) -> u32 {
    if SAMPLES == 1u {
        return select(0u, 15u, cover >= least_cover(w));
    }
    return samples_of(cover, vec4f(3.0, 1.0, 2.0, 0.0), dithered(pixel + 17.0));
}
