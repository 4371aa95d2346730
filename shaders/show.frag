#version 330
// Copies the composed canvas to the window; a draft is enlarged.

uniform sampler2D canvas;

in vec2 place;

out vec4 colour;

void main() {
    colour = texture(canvas, place);
}
