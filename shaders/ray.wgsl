// Rays of a whole picture.

struct Ray {
    @builtin(position) clip: vec4f,
    @location(0) direction: vec3f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Ray {
    // One triangle that covers the picture.
    let corner = vec2f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    let direction = frame.forward.xyz + corner.x * frame.right.xyz + corner.y * frame.up.xyz;
    return Ray(vec4f(corner, 0.0, 1.0), direction);
}
