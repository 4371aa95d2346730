#version 330
// Copies the composed canvas to the window, whose rows run upwards; a draft is enlarged.

uniform sampler2D canvas;
uniform ivec4 viewport;   // left, bottom, width, height
uniform float shrink;     // window pixels per pixel of the canvas

out vec4 colour;

void main() {
    vec2 at = gl_FragCoord.xy - vec2(viewport.xy);
    vec2 place = vec2(at.x, float(viewport.w) - at.y) / shrink;
    colour = texture(canvas, place / vec2(textureSize(canvas, 0)));
}
