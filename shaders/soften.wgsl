// Edge smoothing of a tone-mapped picture of one sample per pixel, onto a target of the same size. It is a pass of its own because software
// rendering reads bytes in a third of the time that it needs for light.

fn at(uv: vec2f) -> vec3f {
    return textureSampleLevel(light, light_sampler, uv, 0.0).rgb;
}

fn load(texel: vec2i) -> vec3f {
    return textureLoad(light, texel, 0).rgb;
}

fn seen(colour: vec3f) -> f32 {
    return sqrt(dot(colour, vec3f(0.2126, 0.7152, 0.0722)));
}

@fragment
fn fragment(in: Point) -> @location(0) vec4f {
    let uv = in.at / quad.size;
    return vec4f(smoothed(uv, load(vec2i(in.at))), 1.0);
}
