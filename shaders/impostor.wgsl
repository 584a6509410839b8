// Colour pass of far trees, where `far_cover.wgsl` wrote their depth, with the light of near trees.

// Albedo, normal in the tree's own frame, cover and share of leaves of a picture.
struct Seen {
    albedo: vec3f,
    normal: vec3f,
    cover: f32,
    leafy: f32,
}

fn look(uv: vec2f, picture: i32) -> Seen {
    let there = textureSample(pictures, leaf_sampler, uv, picture);
    let turned = textureSample(pictures, leaf_sampler, uv, picture + 1);
    return Seen(there.rgb * there.rgb, 2.0 * turned.xyz - 1.0, there.a, turned.a);
}

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    var seen: Seen;
    if SAMPLES == 1u || FROM_ABOVE {
        seen = look(in.uv, chosen(in));
    } else {
        // Mixes two pictures by the share of the pixel's samples that each has.
        let a = look(in.uv, 2 * i32(in.pictures.x + 0.5));
        let b = look(in.uv, 2 * i32(in.pictures.y + 0.5));
        let wa = (1.0 - turned(in)) * (a.cover + 0.01);
        let wb = turned(in) * (b.cover + 0.01);
        let share = wb / (wa + wb);
        seen = Seen(mix(a.albedo, b.albedo, share), mix(a.normal, b.normal, share), 1.0, mix(a.leafy, b.leafy, share));
    }
    let local = seen.normal;
    let normal = normalize(vec3f(in.turn.x * local.x - in.turn.y * local.y, in.turn.y * local.x + in.turn.x * local.y, local.z));
    let view = to_eye(in.world);
    // The picture stands at the tree's centre, where trunk and boughs are. Leaves are nearer to the eye by part of the crown.
    let place = in.world + in.turn.z * seen.leafy * max(dot(normal, view), 0.0) * view;
    let albedo = seen.albedo * mix(vec3f(1.0), in.tint.rgb, seen.leafy);
    return vec4f(through_air(foliage(albedo, place, normal, normal, view, seen.leafy), in.world), 1.0);
}
