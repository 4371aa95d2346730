#version 330
// Grid coordinates of the pixels at the outline, those just outside it too, for the marks.

#include "mesh.glsl"

out vec4 cell;

void main() {
    vec2 at = cell_position(from_corner()), rate = cells_per_pixel();
    if (share_inside(at, rate) >= INSIDE) discard;
    cell = vec4(at, rate);
}
