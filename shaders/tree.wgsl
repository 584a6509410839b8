// Trees: bark, and crowns of leaves that let light through. What is seen of them is already in the depth (`cover.wgsl`).

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let view = to_eye(in.world);
    let leafy = in.layer != BARK_LAYER;
    let leaf = textureSample(leaves, leaf_sampler, in.uv, in.layer);
    let lean = 2.0 * leaf.ba - 1.0;
    let sun_direction = frame.to_sun_time.xyz;

    // Leaves are no surface: their shade begins some way behind them.
    let crown = normalize(in.normal);
    let sun = sunshine(in.world + select(0.0, 0.8, leafy) * sun_direction, crown);
    let normal = normalize(crown + select(0.9, 0.6, leafy) * vec3f(lean, 0.5 * (lean.x - lean.y)));
    // Leaves differ in brightness and a little in colour; old ones are dull.
    let tone = 2.0 * leaf.g;
    let albedo = in.colour * select(vec3f(0.25 + 0.75 * tone), tone * mix(vec3f(0.96, 1.0, 1.06), vec3f(1.05, 1.0, 0.92), leaf.g), leafy);

    let facing = dot(normal, sun_direction);
    // Light wraps around a crown, which is no solid ball, and shines through leaves seen against the sun. What shade
    // the crown throws on itself is thinned by the gaps between the leaves.
    let wrapped = clamp((facing + 0.3) / 1.3, 0.0, 1.0);
    let direct = select(clamp(facing, 0.0, 1.0), wrapped, leafy);
    let against = clamp(dot(-view, sun_direction), 0.0, 1.0);
    let through = select(0.0, 0.10 + 0.45 * against * against, leafy);
    let arrives = mix(sun, 1.0, select(0.0, 0.16, leafy));
    let shine = SUN * arrives * (direct + through * vec3f(1.0, 1.02, 0.35));
    let light = albedo * (shine + ambient(normal));
    return vec4f(through_air(light, in.world), 1.0);
}
