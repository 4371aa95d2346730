#version 330
// The canvas as it is shown: desk and checks, the picture over them in linear light, the marks over that. Row 0 is the
// top.

#include "transfer.glsl"
#include "marks.glsl"

uniform sampler2D light;     // linear, premultiplied
uniform sampler2D cells;     // grid coordinates and their change per pixel
uniform vec4 frame;          // left, top, right, bottom edge of the result in framebuffer pixels
uniform float marks_from;    // first column that has marks
uniform float check_px;
uniform vec3 desk, check_dark, check_light;   // linear

out vec4 colour;

vec3 backdrop(vec2 at) {
    vec2 inside = clamp(min(at - frame.xy, frame.zw - at) + 0.5, 0.0, 1.0);
    vec2 square = floor((at - frame.xy) / check_px);
    vec3 check = mod(square.x + square.y, 2.0) < 0.5 ? check_dark : check_light;
    return mix(desk, check, inside.x * inside.y);
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 picture = texelFetch(light, at, 0);
    float alpha = clamp(picture.a, 0.0, 1.0);
    vec3 shown = encoded(clamp(picture.rgb + (1.0 - alpha) * backdrop(gl_FragCoord.xy), 0.0, 1.0));
    vec4 mark = gl_FragCoord.x > marks_from ? marks(texelFetch(cells, at, 0)) : vec4(0.0);
    colour = vec4(mark.rgb + (1.0 - mark.a) * shown, 1.0);
}
