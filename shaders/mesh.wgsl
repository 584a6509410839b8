// Meshes in the one shape that they have.

@vertex
fn vertex(corner: Corner, at: Placed) -> Surface {
    return surface(corner, at);
}
