// Placement of a picture on a target, and its inputs. Shared by `tonemap.wgsl` and `soften.wgsl`.

struct QuadUniform {
    // width, height in pixels
    size: vec2f,
    flip: f32,
    border: f32,
    corner: f32,
    exposure: f32,
    soften: f32,
    bloom: f32,
    // For a mirror: tangents of half its angles, the eye's distance over the glass's radius, and the share of the picture that a flat glass
    // would show.
    lens: vec4f,
    // Place in clip space: the upper left corner, a pixel to the right, and a pixel down. A glass in the world is seen in perspective.
    corner_clip: vec4f,
    right_clip: vec4f,
    down_clip: vec4f,
}

@group(0) @binding(0) var<uniform> quad: QuadUniform;
@group(0) @binding(1) var light: texture_2d<f32>;
@group(0) @binding(2) var light_sampler: sampler;
@group(0) @binding(3) var halo: texture_2d<f32>;

struct Point {
    @builtin(position) clip: vec4f,
    // Pixels from the upper left corner.
    @location(0) at: vec2f,
    // Bend of a mirror's glass and width of its frame. Software rendering would compile a branch on the uniforms themselves again with
    // every draw (see a test in `shader.rs`).
    @location(1) @interpolate(flat) mirror: vec2f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Point {
    let corners = array(vec2f(0.0, 0.0), vec2f(1.0, 0.0), vec2f(1.0, 1.0), vec2f(0.0, 0.0), vec2f(1.0, 1.0), vec2f(0.0, 1.0));
    // The frame lies outside of the rectangle.
    let at = corners[index] * (quad.size + 2.0 * quad.border) - quad.border;
    return Point(quad.corner_clip + at.x * quad.right_clip + at.y * quad.down_clip, at, vec2f(quad.lens.z, quad.border));
}
