// Asphalt and its markings. uv: metres along and across (0 at the centre of the lane, positive to the left).

// Distance of wheel tracks from the centre of the lane, metres.
const TRACK = 0.75;
// True in rain. The road then mirrors what is already in the picture: the share that it lets through is in the alpha channel.
override WET: bool = false;

// Returns a repaired patch, one in every few stretches of road: x is 1 inside, y has the tar seam.
fn patch_at(uv: vec2f) -> vec2f {
    let stretch = 13.0;
    let cell = i32(floor(uv.x / stretch));
    let along = uv.x - f32(cell) * stretch;
    let present = step(hash(cell * 7 + 1), 0.42);
    let start = 1.0 + 6.0 * hash(cell * 7 + 2);
    let end = start + 0.9 + 4.0 * hash(cell * 7 + 3);
    let middle = (hash(cell * 7 + 4) - 0.5) * 2.2;
    let half = 0.35 + 0.8 * hash(cell * 7 + 5);
    // Signed distance into the rectangle.
    let inside = min(min(along - start, end - along), half - abs(uv.y - middle));
    let soft = max(length(fwidth(uv)) * 0.7, 0.01);
    let seam = 1.0 - smoothstep(0.02, 0.02 + soft, abs(inside));
    return vec2f(smoothstep(-soft, soft, inside), seam * 0.03 / (0.03 + soft)) * present;
}

