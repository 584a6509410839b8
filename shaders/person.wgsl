// People and bicycles, between two phases of the gait.

@vertex
fn vertex(corner: Corner, at: Placed, postures: Postures) -> Surface {
    let shares = posture_shares(at.colour_brake.w);
    var posed = corner;
    posed.position = blended(corner.position, postures.next_position, postures.standing_position, shares);
    posed.normal = blended(corner.normal, postures.next_normal, postures.standing_normal, shares);
    return surface(posed, at);
}
