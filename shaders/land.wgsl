// Meadow: colour that varies over decimetres, metres and tens of metres around that of the mesh.

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let view = to_eye(in.world);
    let p = in.world.xy;
    // The three grains lie askew to each other, so that their repetition is not seen.
    let blades = grain_at(p / 2.3);
    let tufts = grain_at(vec2f(0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y) / 13.1 + vec2f(0.37, 0.11));
    let patches = grain_at(vec2f(0.6 * p.x + 0.8 * p.y, 0.6 * p.y - 0.8 * p.x) / 83.0 + vec2f(0.71, 0.23));

    // From high above, where a pixel holds much of a grain's repetition, the mesh's own colour has to do.
    let pixel_m = length(fwidth(p));
    let near = 1.0 - smoothstep(0.08, 0.5, pixel_m);
    let mid = 1.0 - smoothstep(0.25, 1.2, pixel_m);

    // Fresh, dry and dark grass around the mesh's own colour, which is a little too pure.
    let pale = dot(in.colour, vec3f(0.35, 0.5, 0.15));
    var albedo = mix(in.colour, vec3f(pale), 0.12);
    let dry = mix(0.35, smoothstep(0.40, 0.72, 0.6 * patches.g + 0.4 * mix(0.5, tufts.g, near)), mid);
    albedo = mix(albedo * vec3f(0.82, 0.88, 0.86), albedo * vec3f(1.28, 1.10, 0.98) + vec3f(0.008, 0.005, 0.0), dry);
    let tone = 1.0 + 0.9 * (blades.a - 0.5) + 0.55 * (blades.r - 0.5) + near * (0.75 * (tufts.r - 0.5) + 0.45 * (tufts.g - 0.5));
    let grass = in.material != LEAVES;
    albedo = select(in.colour, albedo * max(tone, 0.2), grass);

    // Blades lean about: the light on them is softer than on a floor.
    let lean = vec3f(0.5 * (blades.a - 0.5), 0.5 * (tufts.r - 0.5), 0.0);
    let normal = normalize(normalize(in.normal) + lean);
    let sun = sunshine(in.world, vec3f(0.0, 0.0, 1.0));
    let facing = dot(normal, frame.to_sun_time.xyz);
    let cosine = clamp((facing + 0.25) / 1.25, 0.0, 1.0);
    // Seen against the sun, grass glows.
    let against = clamp(dot(-view, frame.to_sun_time.xyz), 0.0, 1.0);
    let through = 0.3 * against * against * vec3f(1.0, 1.05, 0.4);
    let light = albedo * (SUN * sun * (cosine + through) + ambient(normal) * 0.9);
    return vec4f(through_air(light, in.world), 1.0);
}
