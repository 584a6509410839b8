// Tone mapping from light to sRGB values, into a rectangle of the target; a mirror gets a dark frame and round corners.

// True for a mirror, which is flipped, may be curved and may have a frame.
override MIRROR: bool = false;
// True if edges are smoothed here. Otherwise they need no smoothing, or `soften.wgsl` does it.
override SMOOTH: bool = false;
// True if the target has the same size as the light, pixel for pixel, and a mirror is flat: reading one texel is cheaper than mixing four.
override EXACT: bool = false;

// Conversion from light to the screen's sRGB values. Strong light first spills slightly into the other colours, so that a lamp turns pale
// rather than flat red. Then follows an S-shaped curve over the logarithm of light, with a shoulder that rises more slowly above the light
// of pale things in the sun. A white sheet there is at 0.86, and a sky beside a low sun, ten times as bright, at 0.95; clouds between them
// keep their shape. Most of the spill is then taken back, so that paint in ordinary light keeps its colour (in the manner of AgX, Sobotka
// 2022, with a different curve). On the shoulder, where the curve alone would make every colour white, much of the hue is kept: an evening
// sky is golden.
const SPILL = 0.020;
const TAKEN_BACK = 0.016;
const STEEP = 1.08;
// Light that maps to half of the scale.
const MIDDLE = 0.26;
// Light at which the shoulder begins, and its steepness.
const SHOULDER = 0.8;
const SHOULDER_STEEP = 0.72;
// Share of the hue that is kept where light is four times as strong.
const HUE_KEPT = 0.6;

fn curve(light: vec3f) -> vec3f {
    let stops = log(max(light, vec3f(1e-6)) / MIDDLE);
    let bend = log(SHOULDER / MIDDLE);
    let x = exp(STEEP * min(stops, vec3f(bend)) + SHOULDER_STEEP * max(stops - bend, vec3f(0.0)));
    return x / (x + 1.0);
}

fn tone(colour: vec3f) -> vec3f {
    let mixed = max(colour, vec3f(0.0)) * (1.0 - 3.0 * SPILL) + SPILL * dot(colour, vec3f(1.0));
    let curved = curve(mixed);
    let seen = (curved - TAKEN_BACK * dot(curved, vec3f(1.0))) / (1.0 - 3.0 * TAKEN_BACK);
    let most = max(mixed.r, max(mixed.g, mixed.b));
    let hued = max(curved.r, max(curved.g, curved.b)) * sqrt(mixed / max(most, 1e-6));
    let kept = HUE_KEPT * clamp((most - SHOULDER) / (3.0 - SHOULDER), 0.0, 1.0);
    return clamp(mix(seen, hued, kept), vec3f(0.0), vec3f(1.0));
}

// Returns half a step of noise against bands in the sky, the same in every picture.
fn dither(pixel: vec2f) -> f32 {
    let n = fract(52.9829189 * fract(dot(pixel, vec2f(0.06711056, 0.00583715))));
    return (n - 0.5) / 255.0;
}

fn at(uv: vec2f) -> vec3f {
    return textureSampleLevel(light, light_sampler, uv, 0.0).rgb * quad.exposure;
}

fn load(texel: vec2i) -> vec3f {
    return textureLoad(light, texel, 0).rgb * quad.exposure;
}

// Returns the approximate brightness to the eye, accurate enough to find edges.
fn seen(colour: vec3f) -> f32 {
    let l = dot(colour, vec3f(0.2126, 0.7152, 0.0722));
    return sqrt(l / (l + 0.35));
}

// Returns the place in the picture behind a curved glass that is visible at `uv`. The angle off the centre grows by twice the tilt of the
// glass there (law of reflection; `MirrorGlass` in post/tonemap.rs).
fn behind_glass(uv: vec2f, bend: f32) -> vec2f {
    if bend <= 0.0 {
        return uv;
    }
    let seen_at = (uv - 0.5) * 2.0 * quad.lens.xy;
    let r = max(length(seen_at), 1e-5);
    let spread = tan(min(atan(r) + 2.0 * asin(min(bend * r, 1.0)), 1.5)) / r;
    return 0.5 + (uv - 0.5) * (spread * quad.lens.w);
}

// Adds a slight dimming of the glass towards its edge, and a black rim that catches light from above.
fn framed(picture: vec3f, at: vec2f, size: vec2f) -> vec4f {
    let off = at - 0.5 * size;
    let from_middle = abs(off) - 0.5 * size + quad.corner;
    // Distance to the rounded rectangle, negative inside.
    let outside = length(max(from_middle, vec2f(0.0))) + min(max(from_middle.x, from_middle.y), 0.0) - quad.corner;
    let width = quad.border;
    let dimmed = picture * (1.0 - 0.42 * exp(min(outside, 0.0) / (0.55 * width)));
    let up = select(0.0, -sign(off.y), from_middle.y > from_middle.x - quad.corner * 0.5);
    let ridge = exp(-pow((outside - 0.45 * width) / (0.22 * width), 2.0));
    let rim = vec3f(0.030, 0.032, 0.036) + vec3f(0.10, 0.105, 0.11) * ridge * (0.45 + 0.45 * up);
    let share = smoothstep(-0.6, 0.6, outside);
    return vec4f(mix(dimmed, rim, share), clamp(0.5 + width - outside, 0.0, 1.0));
}

@fragment
fn fragment(in: Point) -> @location(0) vec4f {
    let size = quad.size;
    var uv = in.at / size;
    var pixel = in.at;
    if MIRROR {
        if !EXACT {
            uv = behind_glass(uv, in.mirror.x);
        }
        uv.x = mix(uv.x, 1.0 - uv.x, quad.flip);
        pixel.x = mix(pixel.x, size.x - pixel.x, quad.flip);
    }
    var colour: vec3f;
    if EXACT {
        colour = load(vec2i(pixel));
    } else {
        colour = at(uv);
    }
    if SMOOTH {
        colour = smoothed(uv, colour);
    }
    let spread = textureSampleLevel(halo, light_sampler, uv, 0.0).rgb;
    colour += quad.bloom * spread * spread;
    // No noise before edge detection, which would find edges in it.
    let picture = tone(colour) + select(dither(in.clip.xy), 0.0, quad.soften > 0.5);
    if MIRROR {
        if in.mirror.y > 0.0 {
            return framed(picture, in.at, size);
        }
    }
    return vec4f(picture, 1.0);
}
