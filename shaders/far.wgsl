// Far trees: a picture of the tree that faces the eye (`render/textures/impostor.rs`).

struct Corner {
    // x and z: place on the picture, -1..1 on a square or beyond it, times half its side in metres; y: height of its centre, metres
    @location(0) position: vec3f,
    // x: number of the first picture; y and z: share of half the side that the tree fills across and in height
    @location(1) first: vec3f,
    // x: half the side, metres
    @location(3) side: vec2f,
}

struct Surface {
    // The depth pass and the colour pass must find the same depth to the bit.
    @invariant @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) uv: vec2f,
    // The two nearest pictures, and the share of the second.
    @location(2) @interpolate(flat) pictures: vec3f,
    @location(3) @interpolate(flat) tint: vec4f,
    // Rotation from the tree's frame to the world: cosine and sine; distance of the leaves in front of the picture, metres.
    @location(4) @interpolate(flat) turn: vec3f,
}

const SIDES = 16.0;
const TAU = 6.2831853;

@group(0) @binding(9) var leaves: texture_2d_array<f32>;
@group(0) @binding(10) var leaf_sampler: sampler;
@group(0) @binding(11) var pictures: texture_2d_array<f32>;

@vertex
fn vertex(corner: Corner, at: Placed) -> Surface {
    let size = length(at.z.xyz);
    let foot = vec3f(at.x.w, at.y.w, at.z.w);
    let cosine = at.x.x / size;
    let sine = at.y.x / size;
    var right = vec3f(cosine, sine, 0.0);
    var up = vec3f(-sine, cosine, 0.0);
    var s: Surface;
    if FROM_ABOVE {
        s.pictures = vec3f(vec2f(corner.first.x + SIDES), 0.0);
    } else {
        let flat_way = mix(-frame.forward.xy, frame.eye.xy - foot.xy, frame.eye.w);
        let out = flat_way * inverseSqrt(max(dot(flat_way, flat_way), 1e-8));
        right = vec3f(-out.y, out.x, 0.0);
        up = vec3f(0.0, 0.0, 1.0);
        // Azimuth of the eye in the tree's frame.
        let local = vec2f(out.x * cosine + out.y * sine, out.y * cosine - out.x * sine);
        let place = fract(atan2(local.y, local.x) / TAU) * SIDES;
        let before = floor(place);
        s.pictures = vec3f(corner.first.x + vec2f(before, (before + 1.0) % SIDES), place - before);
    }
    let half_side = corner.side.x;
    // Only the part of the picture that is not empty.
    let place_m = corner.position.xz * select(corner.first.yz, corner.first.yy, FROM_ABOVE);
    s.world = foot + size * (right * place_m.x + up * place_m.y + vec3f(0.0, 0.0, corner.position.y));
    s.clip = frame.clip_from_world * vec4f(s.world, 1.0);
    s.uv = vec2f(0.5, 0.5) + vec2f(0.5, -0.5) * place_m / half_side;
    s.tint = at.colour_brake;
    // From above the unshaded tops are visible.
    s.turn = vec3f(cosine, sine, select(0.5, 0.85, FROM_ABOVE) * half_side * size);
    return s;
}

// Returns the share of the second picture: the change takes the middle third between the two directions.
fn turned(in: Surface) -> f32 {
    return smoothstep(0.33, 0.67, in.pictures.z);
}

// Returns the number of the picture for a pixel of one sample: the nearer one.
fn chosen(in: Surface) -> i32 {
    if FROM_ABOVE {
        return 2 * i32(in.pictures.x + 0.5);
    }
    return 2 * i32(select(in.pictures.x, in.pictures.y, in.pictures.z > 0.5) + 0.5);
}
