// Cars: clear-coated paint, glass, lamps, metal, rubber; metallic-roughness (GGX) under a coat.

// Radiance of a lit brake lamp, and of the same lamp when it only marks the car's end: 75 to 1.
const BRAKE_LIT = 3.0;
const RUNNING = 0.04;

// 1 where windows are drawn over what is behind them.
override SEEN_THROUGH: f32 = 0.0;

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let view = to_eye(in.world);
    let facet = normalize(in.normal);
    let material = in.material;
    let sun = sunshine(in.world, facet);
    let cosine = clamp(dot(facet, frame.to_sun_time.xyz), 0.0, 1.0);

    // The ground near a car lies in its own shade.
    let open = mix(0.35, 1.0, smoothstep(0.0, 0.75, in.height + 0.3 * facet.z));
    let above = ambient(vec3f(0.0, 0.0, 1.0));
    let ground = mix(0.03, 0.09, open) * (SUN * frame.to_sun_time.z + above);

    // Per material: colour, metal or not, roughness, how much of the surface below the coat shines, strength of the coat.
    var albedo = in.colour;
    var metal = 0.0;
    var rough = 0.75;
    var shine = 1.0;
    var coat = 0.0;
    if material == PAINT {
        albedo = in.colour * in.paint.rgb;
        // Flakes: every paint is a little metallic.
        metal = 0.25;
        rough = 0.45;
        shine = 0.55;
        coat = 1.0;
    } else if material == GLASS {
        // What is seen of the interior is dim.
        albedo *= 0.35;
        rough = 0.4;
        shine = 0.0;
        coat = 1.35;
    } else if material == BRAKE_LAMP || material == LAMP {
        rough = 0.35;
        shine = 0.3;
        coat = 0.7;
        // An unlit brake lamp swallows most of what falls on it, so that a lit one cannot be mistaken.
        albedo *= select(1.0, 0.3, material == BRAKE_LAMP);
    } else if material == METAL {
        metal = 1.0;
        rough = 0.3;
    } else if material == TYRE {
        rough = 0.62;
    } else if material == MATT {
        shine = 0.0;
    }
    rough = steadied(rough, facet);
    let bounced = reflect(-view, facet);
    let occluded = mix(0.55, 1.0, open);

    var light = albedo * (1.0 - metal) * (SUN * cosine * sun + ambient(facet) * open);
    let f0 = mix(vec3f(0.04), albedo, metal);
    let share = mirrors(facet, view, rough);
    let around = mirrored(bounced, ground, rough * rough) * occluded;
    light += shine * (around * (f0 * share.x + share.y) + sun * sun_gloss(facet, view, rough, f0));

    // The coat lies over all that.
    let coat_rough = steadied(0.07, facet);
    let reflected = min(coat * fresnel(facet, view, 0.042), 1.0);
    let image = mirrored(bounced, ground, coat_rough * coat_rough) * occluded;
    light = light * (1.0 - reflected) + reflected * image;
    light += coat * sun * sun_gloss(facet, view, coat_rough, vec3f(0.04));

    // Lamps: dark red plastic that turns into a light.
    let lit = select(0.0, mix(RUNNING, BRAKE_LIT, in.paint.w), material == BRAKE_LAMP);
    light += lit * vec3f(1.0, 0.0046, 0.003);
    // Tinted glass takes 45 % of the light behind it, and what it mirrors besides.
    let alpha = mix(1.0, 0.45 + 0.55 * reflected, select(0.0, SEEN_THROUGH, material == GLASS));
    return vec4f(through_air(light, in.world), alpha);
}
