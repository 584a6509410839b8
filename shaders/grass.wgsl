// Tufts of grass: cards that are cut into blades and move in the wind. All light is computed at the vertices, so that a pixel needs no
// light sample. Near the end of their range tufts are few and low, and never cut off.

// Share of a pixel that blades must cover to be drawn: one half without multisampling, less with it.
override LEAST_COVER: f32 = 0.5;
// Distance up to which the renderer draws tufts, metres.
override REACH_M: f32 = 30.0;

// Variant of cards with stalks that carry ears and flowers (`scene/land/verge.rs`).
const STALKS = 7.0;
const COLUMNS = 15.0;

struct Blade {
    @builtin(position) clip: vec4f,
    // Place on the card, 0..1.
    @location(0) at: vec2f,
    @location(1) light: vec3f,
    // Light of the air between the tuft and the eye.
    @location(2) veil: vec3f,
    // Number of the card; random number of the tuft, 0..1.
    @location(3) @interpolate(flat) card: vec2f,
}

@vertex
fn vertex(corner: Corner, at: Placed) -> Blade {
    let root = vec3f(at.x.w, at.y.w, at.z.w);
    let variant = floor(corner.uv.x * 0.5);
    let own = hash(i32(floor(root.x * 64.0)) * 8191 + i32(floor(root.y * 64.0)));
    // Tufts are fewer and lower with distance.
    let end_m = REACH_M * (0.45 + 0.52 * own);
    var grown = 1.0 - smoothstep(0.55 * end_m, end_m, distance(root, frame.eye.xyz));
    // Only some tufts have stalks.
    grown *= select(1.0, step(fract(own * 17.0), 0.3), variant == STALKS);
    grown *= step(0.04, grown);
    var out: Blade;
    out.at = corner.uv - 2.0 * floor(corner.uv * 0.5);
    out.card = vec2f(variant, own);
    var world = place(at, corner.position * vec3f(1.0, 1.0, grown) - vec3f(0.0, 0.0, 0.05 * (1.0 - grown)));
    // Gusts of 20 m with a wind from the south-west, and the tufts' own swing. Blades bend less the lower they already lie. A breeze of 2.5
    // m/s moves their tips by up to a fifth of their height.
    let wind = frame.forward.w;
    let t = frame.to_sun_time.w;
    let way = dot(root.xy, vec2f(0.8, 0.6));
    let gust = 0.5 + 0.5 * sin(0.31 * way - 0.44 * wind * t);
    let swing = gust * (0.55 + 0.45 * sin(2.6 * t - 1.9 * way + 9.0 * own));
    let height = max(world.z - root.z, 0.0);
    world += vec3f(0.8, 0.6, -0.15) * (0.35 * (1.0 - exp(-0.4 * wind)) * swing * height);

    let sun_way = frame.to_sun_time.xyz;
    let view = to_eye(world);
    let normal = normalize(turn(at, corner.normal));
    let sun = sunshine(root + vec3f(0.0, 0.0, 0.15), vec3f(0.0, 0.0, 1.0));
    let cosine = clamp((dot(normal, sun_way) + 0.25) / 1.25, 0.0, 1.0);
    let against = clamp(dot(-view, sun_way), 0.0, 1.0);
    let through = (0.06 + 0.45 * against * against) * out.at.y * vec3f(1.0, 1.05, 0.4);
    // Low tufts have no dark foot.
    var albedo = corner.colour * at.colour_brake.rgb * mix(0.95 / (0.52 + 0.78 * out.at.y), 1.0, grown);
    if variant == STALKS {
        albedo = mix(albedo, vec3f(0.27, 0.235, 0.13), 0.25 + 0.6 * out.at.y);
    }
    let light = albedo * (SUN * sun * (cosine + through) + ambient(normal) * 0.85 + lamplight(world, normal, 0.8));
    let ray = world - frame.eye.xyz;
    let far_m = length(ray);
    let left = through_air_from(far_m);
    out.light = light * left;
    out.veil = sky_light(vec3f(ray.xy, max(ray.z, 0.0) + 0.01 * far_m) / max(far_m, 0.01)) * (1.0 - left);
    out.clip = frame.clip_from_world * vec4f(world, 1.0);
    return out;
}

