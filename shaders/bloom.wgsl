// Halo of lamps and glints, as in lenses and eyes: the light brighter than any lit paper, scaled down, then blurred.

@group(0) @binding(0) var light: texture_2d<f32>;
@group(0) @binding(1) var light_sampler: sampler;

// Lower limit of the light with a halo, above the radiance of a white cloud or a white car in the sun.
const THRESHOLD = 1.6;
// Upper limit of brightness, for which a 1 in the halo's texture stands.
override MOST: f32 = 1.0;

// True in the second step, the blur.
override BLUR: bool = false;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn bright(uv: vec2f) -> vec3f {
    let colour = textureSampleLevel(light, light_sampler, uv, 0.0).rgb;
    let most = max(colour.r, max(colour.g, colour.b));
    return colour * (clamp(most - THRESHOLD, 0.0, MOST) / max(most, 0.001));
}

@fragment
fn fragment(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let texel = 1.0 / vec2f(textureDimensions(light));
    var sum = vec3f(0.0);
    if BLUR {
        // 16 pairs of texels on a spiral, weighted by a Gaussian of 1.6 texels: on a square grid, halos would be square and striped.
        var weights = 0.0;
        for (var i = 0; i < 16; i++) {
            let turn = 2.4 * f32(i);
            let off = vec2f(cos(turn), sin(turn)) * (0.8 * sqrt(f32(i) + 0.5));
            let weight = exp(-dot(off, off) / 5.0);
            sum += weight * textureSampleLevel(light, light_sampler, at.xy * texel + off * texel, 0.0).rgb;
            weights += weight;
        }
        // Bytes hold the square root, which resolves a faint halo better; readers square it.
        sum = sqrt(sum / (weights * MOST));
    } else {
        // One texel of the halo for 8 by 8 of the picture: every texel counts once.
        for (var i = 0; i < 16; i++) {
            let off = vec2f(f32(i & 3) - 1.5, f32(i >> 2u) - 1.5) * 2.0;
            sum += bright((at.xy * 8.0 + off) * texel) / 16.0;
        }
    }
    return vec4f(sum, 1.0);
}
