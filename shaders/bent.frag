#version 330
// The canvas of an earlier frame, bent along as its places have moved since.

#include "mesh.glsl"

uniform sampler2D canvas;
uniform vec2 pixel;   // share of the canvas

out vec4 colour;

void main() {
    vec2 offset = from_corner();
    vec2 cell = cell_position(offset);
    if (cell != clamp(cell, vec2(0.0), last_cell)) discard;   // beyond the picture's edge
    colour = texture(canvas, (rest_corner.zw + rest_corner.xy + 0.5 + to_source * offset) * pixel);
}
