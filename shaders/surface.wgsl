// Surfaces of placed meshes.

struct Surface {
    // The same in the passes of a wet road, of which one tests the depth of the other.
    @invariant @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) colour: vec3f,
    @location(3) uv: vec2f,
    @location(4) @interpolate(flat) material: u32,
    // Paint or tint; brake lamps in w, -1 if all lamps are dark.
    @location(5) @interpolate(flat) paint: vec4f,
    // Height above the foot of the instance, metres.
    @location(6) height: f32,
}

const MATT = 0u;
const PAINT = 1u;
const GLASS = 2u;
const BRAKE_LAMP = 3u;
const METAL = 4u;
const TYRE = 5u;
const ASPHALT = 6u;
const MARKING = 7u;
const GRASS = 8u;
const BARK = 9u;
const LEAVES = 10u;
const LAMP = 11u;
const PLATE = 12u;
const VERGE = 13u;
const SIGNAL_LAMP = 14u;
const REFLECTOR = 15u;
const HEAD_LAMP = 16u;
const WALL = 17u;
const ROOF = 18u;
const HEDGE = 19u;

// True for the picture of a body in the water under it.
override IN_WATER: bool = false;

fn surface(corner: Corner, at: Placed) -> Surface {
    var out: Surface;
    out.world = place(at, corner.position);
    let depth = select(0.0, 2.0 * (out.world.z - at.z.w), IN_WATER);
    out.clip = frame.clip_from_world * vec4f(out.world - vec3f(0.0, 0.0, depth), 1.0);
    out.normal = turn(at, corner.normal);
    out.colour = corner.colour;
    out.uv = corner.uv;
    out.material = corner.material;
    let coded = abs(at.colour_brake.w);
    let number = floor(coded);
    out.paint = vec4f(at.colour_brake.rgb, select(2.0 * (coded - number), -1.0, at.colour_brake.w < 0.0));
    // Keeps only the signs of the plate's number (`scene/car/number_plate.rs`).
    let signs = floor(corner.uv.y / 16.0);
    let sign = floor((number + 0.5) / max(corner.uv.x, 1.0));
    let shown = abs(sign - signs * floor((sign + 0.5) / max(signs, 1.0)) - (corner.uv.y - 16.0 * signs)) < 0.5;
    out.clip = select(out.clip, vec4f(2.0, 2.0, 2.0, 1.0), corner.material == PLATE && number > 0.5 && corner.uv.x > 0.5 && !shown);
    // Parked cars stand behind fences and hedges, which hide them from the water on the road.
    out.clip = select(out.clip, vec4f(2.0, 2.0, 2.0, 1.0), IN_WATER && at.colour_brake.w < 0.0);
    out.height = out.world.z - at.z.w;
    return out;
}