// Returns 1 on the tar of a sealed crack across the lane, in some stretches of road.
fn sealed_at(uv: vec2f, bend: f32, pixel_m: f32) -> f32 {
    let stretch = 19.0;
    let cell = i32(floor(uv.x / stretch));
    let at = stretch * (f32(cell) + 0.15 + 0.7 * hash(cell * 5 + 3));
    let way = uv.x - at - (hash(cell * 5 + 1) - 0.5) * uv.y - 0.7 * (bend - 0.5) - 0.08 * sin(3.1 * uv.y);
    let half = 0.018;
    let soft = max(fwidth(uv.x), 0.006) + pixel_m;
    return step(hash(cell * 5 + 2), 0.5) * (1.0 - smoothstep(half, half + soft, abs(way))) * min(1.0, 3.0 * half / soft);
}

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let flat_normal = normalize(in.normal);
    let view = to_eye(in.world);
    // Stones of 7 and 15 mm, stains of 4 cm to 1 m, weathering over metres. All are rotated so that no repetition is visible.
    let fine = grain_aslant(in.uv / 3.66);
    let stones = grain_aslant(vec2f(0.8 * in.uv.x - 0.6 * in.uv.y, 0.6 * in.uv.x + 0.8 * in.uv.y) / 7.4);
    let waved = in.uv + vec2f(0.9, 0.5) * sin(in.uv.yx * vec2f(0.9, 0.213));
    let coarse = grain_at(waved.yx / 9.7 + vec2f(0.13, 0.71));
    let broad = grain_at(in.uv / vec2f(61.0, 23.0));
    let repair = patch_at(in.uv);
    // Width of a pixel on the road, metres.
    let pixel_m = min(length(dpdx(in.uv)), length(dpdy(in.uv)));
    let close = 1.0 - smoothstep(0.004, 0.016, pixel_m);

    let off = abs(abs(in.uv.y) - TRACK);
    let track = exp(-off * off / 0.075);
    let drip = exp(-in.uv.y * in.uv.y / 0.09);
    // Wheels press the stones into the tar, so tracks are smoother and darker.
    let grit = (0.75 * (fine.r - 0.5) + 0.75 * (stones.r - 0.5)) * (1.0 - 0.35 * track) + 0.5 * (coarse.r - 0.5);
    // Some stones are pale.
    let pale = smoothstep(0.72, 0.95, stones.r) * (1.0 - 0.5 * track);
    // The mesh's colour already includes the tracks and the pale edge.
    var tone = 1.0 + grit + 0.35 * pale + 0.50 * (coarse.g - 0.5) + 0.45 * (broad.g - 0.5) + 0.2 * (stones.g - 0.5);
    // Oil spots lie along the centre of the lane.
    tone *= 1.0 - 0.17 * track - drip * (0.08 + 0.30 * smoothstep(0.58, 0.75, coarse.g));
    tone *= 1.0 - 0.45 * (1.0 - coarse.b) * smoothstep(0.46, 0.60, broad.g);
    // A repair is newer: darker, with finer grain and a seam of tar.
    tone = mix(tone, 0.70 + 0.5 * grit + 0.12 * (coarse.g - 0.5), repair.x) * (1.0 - 0.6 * repair.y);
    tone *= 1.0 - 0.55 * sealed_at(in.uv, coarse.g, pixel_m);
    let line = in.material == MARKING;
    // In slivers of a pixel's width, interpolation can leave the range of their corners' colours.
    let colour = clamp(in.colour, vec3f(0.0), vec3f(1.0));
    let bare = select(colour, vec3f(0.0902, 0.0902, 0.0946), line) * vec3f(1.08, 1.03, 0.95) * max(tone, 0.12);

    // The line, 12 cm wide, 16 cm into its strip. Its edge is straight except where stones broke off. Its paint is worn on the tops of
    // stones, and most where wheels cut the bend.
    let frayed = in.colour.b - 0.22 + 0.012 * (coarse.g - 0.5) + close * 0.006 * (stones.r - 0.5);
    let there = covered(frayed, 0.059, fwidth(in.colour.b));
    let worn = smoothstep(0.20, 0.44, 0.55 * coarse.g + 0.25 * fine.r + 0.2 * stones.r + 0.05);
    let chipped = close * smoothstep(0.62, 0.80, fine.r) * smoothstep(0.62, 0.40, coarse.g);
    let paint = colour.r * vec3f(1.0, 1.0, 0.96) * (0.92 + 0.20 * (coarse.g - 0.5) + 0.18 * (fine.r - 0.5) + 0.25 * (broad.g - 0.5));
    let marking = mix(bare, paint, there * (0.30 + 0.70 * worn) * (1.0 - 0.65 * chipped));

    // Gravel, and grass that grows into it from its edge: the verge falls from 0 over -2 cm to -14 cm. Beside rising roads, the blue
    // channel gives the distance outwards instead.
    let fallen = select(-0.5 - 40.0 * in.world.z, 0.3 - 11.0 * (in.world.z + 0.02), in.material == GRASS);
    let says = in.material == VERGE;
    let outwards = select(fallen, in.colour.b, says);
    let meadow = vec3f(colour.rg, select(colour.b, 0.36 * colour.g, says));
    let grown = smoothstep(-0.10, 0.14, outwards - 0.34 + 1.3 * (coarse.g - 0.5) + 0.9 * (fine.a - 0.5) + 0.3 * (stones.r - 0.5));
    // Stones of all sizes, some pale or rusty, with earth between them.
    let heap = 0.9 * (fine.r - 0.5) + 1.0 * (stones.r - 0.5) + 0.6 * (stones.g - 0.5);
    let pebbles = mix(vec3f(0.185, 0.172, 0.148), vec3f(0.22, 0.187, 0.140), coarse.g)
        * max(0.25, 1.0 + heap + 0.4 * (coarse.g - 0.5) + 0.8 * smoothstep(0.80, 0.97, stones.r));
    // Like the meadow as seen from the road, see `land.wgsl`: with its ears, and light softer than on a floor.
    let grass = meadow * vec3f(1.16, 1.09, 1.10) * max(0.3, 1.0 + 1.2 * (fine.a - 0.5) + 0.3 * (stones.r - 0.5) + 0.7 * (coarse.g - 0.5));
    let verge = mix(pebbles, grass, grown);

    let tarred = in.material == ASPHALT || line;
    var albedo = select(verge, bare, tarred);
    albedo = select(albedo, marking, line);
    // Water fills the wheels' tracks and hollows, and covers the stones elsewhere only in part. Wet stone and earth are darker.
    var film = 0.0;
    if WET {
        let hollow = smoothstep(0.44, 0.60, 0.6 * coarse.g + 0.4 * broad.g);
        let stony = 0.35 * pale + 0.5 * max(fine.r - 0.5, 0.0);
        // Pavements are rougher, and slope towards the kerb: water runs off them.
        let paved = (0.42 + 0.22 * track + 0.16 * hollow) * mix(1.0, 0.25, smoothstep(0.16, 0.24, select(colour.g, 0.0, line)));
        film = select(0.05, paved - stony * (0.4 + 0.6 * close), tarred);
        albedo *= select(0.75, mix(0.62, 0.48, clamp(film, 0.0, 1.0)), tarred);
    }

    // Stones stand up from the tar: their sides face different directions.
    let rough_ground = select(0.7, 0.22 - 0.1 * track, tarred);
    let normal = normalize(flat_normal + rough_ground * vec3f(fine.r - 0.5, stones.r - 0.5, 0.0));
    let sun = sunshine(in.world, flat_normal);
    let cosine = clamp(dot(normal, frame.to_sun_time.xyz), 0.0, 1.0);
    // Light from ahead meets the sides of the stones, not the plane.
    var light = albedo * (SUN * cosine * sun + ambient(normal) + lamplight(in.world, normal, 1.0));
    // Polished tracks shine more, as does all asphalt at grazing angles. Stones shade each other from a low sun.
    let gloss = select(0.0, 1.0, tarred);
    let rough = steadied(0.70 - 0.1 * track - 0.12 * repair.x, normal);
    let mirror = fresnel(normal, view, 0.02) * 0.16 * gloss;
    // Directions mirrored at grazing angles are low in the sky, behind trees.
    let free = 0.30 + 0.70 * smoothstep(0.04, 0.26, abs(view.z));
    light += mirror * (0.75 + 0.5 * track) * free * sky_light_blurred(vec3f(-view.xy, abs(view.z)), 3.0);
    let hidden = clamp(4.0 * frame.to_sun_time.z * frame.to_sun_time.z, 0.14, 1.0);
    light += sun_glint(normal, view, rough, 0.035) * sun * gloss * hidden * (0.42 + 0.25 * track);
    if WET {
        let share = clamp(film, 0.0, 1.0) * fresnel(flat_normal, view, 0.02);
        let left = through_air_from(distance(in.world, frame.eye.xyz)).g;
        return vec4f(through_air(light * (1.0 - share), in.world), share * left);
    }
    return vec4f(through_air(light, in.world), 1.0);
}
