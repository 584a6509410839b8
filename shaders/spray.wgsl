// Puffs of spray behind vehicles (`scene/spray.rs`): discs that face the eye.

struct Puff {
    @builtin(position) clip: vec4f,
    // Place in the disc, -1..1.
    @location(0) at: vec2f,
    // Place in the grain.
    @location(1) grained: vec2f,
    // Radiance; opacity in w.
    @location(2) @interpolate(flat) light: vec4f,
    // Height over the road, metres.
    @location(3) height: f32,
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, at: Placed) -> Puff {
    let p = square_corner(corner);
    let middle = place(at, vec3f(0.0));
    let radius = at.x.x;
    let off = radius * (p.x * normalize(frame.right.xyz) + p.y * normalize(frame.up.xyz));
    let world = middle + off;
    let light = 0.66 * ambient(vec3f(0.0, 0.0, 1.0)) + 0.25 * lamplight(middle, vec3f(0.0, 0.0, 1.0), 1.0);
    // A puff that the eye enters does not cover the whole picture at once.
    let near = smoothstep(0.6, 3.0, distance(middle, frame.eye.xyz));
    let left = through_air_from(distance(middle, frame.eye.xyz)).g;
    let grained = 0.11 * p * radius + middle.xy * 0.05 + vec2f(0.0, 0.05 * middle.z);
    return Puff(frame.clip_from_world * vec4f(world, 1.0), p, grained, vec4f(light, at.colour_brake.w * near * left), at.y.y + off.z);
}

@fragment
fn fragment(in: Puff) -> @location(0) vec4f {
    let thick = max(1.0 - dot(in.at, in.at), 0.0);
    let torn = clamp(0.35 + 1.3 * textureSample(grain, grain_sampler, in.grained).g, 0.0, 1.6);
    // The road would cut it off along a line.
    let clear = smoothstep(0.0, 0.5, in.height);
    return vec4f(in.light.rgb, in.light.w * thick * thick * torn * clear);
}
