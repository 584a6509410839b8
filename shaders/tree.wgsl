// Trees: bark, and crowns of leaves that are cut out of the model's coarse clumps and let light through.

// Share of a pixel that leaves must cover to be drawn: one half without multisampling, less with it.
override LEAST_COVER: f32 = 0.5;

// The two coordinates of a point that its face shows least foreshortened, so that the grain is nowhere smeared.
fn across(world: vec3f, face: vec3f) -> vec2f {
    let a = abs(face);
    let flat_uv = select(world.xz, world.xy, a.z > a.y);
    return select(flat_uv, world.yz, a.x > max(a.y, a.z));
}

@fragment
fn fragment(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let view = to_eye(in.world);
    let leaves = in.material == LEAVES;
    let uv = across(in.world, cross(dpdx(in.world), dpdy(in.world)));
    // Grit of 9 and 3 cm: single leaves. Far away it fades to its mean and the crown closes.
    let leaf = grain_at(uv / 23.0);
    let small = grain_at(uv.yx / 7.3 + vec2f(0.3, 0.6));
    let rough = grain_at(vec2f(in.uv.x * 0.9, in.uv.y * 0.11));

    // Leaves are sparse where the clump turns away from the eye: its outline dissolves.
    let aslant = smoothstep(0.45, 1.0, 1.0 - abs(dot(normalize(in.normal), view)));
    let density = 0.62 * leaf.r + 0.38 * small.r + 0.7 * aslant * (leaf.g - 0.5);
    let threshold = 0.335 + 0.17 * aslant;
    let soft = max(fwidth(density), 0.02);
    let cover = select(1.0, clamp((density - threshold) / soft + 0.5, 0.0, 1.0), leaves);
    if cover < LEAST_COVER {
        discard;
    }

    var normal = normalize(in.normal);
    if leaves {
        let lean = vec3f(leaf.r - 0.5, small.r - 0.5, small.g - 0.5);
        normal = normalize(normal + 1.5 * lean);
    }
    let sun_direction = frame.to_sun_time.xyz;
    // Leaves are no surface: their shade begins some way behind them.
    let sun = sunshine(in.world + select(0.0, 0.8, leaves) * sun_direction, normalize(in.normal));
    let facing = dot(normal, sun_direction);

    var albedo = in.colour * select(vec3f(1.0), in.paint.rgb, leaves);
    let speckle = 1.5 * (density - 0.5) + 0.7 * (leaf.g - 0.5);
    albedo *= 1.0 + select(1.5 * (rough.a - 0.5) + 0.5 * (small.r - 0.5), speckle, leaves);
    // Inside a clump little light is left.
    albedo *= select(1.0, 0.5, leaves && !front);
    // Light wraps around a crown, which is no solid ball, and shines through leaves seen against the sun. What shade
    // the crown throws on itself is thinned by the gaps between the leaves.
    let wrapped = clamp((facing + 0.3) / 1.3, 0.0, 1.0);
    let direct = select(clamp(facing, 0.0, 1.0), wrapped, leaves);
    let against = clamp(dot(-view, sun_direction), 0.0, 1.0);
    let through = select(0.0, 0.12 + 0.55 * against * against, leaves);
    let arrives = mix(sun, 1.0, select(0.0, 0.16, leaves));
    let shine = SUN * arrives * (direct + through * vec3f(1.0, 1.05, 0.3));
    let light = albedo * (shine + ambient(normal));
    return vec4f(through_air(light, in.world), cover);
}
