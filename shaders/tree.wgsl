// Trees: bark, and crowns of leaves that are cut out of the model's coarse clumps and let light through.

// Share of a pixel that leaves must cover to be drawn: one half without multisampling, less with it.
override LEAST_COVER: f32 = 0.5;

// What is cut out of a leaf card (`scene/foliage.rs`).
const MASS = 1;
const HEAP = 2;
const BOUGH = 3;
const BLADES = 4;

// What is found at a place of a leaf card.
struct Leaf {
    // How far inside a leaf, in widths of the pattern; negative between leaves.
    inside: f32,
    // A number of this leaf, 0..1.
    own: f32,
    // Which way it leans, -1..1.
    lean: vec2f,
    // How many widths of the pattern a unit of the card holds.
    fine: f32,
}

fn chance(cell: vec2f, salt: f32) -> vec2f {
    let p = fract(vec3f(cell.xyx + salt * 3.71) * vec3f(0.1031, 0.1030, 0.0973));
    let q = p + dot(p, p.yzx + 33.33);
    return fract((q.xx + q.yz) * q.zy);
}

// How far a place is inside the ragged outline of a spray; c is the place, -1..1 on the card.
fn outline(c: vec2f, variant: f32) -> f32 {
    let lobes = sin(c.x * 5.3 + variant * 2.1) * sin(c.y * 4.7 - variant * 1.3);
    return 0.80 - 0.17 * lobes - length(c);
}

// One leaf in each square of a lattice, turned at random, and only where the spray is.
fn leaf_of(p: vec2f, count: f32, variant: f32, salt: f32) -> Leaf {
    let cell = floor(p);
    let luck = chance(cell, variant + salt);
    let q = p - cell - vec2f(0.5) + 0.24 * (luck - 0.5);
    let axis = normalize(luck.yx - vec2f(0.4999, 0.5));
    let along = dot(q, axis);
    let across = abs(dot(q, vec2f(-axis.y, axis.x)));
    // A lens, blunt at its stalk.
    let inside = 0.31 * (1.0 - 4.3 * along * along) * (1.0 + 0.5 * along) - across;
    let there = outline((cell + 0.5) * (2.0 / count) - 1.0, variant);
    return Leaf(min(inside, there * 4.0), luck.x, 2.0 * luck.yx - 1.0, count);
}

fn spray(at: vec2f, count: f32, variant: f32) -> Leaf {
    let a = leaf_of(at * count, count, variant, 0.0);
    // A second layer, askew: (0.8, 0.6) turns about the middle of the card.
    let d = at - 0.5;
    let turned = vec2f(0.8 * d.x - 0.6 * d.y, 0.6 * d.x + 0.8 * d.y) + 0.5;
    let b = leaf_of(turned * count + 0.37, count, variant, 17.0);
    // The upper leaf wins, so that leaves lie on each other.
    if a.inside > 0.0 {
        return a;
    }
    var lower = b;
    lower.own *= 0.6;
    lower.inside = max(a.inside, b.inside);
    return lower;
}

// A stem along v, twigs forwards and to either side, shorter towards the tip.
fn bough(at: vec2f, variant: f32) -> Leaf {
    let side = abs(2.0 * at.x - 1.0);
    let right = select(0.0, 7.0, at.x > 0.5);
    let phase = at.y * 11.0 - side * 3.6;
    let luck = chance(vec2f(floor(phase), right), variant);
    let reach = (1.0 - 0.85 * at.y * at.y) * (0.62 + 0.38 * luck.x);
    let twig = 0.46 - abs(fract(phase) - 0.5) - 0.25 * side;
    // Needles make the twigs' edges rough.
    let needles = 0.14 * sin(side * 60.0 + luck.y * 9.0);
    let inside = min(twig + needles, (reach - side) * 3.0);
    return Leaf(max(inside, 0.4 - side * 7.0), luck.x, vec2f(0.4 * luck.y - 0.2, 0.2), 11.0);
}

// Blades that stand on v 0 and lean somewhat.
fn blades(at: vec2f, variant: f32) -> Leaf {
    var best = Leaf(-1.0, 0.5, vec2f(0.0), 12.0);
    for (var layer = 0; layer < 2; layer++) {
        let root = floor(at.x * 10.0 + 0.5 * f32(layer));
        let luck = chance(vec2f(root, f32(layer) * 5.0), variant);
        let lean = (luck.y - 0.5) * 2.2 * at.y * at.y;
        let x = fract(at.x * 10.0 + 0.5 * f32(layer)) - 0.5 + 0.0 * lean;
        let height = (0.45 + 0.55 * luck.x) * (1.0 - 1.6 * (at.x - 0.5) * (at.x - 0.5));
        let inside = 0.26 * (1.0 - at.y / height) - abs(x - lean * 0.4);
        if inside > best.inside {
            best = Leaf(inside, luck.x, vec2f(lean, luck.y - 0.5), 10.0);
        }
    }
    return best;
}

fn leaf_at(uv: vec2f) -> Leaf {
    let whole = floor(uv * 0.5);
    let at = uv - 2.0 * whole;
    let cut = i32(whole.y);
    if cut == BOUGH {
        return bough(at, whole.x);
    }
    if cut == BLADES {
        return blades(at, whole.x);
    }
    return spray(at, select(select(6.0, 10.0, cut == MASS), 15.0, cut == HEAP), whole.x);
}

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let view = to_eye(in.world);
    let leaves = in.material == LEAVES;
    let spread = max(length(dpdx(in.uv)), length(dpdy(in.uv)));
    var leaf = Leaf(1.0, 0.5, vec2f(0.0), 1.0);
    var cover = 1.0;
    var small = 0.0;
    if leaves {
        leaf = leaf_at(in.uv);
        // Where leaves are smaller than a pixel the spray closes: its outline stays, not its grain.
        let pixel = spread * leaf.fine;
        small = smoothstep(0.35, 1.4, pixel);
        cover = clamp((leaf.inside + 0.16 * small) / max(pixel, 0.05) + 0.5 + 0.3 * small, 0.0, 1.0);
        if cover < LEAST_COVER {
            discard;
        }
    }

    var normal = normalize(in.normal);
    let sun_direction = frame.to_sun_time.xyz;
    // Leaves are no surface: their shade begins some way behind them.
    let sun = sunshine(in.world + select(0.0, 0.8, leaves) * sun_direction, normal);
    var albedo = in.colour;
    if leaves {
        let each = 1.0 - small;
        normal = normalize(normal + 0.55 * each * vec3f(leaf.lean, 0.35 * (leaf.lean.x - leaf.lean.y)));
        // Leaves differ, and are darker where they meet the twig.
        albedo *= in.paint.rgb * (1.0 + each * (0.75 * (leaf.own - 0.5) + 0.5 * (min(leaf.inside, 0.25) - 0.12)));
    } else {
        let rough = grain_at(vec2f(in.uv.x * 0.9, in.uv.y * 0.11));
        albedo *= 1.0 + 1.5 * (rough.a - 0.5) + 0.5 * (rough.r - 0.5);
    }
    let facing = dot(normal, sun_direction);
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
