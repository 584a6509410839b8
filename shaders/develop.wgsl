// From light to sRGB values, into a rectangle of the target; the mirror gets a dark frame and round corners.

struct Print {
    // left, top, width, height in pixels
    rect: vec4f,
    canvas: vec2f,
    flip: f32,
    border: f32,
    corner: f32,
    exposure: f32,
    soften: f32,
    glow: f32,
    // A mirror: tangents of half its angles, the eye's distance over the glass's radius, share of the picture that a flat
    // glass would show.
    lens: vec4f,
}

// Whether this is a mirror, which is flipped, may be curved and may have a frame.
override MIRROR: bool = false;

@group(0) @binding(0) var<uniform> print: Print;
@group(0) @binding(1) var light: texture_2d<f32>;
@group(0) @binding(2) var light_sampler: sampler;
@group(0) @binding(3) var halo: texture_2d<f32>;

struct Point {
    @builtin(position) clip: vec4f,
    // Pixels from the rectangle's upper left corner.
    @location(0) at: vec2f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Point {
    let corners = array(vec2f(0.0, 0.0), vec2f(1.0, 0.0), vec2f(1.0, 1.0), vec2f(0.0, 0.0), vec2f(1.0, 1.0), vec2f(0.0, 1.0));
    // The frame lies outside of the rectangle.
    let at = corners[index] * (print.rect.zw + 2.0 * print.border) - print.border;
    let pixel = print.rect.xy + at;
    return Point(vec4f(pixel / print.canvas * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0), 0.0, 1.0), at);
}

// From light to the screen's sRGB values. Strong light first spills a little into the other colours, so that a lamp turns
// pale rather than flat red; then a curve that is an S over the logarithm of light, with a long shoulder: a white sheet
// in the sun is at 0.89, twice that at 0.94, so that clouds keep their shape; and most of the spill is taken back, so that
// paint in ordinary light keeps its colour (in the manner of AgX, Sobotka 2022, with a curve of our own).
const SPILL = 0.020;
const TAKEN_BACK = 0.016;
const STEEP = 1.08;
// Light that gives half of the scale.
const MIDDLE = 0.26;

fn tone(colour: vec3f) -> vec3f {
    let mixed = max(colour, vec3f(0.0)) * (1.0 - 3.0 * SPILL) + SPILL * dot(colour, vec3f(1.0));
    let x = pow(mixed / MIDDLE, vec3f(STEEP));
    let curved = x / (x + 1.0);
    let seen = (curved - TAKEN_BACK * dot(curved, vec3f(1.0))) / (1.0 - 3.0 * TAKEN_BACK);
    return clamp(seen, vec3f(0.0), vec3f(1.0));
}

// Half a step of noise, against bands in the sky: the same in every picture.
fn dither(pixel: vec2f) -> f32 {
    let n = fract(52.9829189 * fract(dot(pixel, vec2f(0.06711056, 0.00583715))));
    return (n - 0.5) / 255.0;
}

fn at(uv: vec2f) -> vec3f {
    return textureSampleLevel(light, light_sampler, uv, 0.0).rgb * print.exposure;
}

// Brightness as the eye will see it, near enough to find edges by.
fn seen(colour: vec3f) -> f32 {
    let l = dot(colour, vec3f(0.2126, 0.7152, 0.0722));
    return sqrt(l / (l + 0.35));
}

// Where neighbours differ, a mean along the edge instead of the step across it (in the manner of Lottes' FXAA, 2009, with
// five samples to find the edge and four along it). Also fills in when the picture is filtered up.
fn smoothed(uv: vec2f, middle: vec3f) -> vec3f {
    let texel = 1.0 / vec2f(textureDimensions(light));
    let h = 0.5 * texel;
    let nw = seen(at(uv - h));
    let ne = seen(at(uv + vec2f(h.x, -h.y)));
    let sw = seen(at(uv + vec2f(-h.x, h.y)));
    let se = seen(at(uv + h));
    let m = seen(middle);
    let low = min(m, min(min(nw, ne), min(sw, se)));
    let high = max(m, max(max(nw, ne), max(sw, se)));
    if high - low < max(0.035, 0.09 * high) {
        return middle;
    }
    // Along the edge: across the gradient.
    var along = vec2f(sw + se - nw - ne, nw + sw - ne - se);
    let least = 1.0 / (min(abs(along.x), abs(along.y)) + max(0.03 * (nw + ne + sw + se), 0.008));
    along = clamp(along * least, vec2f(-6.0), vec2f(6.0)) * texel;
    let near = 0.5 * (at(uv - along / 6.0) + at(uv + along / 6.0));
    let far = 0.5 * near + 0.25 * (at(uv - 0.5 * along) + at(uv + 0.5 * along));
    let reached = seen(far);
    return select(far, near, reached < low || reached > high);
}

// Where the picture behind a curved glass shows what is seen at `uv`: the angle off the middle grows by twice the turn
// of the glass there (law of reflection; `Glass` in develop.rs).
fn behind_glass(uv: vec2f) -> vec2f {
    if print.lens.z <= 0.0 {
        return uv;
    }
    let seen_at = (uv - 0.5) * 2.0 * print.lens.xy;
    let r = max(length(seen_at), 1e-5);
    let spread = tan(min(atan(r) + 2.0 * asin(min(print.lens.z * r, 1.0)), 1.5)) / r;
    return 0.5 + (uv - 0.5) * (spread * print.lens.w);
}

// The glass is dimmed a little towards its edge; around it a black rim that catches light from above.
fn framed(picture: vec3f, at: vec2f, size: vec2f) -> vec4f {
    let off = at - 0.5 * size;
    let from_middle = abs(off) - 0.5 * size + print.corner;
    // Distance to the rounded rectangle, negative inside.
    let outside = length(max(from_middle, vec2f(0.0))) + min(max(from_middle.x, from_middle.y), 0.0) - print.corner;
    let width = print.border;
    let dimmed = picture * (1.0 - 0.42 * exp(min(outside, 0.0) / (0.55 * width)));
    let up = select(0.0, -sign(off.y), from_middle.y > from_middle.x - print.corner * 0.5);
    let ridge = exp(-pow((outside - 0.45 * width) / (0.22 * width), 2.0));
    let rim = vec3f(0.030, 0.032, 0.036) + vec3f(0.10, 0.105, 0.11) * ridge * (0.45 + 0.45 * up);
    let share = smoothstep(-0.6, 0.6, outside);
    return vec4f(mix(dimmed, rim, share), clamp(0.5 + width - outside, 0.0, 1.0));
}

@fragment
fn fragment(in: Point) -> @location(0) vec4f {
    let size = print.rect.zw;
    var uv = in.at / size;
    if MIRROR {
        uv = behind_glass(uv);
        uv.x = mix(uv.x, 1.0 - uv.x, print.flip);
    }
    var colour = at(uv);
    if print.soften > 0.5 {
        colour = smoothed(uv, colour);
    }
    colour += print.glow * textureSampleLevel(halo, light_sampler, uv, 0.0).rgb;
    let picture = tone(colour) + dither(in.clip.xy);
    if MIRROR {
        if print.border > 0.0 {
            return framed(picture, in.at, size);
        }
    }
    return vec4f(picture, 1.0);
}
