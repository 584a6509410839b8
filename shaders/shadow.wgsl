// Depth as seen from the sun.

@vertex
fn vertex(
    @location(0) position: vec3f,
    @location(5) x: vec4f,
    @location(6) y: vec4f,
    @location(7) z: vec4f,
) -> @builtin(position) vec4f {
    return seen_from_sun(position, x, y, z);
}
