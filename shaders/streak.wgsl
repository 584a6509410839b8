// Streaks of lamps on a wet road (`scene/mirrored_lamps.rs`): the mirror image of a lamp in rough water is drawn out along the line of sight.

// Slope of the water's waves: how much longer and wider an image is for a metre between lamp and eye, and for a metre of their heights.
const LONG = 0.045;
const WIDE = 0.030;
// Light of a streak beside that of its lamp, where both are as large.
const STRENGTH = 1.0;

struct Streak {
    @builtin(position) clip: vec4f,
    // Place in the streak, -1..1.
    @location(0) at: vec2f,
    @location(1) @interpolate(flat) light: vec3f,
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, at: Placed) -> Streak {
    let p = square_corner(corner);
    let lamp = place(at, vec3f(0.0));
    let radius = at.x.x;
    let height = at.colour_brake.w;
    let image = lamp - vec3f(0.0, 0.0, 2.0 * height);
    let away = distance(image.xy, frame.eye.xy);
    let above = max(frame.eye.z - lamp.z + height, 0.1);
    // Half axes of the image, metres. Its light is spread over them.
    let long = radius + 0.35 * height + LONG * away;
    let wide = radius + WIDE * (height + above);
    let spread = radius * radius / (long * wide);
    // Nearer than the image, so that the body around the lamp does not hide it.
    let nearer = normalize(vec3f(frame.eye.xy - image.xy, 0.0)) * min(1.0, 0.3 * away);
    let world = image + nearer + 2.0 * (wide * p.x * normalize(frame.right.xyz) + long * p.y * vec3f(0.0, 0.0, 1.0));
    let left = through_air_from(away).g;
    return Streak(frame.clip_from_world * vec4f(world, 1.0), p, at.colour_brake.rgb * (STRENGTH * spread * left * frame.lamps.y));
}

@fragment
fn fragment(in: Streak) -> @location(0) vec4f {
    let inside = max(1.0 - dot(in.at, in.at), 0.0);
    return vec4f(in.light * inside * inside * exp(-4.0 * in.at.x * in.at.x), 0.0);
}
