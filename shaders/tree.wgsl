// Colour pass of trees: bark, and crowns of translucent leaves. Their visible parts are already in the depth (`cover.wgsl`).

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let view = to_eye(in.world);
    let leafy = in.layer != BARK_LAYER;
    let leaf = textureSample(leaves, leaf_sampler, in.uv, in.layer);
    let lean = 2.0 * leaf.ba - 1.0;
    let crown = normalize(in.normal);
    let normal = normalize(crown + select(0.9, 0.6, leafy) * vec3f(lean, 0.5 * (lean.x - lean.y)));
    let tone = 2.0 * leaf.g;
    let albedo = in.colour * select(0.25 + 0.75 * tone, tone, leafy);
    let light = foliage(albedo, in.world, crown, normal, view, select(0.0, 1.0, leafy));
    return vec4f(through_air(light, in.world), 1.0);
}
