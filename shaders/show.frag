#version 330
// Copies the composed canvas to the window, whose rows run upwards.

uniform sampler2D canvas;
uniform ivec2 corner;   // lower left pixel of the viewport

out vec4 colour;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy) - corner;
    colour = texelFetch(canvas, ivec2(at.x, textureSize(canvas, 0).y - 1 - at.y), 0);
}
