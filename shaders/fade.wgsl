// How one level of detail of a tree gives way to the next.

// 0..1 by the pixel, evenly spread among neighbours.
fn dithered(pixel: vec2f) -> f32 {
    return fract(52.9829189 * fract(dot(floor(pixel), vec2f(0.06711056, 0.00583715))));
}

// Between two levels of detail both are drawn, each pixel by one of them: the finer one has its share in w, the coarser one
// the negative of that.
fn gone(pixel: vec2f, w: f32) -> bool {
    let d = dithered(pixel);
    return select(d >= w, d < -w, w < 0.0);
}
