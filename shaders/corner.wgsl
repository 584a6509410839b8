// Vertex of a mesh (`scene/mesh.rs`).

struct Corner {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) colour: vec3f,
    @location(3) uv: vec2f,
    @location(4) material: u32,
}
