// Meadow and hills: the mesh's own colour varied by blades and clumps of grass that shade each other.

// True where the view is so far away that no blade is visible: the same picture at lower cost.
override AFAR: bool = false;
// Pixel width from which AFAR applies, metres (`render/materials.rs`).
override AFAR_M: f32 = 1.0;

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let view = to_eye(in.world);
    let p = in.world.xy;
    // Width of a pixel, metres. Each grain fades out before its repetition is only a few pixels long.
    let thin_m = sqrt(min(dot(dpdx(p), dpdx(p)), dot(dpdy(p), dpdy(p))));
    var near = 0.0;
    let mid = 1.0 - smoothstep(0.13, 0.55, thin_m);

    // Blades of 6 to 20 cm. Clumps of 20 cm to 2 m, displaced by waves that do not match the repetition of the grain.
    var blades = vec4f(0.5);
    if !AFAR {
        near = 1.0 - smoothstep(0.030, AFAR_M, thin_m);
        blades = grain_aslant(vec2f(0.94 * p.x - 0.34 * p.y, 0.34 * p.x + 0.94 * p.y) / 3.3);
    }
    let bent = p + 2.7 * sin(p.yx * vec2f(0.097, 0.083) + vec2f(1.3, 0.2)) + 0.3 * sin(p.yx * vec2f(0.391, 0.447));
    // On hills kilometres away, the same grain represents woods and fields; from above, where no hill is far, it would be seen as swirls.
    let distant = select(smoothstep(0.9, 1.6, thin_m), 0.0, FROM_ABOVE);
    let size = select(21.0, 1900.0, thin_m > 0.8 && !FROM_ABOVE);
    let clumps = grain_aslant(vec2f(0.6 * bent.x + 0.8 * bent.y, 0.6 * bent.y - 0.8 * bent.x) / size + vec2f(0.37, 0.11));

    // At grazing angles blades hide the ground between clumps, which would otherwise become streaks.
    let steep = mix(0.4, 1.0, smoothstep(0.02, 0.15, view.z));
    let rise = mid * steep * (0.8 * (clumps.a - 0.5) + 0.9 * (clumps.g - 0.5));
    let dry = mix(0.5, smoothstep(0.30, 0.70, clumps.g + 0.3 * (clumps.r - 0.5)), mid);
    var albedo = in.colour * mix(vec3f(0.84, 0.93, 0.90), vec3f(1.16, 1.07, 1.10), dry);
    // At grazing angles the stalks and ears above the green are visible.
    let flat_way = 1.0 - abs(view.z);
    albedo *= mix(vec3f(1.0), vec3f(1.10, 1.01, 1.02), flat_way * flat_way);
    // Dry stalks and small flowers.
    let speck = near * smoothstep(0.83, 0.97, blades.r) * smoothstep(0.45, 0.6, clumps.g);
    albedo = mix(albedo, vec3f(0.30, 0.27, 0.17), 0.6 * speck);
    var deep = near * (blades.a - 0.5);
    if SOFT > 0.5 {
        // From a few metres away, single blades of 2 to 7 cm.
        let close = 1.0 - smoothstep(0.004, 0.013, thin_m);
        let single = grain_aslant(vec2f(0.5 * p.x + 0.87 * p.y, 0.5 * p.y - 0.87 * p.x) / 1.13);
        deep += close * (0.55 * (single.a - 0.5) + 0.20 * (single.r - 0.5));
    }
    let tone = 1.0 + 1.15 * deep + 0.7 * rise + 0.3 * near * (clumps.r - 0.5)
        + distant * (1.3 * (clumps.g - 0.5) + 0.6 * (clumps.a - 0.5));
    let grass = in.material != LEAVES;
    albedo = select(in.colour, albedo * max(tone, 0.2), grass);

    // How deep the point lies within paved ground and within water, metres (`scene/land`): grass grows over the edge of what is paved.
    let frayed = 0.5 * (clumps.g - 0.5) + 0.4 * near * (blades.a - 0.5);
    let paved = select(0.0, smoothstep(-0.15, 0.15, in.uv.x + frayed), grass);
    let worn = 1.0 + 0.25 * (clumps.g - 0.5) + 0.5 * near * (blades.r - 0.5) + 0.25 * near * (blades.g - 0.5);
    albedo = mix(albedo, vec3f(0.150, 0.146, 0.138) * worn, paved);
    let water = select(0.0, smoothstep(-0.1, 0.1, in.uv.y + 0.6 * frayed), grass);

    // Clumps face different directions and blades lean, so that the light on them is softer than on a floor.
    let lean = steep * mid * 0.9 * vec3f(clumps.a - 0.5, clumps.g - 0.5, 0.0) + vec3f(0.0, 0.4 * deep, 0.0);
    let soft = 1.0 - max(paved, water);
    let normal = normalize(normalize(in.normal) + soft * lean);
    let sun = sunshine(in.world, vec3f(0.0, 0.0, 1.0));
    let facing = dot(normal, frame.to_sun_time.xyz);
    let cosine = clamp((facing + 0.25 * soft) / (1.0 + 0.25 * soft), 0.0, 1.0);
    // Seen against the sun, grass glows.
    let against = clamp(dot(-view, frame.to_sun_time.xyz), 0.0, 1.0);
    let through = soft * 0.3 * against * against * vec3f(1.0, 1.05, 0.4);
    var light = albedo * (SUN * sun * (cosine + through) + ambient(normal) * (0.82 + 0.5 * soft * deep) + lamplight(in.world, normal, 0.8));
    if water > 0.0 {
        // Still water: dark, with the sky in it, which small waves draw out upwards.
        let waves = normalize(vec3f(0.10 * (clumps.a - 0.5), 0.10 * (clumps.g - 0.5), 1.0));
        let deep_water = vec3f(0.012, 0.022, 0.020) * (SUN * sun * max(frame.to_sun_time.z, 0.0) + ambient(waves));
        let mirrored = reflect(-view, waves);
        let sky = sky_light_blurred(vec3f(mirrored.xy, abs(mirrored.z)), 2.0);
        light = mix(light, mix(deep_water, sky, fresnel(waves, view, 0.02)), water);
    }
    return vec4f(through_air(light, in.world), 1.0);
}
