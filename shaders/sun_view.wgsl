// Map of a shadow: the view from the sun.

struct Light {
    clip_from_world: mat4x4f,
}

@group(0) @binding(0) var<uniform> light: Light;

fn seen_from_sun(position: vec3f, x: vec4f, y: vec4f, z: vec4f) -> vec4f {
    let p = vec4f(position, 1.0);
    return light.clip_from_world * vec4f(dot(x, p), dot(y, p), dot(z, p), 1.0);
}
