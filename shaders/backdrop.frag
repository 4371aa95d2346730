#version 330
// Desk and checks, as the canvas has them where there is no picture.

#include "canvas.glsl"

out vec4 colour;

void main() {
    colour = composed(gl_FragCoord.xy, vec4(0.0), vec4(0.0));
}
