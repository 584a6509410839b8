// Light on trees, near and far alike.

// Light that leaves (1) or bark (0) send to the eye; `crown` is the normal of the crown, `normal` that of the leaf.
fn foliage(albedo: vec3f, world: vec3f, crown: vec3f, normal: vec3f, view: vec3f, leafy: f32) -> vec3f {
    let to_sun = frame.to_sun_time.xyz;
    // Leaves are no surface: their shade begins some way behind them.
    let sun = sunshine_in_trees(world + 1.3 * leafy * to_sun, crown);
    // Of a leaf one sees the side that faces the eye, whichever way its crown faces: from above the upper sides.
    let seen = normalize(normal + 0.8 * leafy * view);
    // Light wraps around a crown, which is no solid ball, and shines through leaves seen against the sun. What shade
    // the crown throws on itself is thinned by the gaps between the leaves.
    let direct = clamp((dot(seen, to_sun) + 0.3 * leafy) / (1.0 + 0.3 * leafy), 0.0, 1.0);
    let against = clamp(dot(-view, to_sun), 0.0, 1.0);
    let through = leafy * (0.18 + 0.38 * against * against);
    // Seen from the sun's side, leaves hide the shade that they throw (the hot spot of a canopy; Hapke 1963).
    let sunward = clamp(dot(view, to_sun), 0.0, 1.0);
    let arrives = mix(sun, 1.0, (0.30 + 0.45 * sunward * sunward) * leafy);
    // What falls on a leaf from behind it shines through as well.
    let around = ambient(normal) + 0.35 * leafy * air.harmonics[0].rgb;
    return albedo * (SUN * arrives * (direct + through * vec3f(1.0, 1.0, 0.4)) + around);
}
