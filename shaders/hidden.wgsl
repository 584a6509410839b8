// Mask for a part of the picture: nearer than anything drawn there, as it will be covered, or as far as the sky, as nothing is drawn yet.

override DEPTH: f32 = 1.0;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, DEPTH, 1.0);
}

@fragment
fn fragment() -> @location(0) vec4f {
    return vec4f(0.0, 0.0, 0.0, 1.0);
}
