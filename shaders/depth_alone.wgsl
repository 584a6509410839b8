// Fragment of a surface whose depth alone is drawn.

@fragment
fn fragment() -> @location(0) vec4f {
    return vec4f(0.0);
}