fn chance(cell: vec2f, salt: f32) -> vec2f {
    let p = fract(vec3f(cell.xyx + salt * 3.71) * vec3f(0.1031, 0.1030, 0.0973));
    let q = p + dot(p, p.yzx + 33.33);
    return fract((q.xx + q.yz) * q.zy);
}

@fragment
fn fragment(in: Blade) -> @location(0) vec4f {
    let stalks = in.card.x == STALKS;
    let columns = select(COLUMNS, 9.0, stalks);
    let salt = in.card.x + 8.0 * floor(in.card.y * 16.0);
    let pixel = fwidth(in.at.x) * columns / (0.45 + 0.55 * in.at.y);
    // Distance inside a blade, in columns; random number of the blade.
    var inside = -1.0;
    var own = 0.5;
    // 0 no flower, 1 petals, 2 the centre of a white one.
    var flower = 0.0;
    let flowering = fract(in.card.y * 71.0) < 0.3;
    // Blades spread like a fan from a foot a third as wide as the card.
    let place = vec2f((in.at.x - 0.5) / (0.34 + 0.66 * in.at.y) + 0.5, in.at.y);
    for (var layer = 0; layer < 3; layer++) {
        let each = f32(layer);
        // Layers lean in different directions.
        let shear = (fract(salt * 0.37 + each * 0.41) - 0.5) * 0.55;
        let x = (place.x - shear * in.at.y * in.at.y) * columns + 0.37 * each;
        let luck = chance(vec2f(floor(x), each * 5.0), salt);
        let middle = clamp(place.x - 0.5, -0.5, 0.5);
        let height = (0.40 + 0.58 * luck.x) * (1.0 - 1.7 * middle * middle);
        let up = in.at.y / height;
        let bend = (luck.y - 0.5) * 0.7 * up * up;
        let blade = 0.21 * sqrt(max(1.0 - up, 0.0)) - abs(fract(x) - 0.5 - bend) - select(0.0, 1.0, up > 1.0 || abs(place.x - 0.5) > 0.5);
        // A stalk is thin and its ear is thick; some carry a flower of 3 cm instead. A card of stalks is as high as 7.5 of its columns are
        // wide.
        let off = abs(fract(x) - 0.5 - 0.5 * bend);
        let blooms = flowering && luck.x > 0.72;
        let from_head = length(vec2f(off, (up - 0.95) * height * 7.5));
        let ear = smoothstep(0.70, 0.78, up) * (1.0 - smoothstep(0.93, 1.0, up));
        let stalk = select(0.030 + 0.085 * ear - off, max(0.028 - off, 0.25 - from_head), blooms)
            - select(0.0, 1.0, up > 1.0 || luck.x < 0.45);
        let found = select(blade, stalk, stalks);
        if found > inside {
            inside = found;
            own = luck.x;
            flower = select(0.0, select(1.0, 2.0, from_head < 0.09), blooms && from_head < 0.27);
        }
    }
    // Where blades are smaller than a pixel, covers as many of its samples as there are blades at this height.
    let many = smoothstep(0.30, 1.1, pixel);
    let one = clamp(inside / max(pixel, 0.05) + 0.5, 0.0, 1.0);
    let side = 1.0 - 3.9 * (place.x - 0.5) * (place.x - 0.5);
    let share = select(1.15, 0.25, stalks) * (1.0 - smoothstep(0.25, 1.0, in.at.y / max(side, 0.001)));
    let cover = mix(one, clamp(share + select(0.4, 1.2, stalks) * (own - 0.5), 0.0, 1.0), many);
    if cover < LEAST_COVER {
        discard;
    }
    // Blades differ in brightness.
    let tone = 1.0 + (1.0 - many) * (0.6 * (own - 0.5) + 0.9 * (min(inside, 0.2) - 0.07));
    var tint = vec3f(tone);
    // Some stalks carry flowers: white, yellow, violet.
    let kind = fract(in.card.y * 37.0);
    let yellow = vec3f(1.8, 1.5, 0.35);
    let petal = select(select(vec3f(1.9, 1.95, 2.6), yellow, kind > 0.45 || flower > 1.5), vec3f(1.05, 0.85, 1.7), kind > 0.8);
    tint = select(tint, petal, stalks && flower > 0.5);
    return vec4f(in.light * tint + in.veil, cover);
}
