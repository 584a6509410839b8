// Sky and trees as a smooth, level sheet of water mirrors them. A wet road is drawn over this picture.

@fragment
fn fragment(ray: Ray) -> @location(0) vec4f {
    let direction = normalize(ray.direction);
    let up = vec3f(direction.xy, abs(direction.z));
    return vec4f(mirrored(up, vec3f(0.0), 0.12), 1.0);
}
