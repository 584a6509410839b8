// Surfaces of placed meshes.

struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) colour: vec3f,
    @location(3) uv: vec2f,
    @location(4) @interpolate(flat) material: u32,
    // Paint or tint; brake lamps in w.
    @location(5) @interpolate(flat) paint: vec4f,
    // Height over the foot of the instance, metres.
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

@vertex
fn vertex(corner: Corner, at: Placed) -> Surface {
    var out: Surface;
    out.world = place(at, corner.position);
    out.clip = frame.clip_from_world * vec4f(out.world, 1.0);
    out.normal = turn(at, corner.normal);
    out.colour = corner.colour;
    out.uv = corner.uv;
    out.material = corner.material;
    out.paint = at.colour_brake;
    out.height = out.world.z - at.z.w;
    return out;
}
