// The sky behind everything: gradient, sun, a few fair-weather clouds.

struct Ray {
    @builtin(position) clip: vec4f,
    @location(0) direction: vec3f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Ray {
    // One triangle that holds the picture.
    let corner = vec2f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    let direction = frame.forward.xyz + corner.x * frame.right.xyz + corner.y * frame.up.xyz;
    return Ray(vec4f(corner, 0.0, 1.0), direction);
}

@fragment
fn fragment(ray: Ray) -> @location(0) vec4f {
    let direction = normalize(ray.direction);
    let sun = frame.to_sun_time.xyz;
    var light = sky_light(direction);

    // A flat layer of cloud, bent down a little towards the horizon so that it does not end in a line.
    let height = max(direction.z, 0.0);
    let plane = direction.xy / (height + 0.11);
    let drift = vec2f(0.0004, 0.00015) * frame.to_sun_time.w;
    let broad = grain_at(plane * 0.042 + drift).g;
    let torn = grain_at(plane.yx * 0.21 + vec2f(0.31, 0.17) + drift * 2.0).g;
    let wisp = grain_at(plane * vec2f(0.93, 0.7)).g;
    let density = broad + 0.42 * (torn - 0.5) + 0.16 * (wisp - 0.5);
    let cover = smoothstep(0.60, 0.84, density) * smoothstep(0.015, 0.16, height);
    let toward_sun = max(dot(direction, sun), 0.0);
    let shade = mix(0.74, 0.98, smoothstep(1.0, 0.6, density)) + 0.35 * pow(toward_sun, 12.0);
    let white = 0.62 * SUN + 1.1 * air.harmonics[0].rgb;
    light = mix(light, white * shade, 0.82 * cover * smoothstep(0.0, 0.2, height));

    // The disc, 0.53 degrees wide; half a degree of glare around it.
    let disc = smoothstep(0.999975, 0.999992, toward_sun) * 30.0 + 2.5 * pow(toward_sun, 2600.0);
    return vec4f(light + disc * SUN, 1.0);
}
