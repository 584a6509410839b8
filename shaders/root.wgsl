// Soft shade on the ground under a tree: the crown blocks part of the sky, and more near the trunk.

struct Patch {
    @builtin(position) clip: vec4f,
    // Place in the patch, -1..1.
    @location(0) at: vec2f,
    // Radius of the patch, metres; strength, as it comes through the air.
    @location(1) @interpolate(flat) reach: vec2f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, at: Placed) -> Patch {
    let p = square_corner(index);
    let world = place(at, vec3f(p, 0.0));
    let left = through_air_from(distance(place(at, vec3f(0.0)), frame.eye.xyz)).g;
    return Patch(frame.clip_from_world * vec4f(world, 1.0), p, vec2f(length(at.x.xyz), at.colour_brake.w * left));
}

@fragment
fn fragment(in: Patch) -> @location(0) vec4f {
    let r2 = min(dot(in.at, in.at), 1.0);
    let crown = 0.34 * (1.0 - r2) * (1.0 - r2);
    // Half a metre from the trunk the grass is thin and dark.
    let metres = sqrt(r2) * in.reach.x;
    let foot = 0.5 * exp(-metres * metres / 0.35);
    return vec4f(0.0, 0.0, 0.0, in.reach.y * (1.0 - (1.0 - crown) * (1.0 - foot)));
}
