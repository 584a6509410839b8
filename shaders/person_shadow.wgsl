// Depth of people and bicycles as seen from the sun, between two phases of the gait.

@vertex
fn vertex(
    @location(0) position: vec3f,
    @location(5) x: vec4f,
    @location(6) y: vec4f,
    @location(7) z: vec4f,
    @location(8) colour_brake: vec4f,
    postures: Postures,
) -> @builtin(position) vec4f {
    let shares = posture_shares(colour_brake.w);
    return seen_from_sun(blended(position, postures.next_position, postures.standing_position, shares), x, y, z);
}
