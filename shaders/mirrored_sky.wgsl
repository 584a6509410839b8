// Sky and trees as a smooth, level sheet of water mirrors them. A wet road is drawn over this picture.

struct Ray {
    @builtin(position) clip: vec4f,
    @location(0) direction: vec3f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Ray {
    let corner = vec2f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    let direction = frame.forward.xyz + corner.x * frame.right.xyz + corner.y * frame.up.xyz;
    return Ray(vec4f(corner, 0.0, 1.0), direction);
}

@fragment
fn fragment(ray: Ray) -> @location(0) vec4f {
    let direction = normalize(ray.direction);
    let up = vec3f(direction.xy, abs(direction.z));
    return vec4f(mirrored(up, vec3f(0.0), 0.12), 1.0);
}
