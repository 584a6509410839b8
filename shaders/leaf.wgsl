// Surfaces of trees, and the cut-out shapes of their leaf cards (`render/textures/leaf_textures.rs`).

struct Surface {
    // The depth pass and the colour pass must find the same depth to the bit.
    @invariant @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) colour: vec3f,
    // Place on the layer.
    @location(3) uv: vec2f,
    // Layer of the leaves' texture.
    @location(4) @interpolate(flat) layer: i32,
    // Tint of the leaves; w has the share of the tree that is drawn, see `kept`.
    @location(5) @interpolate(flat) tint: vec4f,
}

const LEAVES = 10u;
// Number of variants per cut of cards, and the layer after all of them (`render/textures/leaf_textures.rs`).
const VARIANTS = 8;
const BARK_LAYER = 32;

@group(0) @binding(9) var leaves: texture_2d_array<f32>;
@group(0) @binding(10) var leaf_sampler: sampler;

// Returns a point of a tree moved by the wind. The stem moves slowly as a whole, more at the top; twigs and their leaves move separately. A
// light breeze (3 m/s, Beaufort 2) moves the top of a tree of 12 m by some 4 cm and a leaf by 2 cm.
fn swayed(world: vec3f, foot: vec3f, leafy: bool) -> vec3f {
    let wind = frame.forward.w;
    let t = frame.to_sun_time.w;
    let high = max(world.z - foot.z, 0.0);
    // Gusts travel over the land at the speed of the wind.
    let phase = 0.13 * (foot.x + 0.6 * foot.y);
    let gust = 0.6 + 0.4 * sin(0.37 * t - 0.5 * phase);
    let stem = 0.00010 * wind * gust * high * high * (sin(1.3 * t - phase) + 0.4 * sin(2.9 * t - 1.7 * phase));
    let own = dot(world - foot, vec3f(2.3, 3.1, 2.7));
    let flutter = select(0.0, 0.006, leafy) * wind * gust;
    let leaf = flutter * vec3f(sin(2.7 * t + own), sin(3.3 * t + 1.3 * own), 0.6 * sin(4.1 * t + 0.7 * own));
    return world + stem * vec3f(0.8, 0.5, 0.0) + leaf;
}

@vertex
fn vertex(corner: Corner, at: Placed) -> Surface {
    var out: Surface;
    let leafy = corner.material == LEAVES;
    let whole = floor(corner.uv * 0.5);
    out.world = swayed(place(at, corner.position), vec3f(at.x.w, at.y.w, at.z.w), leafy);
    out.clip = frame.clip_from_world * vec4f(out.world, 1.0);
    out.normal = turn(at, corner.normal);
    out.colour = corner.colour * select(vec3f(1.0), at.colour_brake.rgb, leafy);
    out.uv = select(corner.uv, corner.uv - 2.0 * whole, leafy);
    out.layer = select(BARK_LAYER, i32(whole.y) * VARIANTS + i32(whole.x), leafy);
    out.tint = at.colour_brake;
    return out;
}

// Returns cover with edges as sharp as the picture's pixels, at any size of texel.
fn sharpened(inside: f32) -> f32 {
    return clamp((inside - 0.5) / max(fwidth(inside), 0.02) + 0.5, 0.0, 1.0);
}
