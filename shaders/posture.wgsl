// Postures of people between the models of the gait (`scene/vehicles/mod.rs`).

// The same corner in the next phase of the gait and in the standing posture.
struct Postures {
    @location(9) next_position: vec3f,
    @location(10) next_normal: vec3f,
    @location(11) standing_position: vec3f,
    @location(12) standing_normal: vec3f,
}

// Returns the share of the next phase and that of the standing posture. An instance has them in place of the number on its plates.
fn posture_shares(plate_brake: f32) -> vec2f {
    let code = floor(abs(plate_brake));
    let standing = floor(code / 256.0);
    return vec2f(code - 256.0 * standing, standing) / 255.0;
}

fn blended(first: vec3f, next: vec3f, standing: vec3f, shares: vec2f) -> vec3f {
    return mix(mix(first, next, shares.x), standing, shares.y);
}
