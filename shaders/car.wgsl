// Cars: clear-coated paint, glass, lamps, metal, rubber; metallic-roughness (GGX) under a coat.

// Radiance of a brake lamp while braking and while it only marks the car's end: 25 to 1.
const BRAKE_LIT = 3.2;
const RUNNING = 0.13;
// Lamps that show the car by day.
const DAYLIGHT = 0.75;

// 1 where windows are drawn over what is behind them.
override SEEN_THROUGH: f32 = 0.0;
// Whether some of it is paint, glass or a lamp; without them a pixel costs half as much, because software rendering goes
// through all that is not a constant (`render/models.rs`).
override COATED: bool = true;

// Width of a gap between panels (`scene/panels.rs`), metres. Where a pixel is wider, only some of them hit the gap: these
// are paler, or a line would be a row of dots. With several samples a pixel half as much is enough.
const GAP_M = 0.005;

// What a plate's surface and signs are in the mean (`scene/plate.rs`), and the pixels, in metres, up to which signs are seen
// as they are (3 pixels wide) and from which only that mean: there a sign is one pixel, and would flicker.
const PLATE_MEAN = 0.50;
const READ_M = 0.0167;
const BLENDED_M = 0.046;

// What a car mirrors: the sky, a belt of trees whose tops are ragged, dark below them, then meadow and road.
fn around_car(direction: vec3f, above: vec3f, ground: vec3f, rough: f32) -> vec3f {
    let sky = sky_light_blurred(direction, 5.0 * sqrt(rough));
    let bearing = atan2(direction.y, direction.x);
    let tops = 0.29 + 0.045 * sin(bearing * 9.0 + 1.3) + 0.035 * sin(bearing * 23.0) * sin(bearing * 5.0 + 0.7);
    let soft = 0.012 + 0.5 * rough;
    let belt = vec3f(0.050, 0.068, 0.030) * above * mix(0.7, 1.9, smoothstep(0.0, 0.24, direction.z)) + 0.04 * sky;
    let over_ground = mix(belt, sky, smoothstep(tops - soft, tops + soft, direction.z));
    return mix(ground, over_ground, smoothstep(-0.03 - soft, 0.015 + soft, direction.z));
}

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
    // What shines at a flat angle; under a coat nothing does of itself.
    var edge = 1.0;
    if material == PAINT {
        let pixel_m = max(length(dpdx(in.world)), length(dpdy(in.world)));
        let gap = select(0.0, clamp(select(0.8, 2.0, SOFT > 0.5) * GAP_M / pixel_m, 0.0, 1.0), in.colour.r < 0.5);
        albedo = mix(vec3f(1.0), in.colour, gap) * in.paint.rgb;
        // Flakes: every paint is a little metallic.
        metal = 0.3;
        rough = 0.42;
        shine = 0.55 * (1.0 - gap);
        coat = 1.15 * (1.0 - gap);
        edge = 0.0;
    } else if material == GLASS {
        // What is seen of the interior is dim.
        albedo *= 0.35;
        rough = 0.4;
        shine = 0.0;
        coat = 1.35;
    } else if material == BRAKE_LAMP {
        // Dark red plastic: it swallows most of what falls on it, so that a lit lamp cannot be mistaken.
        albedo = vec3f(0.45 * in.colour.r, 0.004, 0.004);
        rough = 0.35;
        shine = 0.15;
        coat = 1.0;
    } else if material == LAMP {
        rough = 0.35;
        shine = 0.3;
        coat = 1.0;
    } else if material == METAL {
        metal = 1.0;
        rough = 0.22;
    } else if material == TYRE {
        rough = 0.62;
        // A padded skin is duller than rubber.
        shine = select(1.0, 0.32, in.uv.x < -0.5);
        edge = select(1.0, 0.25, in.uv.x < -0.5);
    } else if material == PLATE {
        shine = 0.0;
        let pixel_m = max(length(dpdx(in.world)), length(dpdy(in.world)));
        albedo = mix(in.colour, vec3f(PLATE_MEAN), smoothstep(READ_M, BLENDED_M, pixel_m));
    } else if material == MATT {
        shine = 0.0;
    }
    if SOFT > 0.5 {
        // Grained plastic (`scene/cockpit.rs`).
        let grained = textureSample(grain, grain_sampler, in.uv);
        albedo *= select(1.0, 0.45 + 0.75 * grained.r + 0.35 * grained.g, in.uv.x < -0.5);
    }
    rough = steadied(rough, facet);
    let bounced = reflect(-view, facet);
    let occluded = mix(0.55, 1.0, open);

    var light = albedo * (1.0 - metal) * (SUN * cosine * sun + ambient(facet) * open);
    let f0 = mix(vec3f(0.04), albedo, metal);
    let share = mirrors(facet, view, rough);
    var around = around_car(bounced, above, ground, rough * rough) * occluded;
    if SOFT < 0.5 {
        // What is dear: under the coat's sharp image this one may be as dull as light from all around.
        around = ambient(bounced) * (0.85 * occluded);
    }
    light += shine * (around * (f0 * share.x + edge * share.y) + sun * sun_gloss(facet, view, rough, f0, edge));

    var alpha = 1.0;
    if COATED {
        // The coat lies over all that.
        let coat_rough = steadied(0.05, facet);
        // No coat is quite smooth or clean: at the flattest angles it mirrors a third.
        let reflected = min(coat * fresnel(facet, view, 0.045), 0.36);
        let image = around_car(bounced, above, ground, coat_rough * coat_rough) * occluded;
        light = light * (1.0 - reflected) + reflected * image;
        light += min(coat, 0.5) * sun * sun_gloss(facet, view, coat_rough, vec3f(0.04), 1.0);

        // Lamps: green and blue of a brake lamp's colour are its shares of the running and of the braking light.
        let glow = max(RUNNING * in.colour.g, BRAKE_LIT * in.colour.b * in.paint.w);
        light += select(0.0, glow, material == BRAKE_LAMP) * vec3f(1.0, 0.0046, 0.003);
        light += select(0.0, DAYLIGHT, material == LAMP && in.colour.r > 0.8) * vec3f(0.95, 0.98, 1.0);
        light += select(vec3f(0.0), in.paint.rgb, material == SIGNAL_LAMP);
        // A far body's windows are not seen through: they are as light as near ones with what is behind those, a dim cabin and
        // some of the land beyond it.
        let opaque = clamp(22.0 * in.colour.r, 0.05, 1.0);
        let through = opaque + (1.0 - opaque) * reflected;
        light = select(light, light * through + (1.0 - through) * 0.20 * ground, material == GLASS && SEEN_THROUGH < 0.5);
        // Tinted glass takes 45 % of the light behind it, a lamp's cover 5 %, and what they mirror besides.
        alpha = mix(1.0, through, select(0.0, SEEN_THROUGH, material == GLASS));
    }
    return vec4f(through_air(light, in.world), alpha);
}
