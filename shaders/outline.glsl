// The outline of the picture in grid coordinates: from 0 to the last node. May be included twice.
#ifndef OUTLINE
#define OUTLINE

uniform vec2 last_cell;   // grid coordinates of the last node

const float INSIDE = 0.999;   // share from which on a pixel counts as wholly inside

// Share of a pixel inside the outline, for grid coordinates `cell` that change by `rate` per pixel.
float coverage(vec2 cell, vec2 rate) {
    vec2 per_cell = 1.0 / max(rate, vec2(1e-12));
    vec2 low = clamp(cell * per_cell + 0.5, 0.0, 1.0);
    vec2 high = clamp((last_cell - cell) * per_cell + 0.5, 0.0, 1.0);
    vec2 inside = max(low + high - 1.0, 0.0);
    return inside.x * inside.y;
}
#endif
