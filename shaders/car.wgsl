// Cars: clear-coated paint, glass, lamps, metal, rubber; metallic-roughness (GGX) under a coat.

// Radiance of a brake lamp while braking, and as a tail lamp: 25 to 1.
const BRAKE_LIT = 3.2;
const RUNNING = 0.13;
// Radiance of daytime running lamps.
const DAYLIGHT = 0.75;

// 1 where windows are drawn over the picture behind them.
override SEEN_THROUGH: f32 = 0.0;
// True if some of the mesh is paint, glass or a lamp. Without these a pixel costs half as much, as software rendering executes all branches
// that do not depend on a constant (`render/models.rs`).
override COATED: bool = true;

// Width of a gap between panels (`scene/car/panels.rs`), metres. Where a pixel is wider, only some pixels hit the gap. These are drawn
// paler, as a line would otherwise be a row of dots. With several samples per pixel, half the width is enough.
const GAP_M = 0.005;

// Mean colour of a plate's surface and signs (`scene/car/number_plate.rs`), and sizes of a pixel at the plate in metres. Up to READ_M signs
// are drawn as they are (3 pixels wide). From BLENDED_M on, where a sign is one pixel and would flicker, only the mean is drawn.
const PLATE_MEAN = 0.50;
const READ_M = 0.0167;
const BLENDED_M = 0.046;

// Returns the light that a car mirrors: the sky, a belt of trees with ragged tops, dark below them, then meadow and road.
fn around_car(direction: vec3f, above: vec3f, ground: vec3f, rough: f32) -> vec3f {
    let sky = sky_light_blurred(direction, 5.0 * sqrt(rough));
    let bearing = atan2(direction.y, direction.x);
    let tops = 0.29 + 0.045 * sin(bearing * 9.0 + 1.3) + 0.035 * sin(bearing * 23.0) * sin(bearing * 5.0 + 0.7);
    let soft = 0.012 + 0.5 * rough;
    let belt = vec3f(0.050, 0.068, 0.030) * above * mix(0.7, 1.9, smoothstep(0.0, 0.24, direction.z)) + 0.04 * sky;
    let over_ground = mix(belt, sky, smoothstep(tops - soft, tops + soft, direction.z));
    return mix(ground, over_ground, smoothstep(-0.03 - soft, 0.015 + soft, direction.z));
}

