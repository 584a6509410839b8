// Depth as seen from the sun.

struct Light {
    clip_from_world: mat4x4f,
}

@group(0) @binding(0) var<uniform> light: Light;

@vertex
fn vertex(
    @location(0) position: vec3f,
    @location(5) x: vec4f,
    @location(6) y: vec4f,
    @location(7) z: vec4f,
) -> @builtin(position) vec4f {
    let p = vec4f(position, 1.0);
    return light.clip_from_world * vec4f(dot(x, p), dot(y, p), dot(z, p), 1.0);
}
