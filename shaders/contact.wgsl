// Soft shade on the ground under a car, which gets light neither from the sun nor from the sky.

struct Patch {
    @builtin(position) clip: vec4f,
    // Metres from the car's centre: ahead, to the left.
    @location(0) at: vec2f,
    // Share of the shade that comes through the air.
    @location(1) left: f32,
}

// Half the size of the patch, metres.
const REACH = vec2f(2.95, 1.4);
// Half the size of the car's floor, metres.
const FLOOR = vec2f(2.3, 0.72);

@vertex
fn vertex(@builtin(vertex_index) index: u32, at: Placed) -> Patch {
    let p = square_corner(index) * REACH;
    let world = place(at, vec3f(p, 0.015));
    return Patch(frame.clip_from_world * vec4f(world, 1.0), p, through_air_from(distance(world, frame.eye.xyz)).g);
}

@fragment
fn fragment(in: Patch) -> @location(0) vec4f {
    let off = max(abs(in.at) - FLOOR, vec2f(0.0));
    let distance = length(off / (REACH - FLOOR));
    let open = clamp(distance, 0.0, 1.0);
    let shade = in.left * 0.82 * (1.0 - open) * (1.0 - open);
    return vec4f(0.0, 0.0, 0.0, shade);
}
