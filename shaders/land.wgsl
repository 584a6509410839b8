// Meadow: colour that varies over metres, tens and hundreds of metres, and blades close by.

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    var normal = normalize(in.normal);
    let view = to_eye(in.world);
    let p = in.world.xy;
    let blades = grain_at(p / 1.7);
    let tufts = grain_at(p.yx / 6.1 + vec2f(0.37, 0.11));
    let patches = grain_at(p / 47.0 + vec2f(0.71, 0.23));
    let fields = grain_at(p.yx / 310.0 + vec2f(0.2, 0.6));

    // Fresh, dry and dark grass around the mesh's own colour.
    var albedo = in.colour;
    let dry = smoothstep(0.42, 0.78, 0.55 * patches.g + 0.3 * tufts.g + 0.15 * fields.g + 0.02);
    albedo = mix(albedo, albedo * vec3f(1.55, 1.18, 0.92) + vec3f(0.012, 0.008, 0.0), 0.75 * dry);
    let lush = smoothstep(0.5, 0.85, fields.g * 0.6 + (1.0 - tufts.g) * 0.4);
    albedo *= mix(vec3f(1.0), vec3f(0.72, 0.86, 0.7), lush);
    let tone = 1.0 + 0.75 * (blades.a - 0.5) + 0.5 * (blades.r - 0.5) + 0.5 * (tufts.g - 0.5) + 0.35 * (patches.g - 0.5);
    albedo *= max(tone, 0.2);

    // Blades lean about: the light on them is softer than on a floor.
    normal = normalize(normal + vec3f(0.35 * (blades.a - 0.5), 0.35 * (tufts.a - 0.5), 0.0));
    let sun = sunshine(in.world, vec3f(0.0, 0.0, 1.0));
    let facing = dot(normal, frame.to_sun_time.xyz);
    let cosine = clamp((facing + 0.25) / 1.25, 0.0, 1.0);
    // Seen against the sun, grass glows.
    let against = clamp(dot(-view, frame.to_sun_time.xyz), 0.0, 1.0);
    let through = 0.35 * against * against * vec3f(1.0, 1.05, 0.35);
    let light = albedo * (SUN * sun * (cosine + through) + ambient(normal) * 0.9);
    return vec4f(through_air(light, in.world), 1.0);
}
