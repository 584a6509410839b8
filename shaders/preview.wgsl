// Copy of a finished picture at the same size or smaller: each pixel is the mean of the block that it represents.

@group(0) @binding(0) var picture: texture_2d<f32>;

struct Point {
    @builtin(position) clip: vec4f,
    // 0 to 1 from the upper left corner.
    @location(0) at: vec2f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Point {
    let at = vec2f(f32(index & 1u), f32(index >> 1u)) * 2.0;
    return Point(vec4f(at * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0), 0.0, 1.0), at);
}

// Samples per side of a block: beyond a reduction by eight, only some of its pixels are read.
const MOST = 8;

@fragment
fn fragment(point: Point) -> @location(0) vec4f {
    let size = vec2i(textureDimensions(picture));
    let half = 0.5 * fwidth(point.at) * vec2f(size);
    let middle = point.at * vec2f(size);
    let first = clamp(vec2i(round(middle - half)), vec2i(0), size - 1);
    let last = clamp(vec2i(round(middle + half)) - 1, first, size - 1);
    let stride = (last - first) / MOST + 1;
    var sum = vec4f(0.0);
    var count = 0.0;
    for (var y = first.y; y <= last.y; y += stride.y) {
        for (var x = first.x; x <= last.x; x += stride.x) {
            sum += textureLoad(picture, vec2i(x, y), 0);
            count += 1.0;
        }
    }
    return sum / count;
}