// Returns the share of a body's mirror image that rough water leaves: the more of it is left, the nearer a part is to the road and the eye. Its
// outline is soft.
fn in_rough_water(world: vec3f, height: f32, facet: vec3f) -> f32 {
    let from_below = vec3f(frame.eye.xy, 2.0 * (world.z - height) - frame.eye.z) - world;
    let away = length(from_below);
    let outline = smoothstep(0.0, 0.5, dot(facet, from_below) / away);
    return exp(-height / 1.2) * outline * (1.0 - smoothstep(20.0, 60.0, away));
}

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let view = to_eye(in.world);
    let facet = normalize(in.normal);
    let material = in.material;
    // The dashboard's grained top lies in the shade of roof and windscreen. Texels of coarse maps are too wide for it and would give it
    // jagged stripes, so that it has no sun there.
    let shaded = SOFT < 0.5 && in.uv.x < -0.5;
    let sun = select(sunshine(in.world, facet), 0.0, shaded);
    let cosine = clamp(dot(facet, frame.to_sun_time.xyz), 0.0, 1.0);

    // The ground near a car lies in the car's own shade.
    let open = mix(0.35, 1.0, smoothstep(0.0, 0.75, in.height + 0.3 * facet.z));
    let above = ambient(vec3f(0.0, 0.0, 1.0));
    let ground = mix(0.03, 0.09, open) * (SUN * frame.to_sun_time.z + above);

    // Per material: colour, metal or not, roughness, specular strength of the surface below the coat, strength of the coat.
    var albedo = in.colour;
    var metal = 0.0;
    var rough = 0.75;
    var shine = 1.0;
    var coat = 0.0;
    // Specular reflection at grazing angles; none below a coat.
    var edge = 1.0;
    if material == PAINT {
        let pixel_m = max(length(dpdx(in.world)), length(dpdy(in.world)));
        let gap = select(0.0, clamp(select(0.8, 2.0, SOFT > 0.5) * GAP_M / pixel_m, 0.0, 1.0), in.colour.r < 0.5);
        albedo = mix(vec3f(1.0), in.colour, gap) * in.paint.rgb;
        // Every paint has metallic flakes.
        metal = 0.3;
        rough = 0.42;
        shine = 0.55 * (1.0 - gap);
        coat = 1.15 * (1.0 - gap);
        edge = 0.0;
    } else if material == GLASS {
        // The visible interior is dim.
        albedo *= 0.35;
        rough = 0.4;
        shine = 0.0;
        coat = 1.35;
    } else if material == BRAKE_LAMP {
        // Dark red plastic absorbs most light, so that a lit lamp cannot be mistaken.
        albedo = vec3f(0.45 * in.colour.r, 0.004, 0.004);
        rough = 0.35;
        shine = 0.15;
        coat = 1.0;
    } else if material == LAMP || material == HEAD_LAMP {
        albedo = select(albedo, vec3f(in.colour.r), material == HEAD_LAMP);
        rough = 0.35;
        shine = 0.3;
        coat = 1.0;
    } else if material == METAL {
        metal = 1.0;
        rough = 0.22;
    } else if material == TYRE {
        rough = 0.62;
        // Padded surfaces shine less than rubber.
        shine = select(1.0, 0.32, in.uv.x < -0.5);
        edge = select(1.0, 0.25, in.uv.x < -0.5);
    } else if material == PLATE {
        shine = 0.0;
        let pixel_m = max(length(dpdx(in.world)), length(dpdy(in.world)));
        albedo = mix(in.colour, vec3f(PLATE_MEAN), smoothstep(READ_M, BLENDED_M, pixel_m));
    } else if material == MATT || material == REFLECTOR {
        shine = 0.0;
    }
    if SOFT > 0.5 {
        // Grained plastic (`scene/cockpit/mod.rs`).
        let grained = textureSample(grain, grain_sampler, in.uv);
        albedo *= select(1.0, 0.45 + 0.75 * grained.r + 0.35 * grained.g, in.uv.x < -0.5);
    }
    rough = steadied(rough, facet);
    let bounced = reflect(-view, facet);
    let occluded = mix(0.55, 1.0, open);

    var light = albedo * (1.0 - metal) * (SUN * cosine * sun + ambient(facet) * open + lamplight(in.world, facet, 0.0));
    let f0 = mix(vec3f(0.04), albedo, metal);
    let share = mirrors(facet, view, rough);
    var around = around_car(bounced, above, ground, rough * rough) * occluded;
    if SOFT < 0.5 {
        // Saves cost: under the coat's sharp reflection, this one may be as diffuse as light from all directions.
        around = ambient(bounced) * (0.85 * occluded);
    }
    light += shine * (around * (f0 * share.x + edge * share.y) + sun * sun_gloss(facet, view, rough, f0, edge));

    light += select(vec3f(0.0), albedo * returned_light(in.world, view), material == REFLECTOR || material == PLATE);

    var alpha = 1.0;
    if COATED {
        // The coat lies over all of these.
        let coat_rough = steadied(0.05, facet);
        // No coat is perfectly smooth or clean: at grazing angles it mirrors a third.
        let reflected = min(coat * fresnel(facet, view, 0.045), 0.36);
        let image = around_car(bounced, above, ground, coat_rough * coat_rough) * occluded;
        light = light * (1.0 - reflected) + reflected * image;
        light += min(coat, 0.5) * sun * sun_gloss(facet, view, coat_rough, vec3f(0.04), 1.0);

        // Lamps: green and blue of a brake lamp's colour are its shares as tail lamp and as brake lamp, those of a head lamp by day and dipped.
        // In water they are streaks (`streak.wgsl`).
        let is_on = select(step(0.0, in.paint.w), 0.0, IN_WATER);
        let glow = max(RUNNING * in.colour.g, BRAKE_LIT * in.colour.b * in.paint.w) * is_on;
        light += select(0.0, glow * frame.lamps.y, material == BRAKE_LAMP) * vec3f(1.0, 0.0046, 0.003);
        let head = max(DAYLIGHT * in.colour.g, frame.lamps.x * in.colour.b) * is_on * frame.lamps.y;
        light += select(0.0, head, material == HEAD_LAMP) * vec3f(0.95, 0.98, 1.0);
        light += select(vec3f(0.0), in.paint.rgb * frame.lamps.y, material == SIGNAL_LAMP);
        // The windows of a far body are opaque. They are as bright as near ones, with a dim cabin and some of the land beyond it.
        let opaque = clamp(22.0 * in.colour.r, 0.05, 1.0);
        let through = opaque + (1.0 - opaque) * reflected;
        light = select(light, light * through + (1.0 - through) * 0.20 * ground, material == GLASS && SEEN_THROUGH < 0.5);
        // Tinted glass absorbs 45 % of the light behind it, a lamp's cover 5 %, in addition to the mirrored share.
        alpha = mix(1.0, through, select(0.0, SEEN_THROUGH, material == GLASS));
    }
    if IN_WATER {
        return vec4f(through_air(light, in.world), in_rough_water(in.world, in.height, facet));
    }
    return vec4f(through_air_over(light, in.world, alpha), alpha);
}
