// Buildings: walls of plaster or brick with windows, doors and shops, tiled roofs, hedges. uv of walls: metres along and above the ground
// floor; of roofs: along the eaves and up the slope. The bits above the material's number are those of `scene/buildings/facade.rs`.

const STOREY = 3.0;
const SHOP = 3.6;
// Depth of a window behind the wall, metres.
const DEPTH = 0.14;
// True for walls, false for all else of a building. Software rendering executes both sides of a branch, so each has a program of its own.
override OPENINGS: bool = true;
// Share of the windows that are lit at night, and their radiance before the factor on lamps.
const LIT = 0.4;
const WINDOW_LIGHT = 0.16;

// Half the width and height of a window, height of its middle over the floor, half the width of a pane; metres, by `WindowKind`.
const WINDOWS = array(
    vec4f(0.58, 0.70, 1.60, 0.29),
    vec4f(0.98, 0.66, 1.58, 0.327),
    vec4f(0.50, 0.95, 1.62, 0.25),
    vec4f(0.45, 0.52, 1.40, 0.45),
);
const SIGNS = array(
    vec3f(0.30, 0.03, 0.03), vec3f(0.03, 0.12, 0.20), vec3f(0.05, 0.16, 0.07), vec3f(0.45, 0.42, 0.36),
    vec3f(0.07, 0.07, 0.08), vec3f(0.38, 0.22, 0.03), vec3f(0.22, 0.05, 0.16), vec3f(0.02, 0.15, 0.16),
);

// Returns the share of a pixel of width `wide` that lies within a rectangle of half size `half` about the origin.
fn inside(at: vec2f, half: vec2f, wide: vec2f) -> f32 {
    return covered(at.x, half.x, wide.x) * covered(at.y, half.y, wide.y);
}

// Returns the distance from the nearest line of a row of lines `every` apart, of which one goes through 0.
fn off_line(at: f32, every: f32) -> f32 {
    return abs(at - every * round(at / every));
}

struct Wall {
    // Colour of wall, frame or what is seen through glass.
    albedo: vec3f,
    // Share of glass, which mirrors.
    glass: f32,
    // Light from inside.
    light: vec3f,
}

