#version 330
// One triangle that covers the viewport, with the places of the canvas that it shows: rows of the window run upwards.

uniform vec4 shown;   // left, top, right, bottom of what the viewport shows, as shares of the canvas texture

out vec2 place;

void main() {
    vec2 corner = vec2((gl_VertexID & 1) * 4 - 1, (gl_VertexID & 2) * 2 - 1);
    place = mix(shown.xy, shown.zw, 0.5 + 0.5 * vec2(corner.x, -corner.y));
    gl_Position = vec4(corner, 0.0, 1.0);
}
