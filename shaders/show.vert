#version 330
// One triangle that covers the viewport, with the places of the canvas that it shows: rows of the window run upwards.

uniform vec2 part;   // share of the canvas texture, from its first pixel, that the viewport shows

out vec2 place;

void main() {
    vec2 corner = vec2((gl_VertexID & 1) * 4 - 1, (gl_VertexID & 2) * 2 - 1);
    place = part * (0.5 + 0.5 * vec2(corner.x, -corner.y));
    gl_Position = vec4(corner, 0.0, 1.0);
}
