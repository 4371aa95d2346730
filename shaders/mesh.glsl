// Where a fragment of the deformed grid comes from. Included by the fragment shaders that follow mesh.vert.

#include "outline.glsl"

uniform vec2 target_origin;
uniform vec4 straight;   // left, top, right and bottom of an outline that is a rectangle, in output pixels; else 0

flat in vec4 moved_corner;
flat in vec4 rest_corner;
flat in vec2 cell_corner;
flat in mat2 to_source;
flat in mat2 to_cell;
flat in vec3 kernel;
flat in int level;

// Output pixels from the triangle's first corner to the fragment's centre.
vec2 from_corner() {
    return (gl_FragCoord.xy - 0.5 + target_origin - moved_corner.zw) - moved_corner.xy;
}

// Grid coordinates (column, row) of the fragment.
vec2 cell_position(vec2 offset) {
    return cell_corner + to_cell * offset;
}

// Grid coordinates per output pixel, along the direction in which each grows fastest.
vec2 cells_per_pixel() {
    return vec2(length(vec2(to_cell[0][0], to_cell[1][0])), length(vec2(to_cell[0][1], to_cell[1][1])));
}

// Share of the fragment's pixel inside the outline. Of a rectangle it is exact: what the cells say, which is exact in
// the triangles at the outline alone, would leave a pixel beside a slanted one less than full.
float share_inside(vec2 at, vec2 rate) {
    if (straight.x >= straight.z) return coverage(at, rate);
    vec2 pixel = gl_FragCoord.xy - 0.5 + target_origin;
    vec2 low = clamp(pixel - straight.xy + 0.5, 0.0, 1.0), high = clamp(straight.zw - pixel + 0.5, 0.0, 1.0);
    vec2 inside = max(low + high - 1.0, 0.0);
    return inside.x * inside.y;
}
