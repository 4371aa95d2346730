#version 330
// The canvas from the picture and the grid coordinates of its pixels.

#include "canvas.glsl"
#include "marks.glsl"

uniform sampler2D light;     // linear, premultiplied
uniform sampler2D cells;     // grid coordinates and their change per pixel
uniform float marks_from;    // first column that has marks

out vec4 colour;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 cell = texelFetch(cells, at, 0);
    vec4 mark = gl_FragCoord.x > marks_from ? marks(cell) : marks_before(cell);
    colour = composed(gl_FragCoord.xy, texelFetch(light, at, 0), mark);
}
