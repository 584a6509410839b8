// Far trees where `far_cover.wgsl` found them, lit as near ones are.

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let picture = chosen(in);
    let there = textureSample(pictures, leaf_sampler, in.uv, picture);
    let local = 2.0 * textureSample(pictures, leaf_sampler, in.uv, picture + 1).xyz - 1.0;
    let normal = normalize(vec3f(in.turn.x * local.x - in.turn.y * local.y, in.turn.y * local.x + in.turn.x * local.y, local.z));
    let view = to_eye(in.world);
    // The picture stands in the tree's middle: the leaf is nearer by some of the crown.
    let place = in.world + in.turn.z * max(dot(normal, view), 0.0) * view;
    let albedo = there.rgb * there.rgb * in.tint.rgb;
    return vec4f(through_air(foliage(albedo, place, normal, normal, view, 1.0), in.world), 1.0);
}
