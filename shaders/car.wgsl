// Cars: clear-coated paint, glass, lamps, metal, rubber.

// 1 where windows are drawn over what is behind them.
override SEEN_THROUGH: f32 = 0.0;

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let view = to_eye(in.world);
    var normal = normalize(in.normal);
    let material = in.material;
    let sun = sunshine(in.world, normal);
    let sun_direction = frame.to_sun_time.xyz;
    let cosine = clamp(dot(normal, sun_direction), 0.0, 1.0);

    // The ground near a car lies in its own shade.
    let open = mix(0.35, 1.0, smoothstep(0.0, 0.75, in.height + 0.3 * normal.z));
    let ground = mix(0.03, 0.09, open) * (SUN * frame.to_sun_time.z + ambient(vec3f(0.0, 0.0, 1.0)));

    // Per material: colour, roughness, reflectance head on, and how sharp the coat mirrors.
    var albedo = in.colour;
    var f0 = 0.04;
    var rough = 0.75;
    var coat = 0.0;
    if material == PAINT {
        albedo = in.colour * in.paint.rgb;
        rough = 0.28;
        coat = 1.0;
    } else if material == GLASS {
        f0 = 0.07;
        rough = 0.1;
        coat = 1.0;
    } else if material == BRAKE_LAMP || material == LAMP {
        rough = 0.18;
        coat = 0.8;
        // An unlit brake lamp swallows most of what falls on it, so that a lit one cannot be mistaken.
        albedo *= select(1.0, 0.3, material == BRAKE_LAMP);
    } else if material == METAL {
        f0 = 0.0;
        rough = 0.35;
        coat = 1.0;
    } else if material == TYRE {
        rough = 0.6;
        coat = 0.06;
    }
    let metal = select(0.0, 1.0, material == METAL);
    let bounced = reflect(-view, normal);
    let around = mirrored(bounced, ground, select(0.0, rough * rough, coat == 0.0)) * mix(0.55, 1.0, open);
    let f = fresnel(normal, view, f0);

    var light = albedo * (1.0 - metal) * (SUN * cosine * sun + ambient(normal) * open);
    light *= 1.0 - coat * f;
    light += coat * around * mix(vec3f(f), albedo * (0.75 + 0.25 * f), metal);
    // Paint has two layers: flakes that spread the sun, and the coat's small sharp image of it.
    let glint = sun_glint(normal, view, rough, f0 + metal * 0.5);
    light += sun * (glint * mix(vec3f(1.0), albedo, metal) + coat * 0.6 * sun_glint(normal, view, 0.09, 0.04));

    // Lamps: dark red plastic that turns into a light.
    let lit = select(0.0, in.paint.w, material == BRAKE_LAMP);
    light += lit * vec3f(2.6, 0.012, 0.008);
    // Tinted glass takes 45 % of the light behind it, and what it mirrors besides.
    let alpha = mix(1.0, 0.45 + 0.55 * f, select(0.0, SEEN_THROUGH, material == GLASS));
    return vec4f(through_air(light, in.world), alpha);
}
