// Falling drops, as the streaks that the eye sees of them. The drops stand in a box around the eye, whose sides are joined: a drop that
// leaves it below comes in above.

struct Streak {
    @builtin(position) clip: vec4f,
    // Place across and along the streak, -1..1.
    @location(0) at: vec2f,
    // Radiance; opacity in w.
    @location(1) @interpolate(flat) light: vec4f,
}

// Size of the box, metres.
const BOX = vec3f(16.0, 16.0, 8.0);
// Drift of drops by each m/s of wind.
const DRIFT = 0.4;
// Time over which the eye sees a drop as a streak, s.
const SEEN_S = 0.03;
// Nearest drops, metres: the windscreen and the ego's own roof are within.
const NEAR = 1.6;
// Half the width of a streak in metres, and the least as seen, radians: half a pixel of a small picture.
const HALF = 0.0011;
const HALF_RAD = 0.0007;

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) drop: u32) -> Streak {
    let n = 3 * i32(drop);
    let start = vec3f(hash(n), hash(n + 1), hash(n + 2));
    let velocity = vec3f(DRIFT * frame.forward.w, 0.0, -FALL);
    let from_eye = (fract(start + (velocity * frame.to_sun_time.w - frame.eye.xyz) / BOX) - 0.5) * BOX;
    let way = (velocity - frame.motion.xyz) * SEEN_S;
    let at = square_corner(corner);
    let distance = length(from_eye);
    let half = max(HALF, HALF_RAD * distance);
    let across = normalize(cross(way, from_eye)) * half;
    let world = frame.eye.xyz + from_eye + 0.5 * way * at.y + across * at.x;
    // Both ends are ahead of the near limit.
    let ahead = dot(from_eye, frame.forward.xyz) - 0.5 * abs(dot(way, frame.forward.xyz));
    let edge = max(max(abs(from_eye.x) / BOX.x, abs(from_eye.y) / BOX.y), abs(from_eye.z) / BOX.z);
    let shown = smoothstep(NEAR, NEAR + 1.0, ahead) * (1.0 - smoothstep(0.38, 0.5, edge));
    let light = 0.62 * ambient(vec3f(0.0, 0.0, 1.0)) + 0.12 * lamplight(world, vec3f(0.0, 0.0, 1.0), 1.0);
    let clip = frame.clip_from_world * vec4f(world, 1.0);
    // A streak that is drawn wider than it is hides less.
    let opacity = 0.42 * shown * sqrt(HALF / half);
    return Streak(select(vec4f(2.0, 2.0, 2.0, 1.0), clip, shown > 0.01), at, vec4f(light, opacity));
}

@fragment
fn fragment(in: Streak) -> @location(0) vec4f {
    let soft = (1.0 - in.at.x * in.at.x) * (1.0 - in.at.y * in.at.y);
    return vec4f(in.light.rgb, in.light.w * soft);
}
