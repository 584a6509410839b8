// Trees: bark, and leaves that let light through.

@fragment
fn fragment(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let view = to_eye(in.world);
    var normal = normalize(in.normal);
    let leaves = in.material == LEAVES;
    let rough = grain_at(vec2f(in.uv.x * 3.0 + in.world.x * 0.9 + in.world.y * 0.9, in.world.z * 0.35));
    let clumps = grain_at((in.world.xy + in.world.zx * vec2f(0.7, 0.5)) * 0.55);
    let sun_direction = frame.to_sun_time.xyz;
    let sun = sunshine(in.world, normal);
    let facing = dot(normal, sun_direction);

    var albedo = in.colour * select(vec3f(1.0), in.paint.rgb, leaves);
    albedo *= 1.0 + select(0.9 * (rough.a - 0.5), 0.8 * (clumps.r - 0.5) + 0.6 * (clumps.g - 0.5), leaves);
    // Light wraps around a crown, which is no solid ball, and shines through leaves seen against the sun.
    let wrapped = clamp((facing + 0.35) / 1.35, 0.0, 1.0);
    let direct = select(clamp(facing, 0.0, 1.0), wrapped * wrapped * 0.92, leaves);
    let against = clamp(dot(-view, sun_direction), 0.0, 1.0);
    let through = select(0.0, 0.5 * against * against, leaves);
    let shine = SUN * sun * (direct + through * vec3f(1.0, 1.05, 0.3));
    let light = albedo * (shine + ambient(normal) * select(0.9, 0.85, leaves));
    return vec4f(through_air(light, in.world), 1.0);
}