fn wall_at(in: Surface, facet: vec3f, view: vec3f, stains: vec4f, fine: vec4f) -> Wall {
    let bits = in.material;
    let bay = 0.1 * f32((bits >> 8u) & 63u);
    let storeys = f32((bits >> 14u) & 7u);
    let kind = (bits >> 17u) & 3u;
    let brick = ((bits >> 19u) & 1u) == 1u;
    let ground_floor = (bits >> 20u) & 3u;
    let seed = i32((bits >> 22u) & 255u);
    let wide = max(fwidth(in.uv), vec2f(0.002));

    // The storey, and the place within its bay.
    let shops = ground_floor == 2u;
    let first = select(STOREY, SHOP, shops);
    let storey = select(1.0 + floor((in.uv.y - first) / STOREY), 0.0, in.uv.y < first);
    let floor_m = select(first + (storey - 1.0) * STOREY, 0.0, storey < 0.5);
    let column = floor(in.uv.x / max(bay, 0.1));
    let number = i32(column) * 31 + i32(storey) * 57 + seed * 113;
    let shop = shops && storey < 0.5;
    let door = ground_floor == 1u && storey < 0.5 && column > 0.5 && column < 1.5;
    var windows = WINDOWS;
    var size = windows[kind];
    size = select(size, vec4f(0.52, 1.06, 1.06, 2.0), door);
    size = select(size, vec4f(0.5 * bay - 0.22, 1.25, 1.62, 0.25 * bay), shop);
    let open = select(0.0, 1.0, ground_floor != 3u && in.uv.y > 0.0 && storey < storeys);
    let at = vec2f(in.uv.x - (column + 0.5) * bay, in.uv.y - floor_m - size.z);

    // What is seen in the window's plane lies behind the wall's.
    let right = vec3f(-facet.y, facet.x, 0.0);
    let facing = max(dot(view, facet), 0.06);
    let behind = -vec2f(dot(view, right), view.z) / facing;
    let pane = at + DEPTH * behind;
    let half = size.xy;
    let opening = open * inside(at, half, wide);
    let seen = inside(pane, half, wide);
    // Frame around the window and between its panes; doors have panels.
    let post = off_line(abs(pane.x) - select(0.0, size.w, kind == 1u && !shop), 2.0 * size.w);
    let bar = select(9.0, abs(pane.y - 0.35 * half.y), kind == 2u && !shop);
    let pane_half = half - select(0.07, 0.05, shop);
    var glass = inside(pane, pane_half, wide) * (1.0 - covered(post, 0.035, wide.x)) * (1.0 - covered(bar, 0.03, wide.y));
    glass = select(glass, inside(pane - vec2f(0.0, 0.45), vec2f(0.28, 0.35), wide), door);

    // Wall: plaster with stains, or courses of brick; lighter bands around tall windows and under all, shutters at some houses.
    let near = 1.0 - smoothstep(0.03, 0.12, wide.y);
    // Mean of bricks and mortar, as from afar.
    var bricked = mix(in.colour, vec3f(0.30, 0.28, 0.25), 0.06);
    if SOFT > 0.5 {
        let row = floor(in.uv.y / 0.075);
        let bricks = vec2f(in.uv.x + 0.125 * (row - 2.0 * floor(0.5 * row)), in.uv.y);
        let mortar = max(covered(off_line(bricks.x, 0.25), 0.006, wide.x), covered(off_line(bricks.y, 0.075), 0.006, wide.y));
        let tone = 1.0 + near * 0.45 * (hash(i32(row) * 71 + i32(floor(bricks.x / 0.25)) * 13) - 0.5);
        bricked = mix(in.colour * tone, vec3f(0.30, 0.28, 0.25), 0.75 * mortar * mix(0.6, 1.0, near));
    }
    let plastered = in.colour * (1.0 + 0.10 * (fine.r - 0.5));
    var albedo = select(plastered, bricked, brick) * (1.0 + 0.22 * (stains.g - 0.5));
    let band = open * select(0.0, 1.0, !shop && !door) * inside(at + vec2f(0.0, half.y + 0.05), vec2f(half.x + 0.09, 0.05), wide);
    let stone = open * select(0.0, 1.0, kind == 2u && !shop && !door) * inside(at, half + 0.13, wide);
    albedo = mix(albedo, vec3f(0.50, 0.48, 0.44), max(band, 0.8 * stone));
    let shutters = open * select(0.0, 1.0, kind == 0u && storeys < 2.5 && !door && hash(seed * 17 + 5) < 0.4)
        * inside(vec2f(abs(at.x) - half.x - 0.29, at.y), vec2f(0.26, half.y), wide);
    var signs = SIGNS;
    let paint = signs[u32(seed) & 7u];
    var slats = 0.86;
    if SOFT > 0.5 {
        slats = 1.0 - 0.35 * covered(off_line(at.y, 0.09), 0.018, wide.y);
    }
    albedo = mix(albedo, paint * slats, shutters);
    // Plinth, and the sign over shops.
    albedo = mix(albedo, vec3f(0.15, 0.145, 0.135) * (1.0 + 0.3 * (fine.r - 0.5)), 1.0 - smoothstep(-0.01, 0.01, in.uv.y + 0.02));
    let house = i32(floor(0.5 * column)) + seed;
    let board = select(0.0, 1.0, shop) * inside(vec2f(at.x, in.uv.y - 3.18), vec2f(bay, 0.24), wide);
    let shown = signs[u32(house * 5 + 3) & 7u];
    var text = 0.0;
    if SOFT > 0.5 {
        let letter = hash(i32(floor(in.uv.x / 0.19)) * 7 + house) - 0.35;
        text = near * select(0.0, 1.0, letter > 0.0 && abs(at.x) < 0.33 * bay)
            * inside(vec2f(0.0, in.uv.y - 3.18), vec2f(1.0, 0.05 + 0.08 * letter), wide);
    }
    albedo = mix(albedo, mix(shown, vec3f(0.6, 0.58, 0.52), text), board);
    // The eaves and the ground shade the wall.
    albedo *= mix(0.62, 1.0, smoothstep(-0.35, 1.2, in.uv.y));

    // Through the glass: a dim room with curtains or blinds; shelves in shops.
    let curtain = hash(number * 3 + 1);
    let drawn = select(step(half.x * (0.35 + 0.5 * hash(number * 3 + 2)), abs(pane.x)), step(half.y * (1.0 - 1.6 * hash(number * 3 + 2)), pane.y), curtain > 0.6);
    let fabric = drawn * step(0.25, curtain);
    var room = mix(vec3f(0.035, 0.033, 0.030), vec3f(0.34, 0.33, 0.30), fabric);
    var wares = vec3f(0.16, 0.15, 0.135);
    if SOFT > 0.5 {
        let deep = at + 1.6 * behind;
        let shelf = vec2f(floor(deep.x / 0.55), floor(deep.y / 0.42));
        let goods = hash(i32(shelf.x) * 19 + i32(shelf.y) * 7 + house);
        wares = mix(vec3f(0.05), signs[u32(i32(shelf.x) * 3 + i32(shelf.y) + house) & 7u] + 0.08, step(0.35, goods) * goods);
    }
    room = select(room, wares, shop);
    let frame_colour = select(vec3f(0.55, 0.54, 0.52), paint, door || shop || hash(seed * 29 + 1) < 0.25);
    var out: Wall;
    out.glass = opening * seen * glass;
    // The sides of the opening are in shade, except for the sill.
    let reveal = albedo * select(0.45, 0.85, pane.y < -half.y);
    let window = mix(reveal, mix(frame_colour, room, glass), seen);
    out.albedo = mix(albedo, window, opening);
    let lit = select(step(hash(number * 7 + 3), LIT), 0.75, shop);
    let warm = mix(vec3f(1.0, 0.62, 0.30), vec3f(0.95, 0.86, 0.70), hash(number * 11 + 7));
    out.light = out.glass * lit * warm * (0.35 + 0.9 * hash(number * 5 + 2)) * select(mix(1.0, 0.6, fabric), 0.3 + 1.2 * room.r, shop)
        + 0.25 * board * text * vec3f(1.0, 0.95, 0.85);
    return out;
}

