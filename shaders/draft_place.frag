#version 330
// A draft's first pass: where every pixel comes from. What is costly is left to the second, since a pass over small
// triangles shades most pixels several times.

#include "mesh.glsl"

layout(location = 0) out vec4 place;   // xy = source pixel, zw = grid coordinates
layout(location = 1) out vec4 shape;   // xy = grid coordinates per pixel, z = level, w = 1 + share inside the outline

void main() {
    vec2 offset = from_corner();
    vec2 cell = cell_position(offset), rate = cells_per_pixel();
    place = vec4(rest_corner.zw + rest_corner.xy + to_source * offset, cell);
    shape = vec4(rate, float(level), 1.0 + share_inside(cell, rate));
}
