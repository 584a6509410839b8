// Drops on the ego's windscreen, which gather until a wiper takes them away (`scene/cockpit/wipers.rs`). uv: metres to the left and up
// along the glass.

// Axles of the two wipers along the glass's foot, lengths of their arms, share of an arm without a blade, whole angle of a sweep.
override AXLE_0: f32 = 0.0;
override AXLE_1: f32 = 0.0;
override ARM_0: f32 = 1.0;
override ARM_1: f32 = 1.0;
override BARE: f32 = 0.0;
override SWEEP: f32 = 1.0;

// Light of a lit street, lx: where the sky gives less, drops are seen by lamps.
const STREET_LUX = 30.0;
// Share of its cover that a drop has by night, and light of its glint beside that of a white sheet.
const BENT = 0.06;
const SPARKLE = 0.5;

// Time after which a drop beside the wipers' reach has run off, s.
const RUN_OFF_S = 9.0;

// Returns the time since a wiper has passed a place, s, and the number of sweeps up and down until then; a negative time out of its reach.
fn wiped(at: vec2f, axle: f32, arm: f32) -> vec2f {
    let off = vec2f(axle - at.x, at.y);
    let reach = length(off);
    let share = atan2(off.y, off.x) / SWEEP;
    let period = frame.wipers.x;
    let sweep = frame.wipers.y;
    let cycle = floor(frame.to_sun_time.w / period);
    let now = frame.to_sun_time.w - cycle * period;
    // The angle is (1 - cos) / 2 of the sweep.
    let up = sweep / (2.0 * PI) * acos(clamp(1.0 - 2.0 * share, -1.0, 1.0));
    let down = sweep - up;
    var passed = vec2f(now + period - down, 2.0 * cycle);
    passed = select(passed, vec2f(now - up, 2.0 * cycle + 1.0), now >= up);
    passed = select(passed, vec2f(now - down, 2.0 * cycle + 2.0), now >= down);
    let within = reach > BARE * arm && reach < arm && share > 0.0 && share < 1.0;
    return select(vec2f(-1.0, 0.0), passed, within);
}

// Returns the place in a drop, -1..1, and how much it covers in z. Each cell of the glass holds at most one drop.
fn drop_at(at: vec2f, cell_m: f32, passed: vec2f, flow: f32) -> vec3f {
    let cell = floor(at / cell_m);
    let n = i32(cell.x) * 1619 + i32(cell.y) * 31337 + i32(cell_m * 7919.0);
    // Beside the reach of the wipers drops gather and run off, each in its own time.
    let turn = frame.to_sun_time.w / RUN_OFF_S + hash(n + 11);
    let free = passed.x < 0.0;
    let since = select(passed.x, fract(turn) * RUN_OFF_S, free);
    let m = n + 6971 * i32(select(passed.y, floor(turn), free));
    let middle = (cell + 0.27 + 0.46 * vec2f(hash(m), hash(m + 1))) * cell_m;
    let radius = cell_m * (0.11 + 0.15 * hash(m + 2) * hash(m + 4));
    // Drops per second that hit a cell.
    let rate = flow * cell_m * cell_m;
    let there = smoothstep(0.0, 0.06, since - hash(m + 3) / rate);
    let p = (at - middle) / radius;
    // Drops smaller than a pixel are not seen.
    let seen = smoothstep(0.4, 1.4, radius / max(length(fwidth(at)), 1e-5));
    return vec3f(p, seen * there * (1.0 - smoothstep(0.55, 1.0, length(p))));
}

@fragment
fn fragment(in: Surface) -> @location(0) vec4f {
    let one = wiped(in.uv, AXLE_0, ARM_0);
    let other = wiped(in.uv, AXLE_1, ARM_1);
    let passed = select(one, other, one.x < 0.0 || (other.x >= 0.0 && other.x < one.x));
    // Drops per square metre and second: 1 mm/h of drops of 2 mm is 66. The faster the ego, the more hit the glass.
    let towards = frame.motion.xyz + vec3f(0.0, 0.0, FALL);
    let flow = 66.0 * frame.motion.w * max(dot(normalize(in.normal), towards), 0.0) / FALL;
    let large = drop_at(in.uv, 0.019, passed, flow);
    let small = drop_at(in.uv + 0.37, 0.0105, passed, 0.6 * flow);
    let drop = select(small, large, large.z >= small.z);
    // A drop shows the world upside down: ground above, sky below.
    let view = to_eye(in.world);
    let above = sky_light_blurred(normalize(vec3f(-view.xy, 0.5)), 3.0);
    let ground = 0.11 * ambient(vec3f(0.0, 0.0, 1.0));
    let light = mix(above, ground, smoothstep(-0.55, 0.75, drop.y));
    // By day a drop hides what is behind it. By night that is brighter than sky and ground, and a drop only bends its light: it is hardly visible,
    // but sparkles with the lamps that light it.
    let sky_lux = ambient(vec3f(0.0, 0.0, 1.0)).g / max(frame.lamps.z, 1e-9);
    let hides = 0.62 * drop.z * mix(BENT, 1.0, sky_lux / (sky_lux + STREET_LUX));
    let glint = 1.0 - smoothstep(0.05, 0.45, distance(drop.xy, vec2f(-0.25, 0.3)));
    let sparkle = SPARKLE * glint * drop.z * lamplight(in.world, normalize(in.normal), 0.0);
    return vec4f(light + sparkle / max(hides, 1e-4), hides);
}
