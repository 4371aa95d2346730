#version 330
// First pass: where every pixel inside the outline comes from. The mesh can have triangles smaller than a pixel; what is
// costly, the filter, is left to one pass over the pixels.

#include "mesh.glsl"

layout(location = 0) out vec4 place;       // source pixel: xy = fraction, zw = whole
layout(location = 1) out vec4 footprint;   // xyz = kernel, w = 1 + level; 0 where there is no picture
layout(location = 2) out vec4 cell;        // xy = grid coordinates, zw = their change per pixel

void main() {
    vec2 offset = from_corner();
    vec2 at = cell_position(offset), rate = cells_per_pixel();
    if (share_inside(at, rate) < INSIDE) discard;
    vec2 fraction = rest_corner.xy + to_source * offset;
    vec2 whole = floor(fraction);
    place = vec4(fraction - whole, rest_corner.zw + whole);
    footprint = vec4(kernel, 1.0 + float(level));
    cell = vec4(at, rate);
}
