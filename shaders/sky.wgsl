// Background: air and clouds of the hour from one picture (`render/sky/clouds.rs`), and the sun's disc.

@group(1) @binding(0) var clouds: texture_2d<f32>;

// Radius of the horizon in the clouds' picture, see `RIM` in `clouds.rs`.
const CLOUDS_RIM = 0.98;

@fragment
fn fragment(ray: Ray) -> @location(0) vec4f {
    let direction = normalize(ray.direction);
    // The zenith is at the centre; directions below the horizon get the horizon.
    let at = direction.xy / max(1.0 + direction.z, max(length(direction.xy), 0.001));
    // Detail finer than the picture's texels at the edges of clouds.
    let torn = textureSampleLevel(grain, grain_sampler, at * 9.0, 0.0).g - 0.5;
    let texel = 1.0 / f32(textureDimensions(clouds).x);
    let cloud = textureSampleLevel(clouds, sky_sampler, 0.5 + 0.5 * CLOUDS_RIM * at + texel * 2.2 * vec2f(torn, -torn), 0.0);

    // The disc, 0.53 degrees wide, and the glare around it.
    let toward_sun = max(dot(direction, frame.to_sun_time.xyz), 0.0);
    let disc = smoothstep(0.999975, 0.999992, toward_sun) * 30.0 + 1.2 * pow(toward_sun, 2600.0) + 0.10 * pow(toward_sun, 180.0);
    let clear = 1.0 - clamp(cloud.a, 0.0, 1.0);
    // The moon's light is weak on surfaces, but its disc is bright.
    let body = max(disc * SUN, min(disc * 1500.0 * SUN, vec3f(1.0)));
    let light = cloud.rgb + clear * clear * body;
    return vec4f(light, 1.0);
}
