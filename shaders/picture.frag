#version 330
// The warped picture in linear light, premultiplied, with an antialiased outline.

#include "mesh.glsl"
#include "filter.glsl"

uniform vec2 last_cell;

out vec4 colour;

void main() {
    vec2 offset = from_corner();
    float share = coverage(cell_position(offset), last_cell);
    if (share <= 0.0) discard;
    colour = share * filtered(rest_corner.zw, rest_corner.xy + to_source * offset, kernel, level);
}
