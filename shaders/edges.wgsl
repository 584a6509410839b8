// Edge smoothing: where neighbours differ, takes a mean along the edge instead of the step across it (in the manner of Lottes' FXAA, 2009:
// four neighbours find the edge, four samples along it make the mean). It also interpolates when the picture is scaled up. The including
// program defines a picture's colour (`at`, `load`) and its brightness to the eye (`seen`).
fn smoothed(uv: vec2f, middle: vec3f) -> vec3f {
    let size = vec2f(textureDimensions(light));
    let texel = 1.0 / size;
    let last = vec2i(size) - 1;
    let here = clamp(vec2i(uv * size), vec2i(0), last);
    // Neighbours are read without a filter: a filtered sample costs four times as much.
    let low_x = max(here.x - 1, 0);
    let high_x = min(here.x + 1, last.x);
    let low_y = max(here.y - 1, 0);
    let high_y = min(here.y + 1, last.y);
    let m = seen(middle);
    let n = seen(load(vec2i(here.x, low_y)));
    let s = seen(load(vec2i(here.x, high_y)));
    let w = seen(load(vec2i(low_x, here.y)));
    let e = seen(load(vec2i(high_x, here.y)));
    let low = min(m, min(min(n, s), min(w, e)));
    let high = max(m, max(max(n, s), max(w, e)));
    if high - low < max(0.035, 0.09 * high) {
        return middle;
    }
    // The edge is perpendicular to the gradient.
    var along = vec2f(s - n, w - e);
    let least = 1.0 / (min(abs(along.x), abs(along.y)) + max(0.03 * (n + s + w + e), 0.008));
    along = clamp(along * least, vec2f(-6.0), vec2f(6.0)) * texel;
    let near = 0.5 * (at(uv - along / 6.0) + at(uv + along / 6.0));
    let far = 0.5 * near + 0.25 * (at(uv - 0.5 * along) + at(uv + 0.5 * along));
    let reached = seen(far);
    return select(far, near, reached < low || reached > high);
}
