// Depth of trees as seen from the sun, with light between the leaves.

// The layer after all cuts (`render/textures/leaf_textures.rs`).
const BARK_LAYER = 32;

struct Light {
    clip_from_world: mat4x4f,
}

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var leaves: texture_2d_array<f32>;
@group(0) @binding(2) var leaf_sampler: sampler;

struct Cast {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,
    @location(1) @interpolate(flat) layer: i32,
}

@vertex
fn vertex(
    @location(0) position: vec3f,
    @location(3) uv: vec2f,
    @location(4) material: u32,
    @location(5) x: vec4f,
    @location(6) y: vec4f,
    @location(7) z: vec4f,
) -> Cast {
    let p = vec4f(position, 1.0);
    // As in `leaf.wgsl`.
    let whole = floor(uv * 0.5);
    let leafy = material == 10u;
    return Cast(
        light.clip_from_world * vec4f(dot(x, p), dot(y, p), dot(z, p), 1.0),
        select(uv, uv - 2.0 * whole, leafy),
        select(BARK_LAYER, i32(whole.y) * 8 + i32(whole.x), leafy),
    );
}

@fragment
fn fragment(in: Cast) {
    if textureSample(leaves, leaf_sampler, in.uv, in.layer).r < 0.5 {
        discard;
    }
}
