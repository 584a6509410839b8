//! Arithmetic with colours. In: linear albedo. Out: linear albedo.

/// Mixes two colours linearly: `a` at `t` = 0, `b` at `t` = 1.
pub(in crate::scene) fn mix(a: [f32; 3], b: [f32; 3], t: f32) -> [f32; 3] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

/// Multiplies a colour by a brightness factor.
pub(in crate::scene) fn shade(colour: [f32; 3], factor: f32) -> [f32; 3] {
    colour.map(|c| c * factor)
}
