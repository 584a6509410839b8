// Light on trees, for near and far trees alike.

// Returns the light that leaves (1) or bark (0) send to the eye; `crown` is the normal of the crown, `normal` that of the leaf.
fn foliage(albedo: vec3f, world: vec3f, crown: vec3f, normal: vec3f, view: vec3f, leafy: f32) -> vec3f {
    let to_sun = frame.to_sun_time.xyz;
    // Leaves are not a solid surface: their shade begins some way behind them.
    let sun = sunshine_in_trees(world + 1.3 * leafy * to_sun, crown);
    // The visible side of a leaf faces the eye, in any part of the crown: from above the upper sides are visible.
    let seen = normalize(normal + 0.8 * leafy * view);
    // Light wraps around a crown, which is not solid, and shines through leaves against the sun. Gaps between the leaves thin the shade of
    // the crown on itself.
    let direct = clamp((dot(seen, to_sun) + 0.3 * leafy) / (1.0 + 0.3 * leafy), 0.0, 1.0);
    let against = clamp(dot(-view, to_sun), 0.0, 1.0);
    let through = leafy * (0.18 + 0.38 * against * against);
    // Seen from the sun's side, leaves hide the shade that they cast (the hot spot of a canopy; Hapke 1963).
    let sunward = clamp(dot(view, to_sun), 0.0, 1.0);
    let arrives = mix(sun, 1.0, (0.30 + 0.45 * sunward * sunward) * leafy);
    // Light from behind a leaf shines through as well.
    let around = ambient(normal) + 0.35 * leafy * air.harmonics[0].rgb;
    let lamps = lamplight(world, normal, 0.5 * leafy);
    return albedo * (SUN * arrives * (direct + through * vec3f(1.0, 1.0, 0.4)) + around + lamps);
}