// Returns the colour of tiles, in rows of which each covers the upper edge of the one below.
fn tiles_at(in: Surface, stains: vec4f, fine: vec4f) -> vec3f {
    let wide = max(fwidth(in.uv), vec2f(0.002));
    let near = 1.0 - smoothstep(0.10, 0.35, wide.y);
    let row = floor(in.uv.y / 0.33);
    let up = in.uv.y / 0.33 - row;
    let aside = in.uv.x / 0.24 - 0.5 * (row - 2.0 * floor(0.5 * row));
    let tile = floor(aside);
    let round_tile = aside - tile - 0.5;
    let tone = 1.0 + near * (0.30 * (hash(i32(row) * 37 + i32(tile) * 101) - 0.5) - 0.5 * smoothstep(0.86, 1.0, up) - 1.3 * round_tile * round_tile + 0.11);
    let moss = smoothstep(0.55, 0.75, stains.g) * 0.35;
    let albedo = in.colour * tone * (1.0 + 0.25 * (stains.g - 0.5) + 0.12 * (fine.r - 0.5));
    return mix(albedo, vec3f(0.055, 0.062, 0.035), moss);
}

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let view = to_eye(in.world);
    let facet = normalize(in.normal);
    let material = in.material & 255u;
    let flat_place = vec2f(dot(in.world.xy, vec2f(0.8, 0.6)), in.world.z + 0.3 * in.world.x);
    let stains = grain_at(flat_place / 6.3);
    var fine = vec4f(0.5);
    if SOFT > 0.5 {
        fine = grain_at(flat_place.yx / 1.7);
    }
    // No vehicle is near enough to shade a building visibly.
    let sun = sunshine_in_trees(in.world, facet);
    let above = ambient(vec3f(0.0, 0.0, 1.0));
    var light: vec3f;
    if OPENINGS {
        let wall = wall_at(in, facet, view, stains, fine);
        let cosine = clamp(dot(facet, frame.to_sun_time.xyz), 0.0, 1.0);
        // Little light comes into a room and out again, and little of the sun.
        let into = vec2f(1.0 - 0.72 * wall.glass, 1.0 - 0.9 * wall.glass);
        light = wall.albedo * (SUN * (cosine * sun * into.y) + (ambient(facet) * 0.92 + lamplight(in.world, facet, 0.4)) * into.x);
        let reflected = wall.glass * min(2.0 * fresnel(facet, view, 0.045), 0.8);
        let bounced = reflect(-view, facet);
        var image: vec3f;
        if SOFT > 0.5 {
            image = mirrored(bounced, 0.10 * (SUN * frame.to_sun_time.z + above), 0.02);
            light += wall.glass * sun * sun_gloss(facet, view, 0.12, vec3f(0.05), 1.0);
        } else {
            // One unfiltered texel of the sky, and dark houses below it.
            let sky_seen = textureLoad(sky, vec2i(sky_place(bounced) * vec2f(textureDimensions(sky))), 0).rgb;
            image = mix(0.10 * above, sky_seen, smoothstep(0.10, 0.22, bounced.z));
        }
        light = light * (1.0 - reflected) + reflected * image;
        let dark = select(0.0, 1.0, frame.lamps.x > 0.0);
        light += wall.light * (WINDOW_LIGHT * frame.lamps.y * dark);
    } else {
        // Leaves of a hedge.
        let leaves = grain_at((flat_place + in.world.yz) / 0.9);
        let hedge = in.colour * max(0.25, 1.0 + 1.6 * (leaves.a - 0.5) + 0.9 * (leaves.r - 0.5) + 0.8 * (stains.g - 0.5));
        let is_hedge = material == HEDGE;
        var albedo = in.colour * (1.0 + 0.10 * (stains.g - 0.5));
        albedo = select(albedo, tiles_at(in, stains, fine), material == ROOF);
        albedo = select(albedo, hedge, is_hedge);
        let lean = vec3f(leaves.r - 0.5, leaves.a - 0.5, 0.6 * (leaves.g - 0.5)) * 1.6;
        let normal = normalize(facet + select(vec3f(0.0), lean, is_hedge));
        let cosine = clamp(dot(normal, frame.to_sun_time.xyz), 0.0, 1.0);
        light = albedo * (SUN * (cosine * sun) + ambient(normal) + lamplight(in.world, normal, 0.4));
    }
    return vec4f(through_air(light, in.world), 1.0);
}
