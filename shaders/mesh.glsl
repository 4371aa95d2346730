// Where a fragment of the deformed grid comes from. Included by the fragment shaders that follow mesh.vert.

uniform vec2 target_origin;

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

// Signed distance in output pixels from the line where grid coordinate `axis` has the value at distance `cells`.
vec2 pixels_from_cells(vec2 cells) {
    vec2 gradient = vec2(length(vec2(to_cell[0][0], to_cell[1][0])), length(vec2(to_cell[0][1], to_cell[1][1])));
    return cells / max(gradient, vec2(1e-12));
}

// Share of the fragment's pixel that lies inside the outline.
float coverage(vec2 cell, vec2 last_cell) {
    vec2 low = clamp(pixels_from_cells(cell) + 0.5, 0.0, 1.0);
    vec2 high = clamp(pixels_from_cells(last_cell - cell) + 0.5, 0.0, 1.0);
    vec2 inside = max(low + high - 1.0, 0.0);
    return inside.x * inside.y;
}
