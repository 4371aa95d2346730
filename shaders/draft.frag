#version 330
// A draft's second pass: the picture, what is behind it, and its marks.

#include "filter.glsl"
#include "canvas.glsl"
#include "marks.glsl"

uniform sampler2D place, shape;   // of draft_place.frag
uniform float marks_from;         // first column that has marks

out vec4 colour;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 here = texelFetch(place, at, 0);
    vec4 how = texelFetch(shape, at, 0);
    float share = max(how.w - 1.0, 0.0);
    vec2 whole = floor(here.xy);
    vec4 picture = share > 0.0 ? share * filtered(whole, here.xy - whole, vec3(1.0, 0.0, 1.0), int(how.z)) : vec4(0.0);
    vec4 cell = how.w > 0.0 ? vec4(here.zw, how.xy) : vec4(0.0);
    vec4 mark = gl_FragCoord.x > marks_from ? marks(cell) : marks_before(cell);
    colour = composed(gl_FragCoord.xy, picture, mark);
}
