// A developed picture of one sample a pixel, its edges smoothed, onto a target of the same size. Apart from developing:
// software rendering reads bytes in a third of the time that light takes.

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
    let uv = in.at / print.size;
    return vec4f(smoothed(uv, load(vec2i(in.at))), 1.0);
}
