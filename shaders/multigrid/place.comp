#version 430
// Where nodes end: from where they begin, by the solution and by a field d that is refined from a coarser grid.
layout(local_size_x = 32, local_size_y = 8) in;
#include "multigrid/levels.glsl"
layout(std430, binding = 1) writeonly buffer Places { dvec2 z[]; };
layout(std430, binding = 2) readonly buffer Base { dvec2 base[]; };
layout(std430, binding = 3) readonly buffer Solution { vec2 v[]; };
layout(std430, binding = 4) readonly buffer Coarse { dvec2 d[]; };
// Coarse rows, then coarse columns, that fine ones are read from, and their weights.
layout(std430, binding = 5) readonly buffer Taps { ivec4 taps[]; };
layout(std430, binding = 6) readonly buffer Weights { dvec4 weights[]; };
uniform int columns;   // of the coarser grid, 0 for no field

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (!is_inside(at, level)) return;
    int node = number(at, level), across = level.x + at.x;
    dvec2 place = base[node] + dvec2(v[node]);
    for (int i = 0; i < 4 && columns > 0; i++) {
        dvec2 row = dvec2(0.0);
        for (int j = 0; j < 4; j++) row += weights[across][j] * d[taps[at.y][i] * columns + taps[across][j]];
        place += weights[at.y][i] * row;
    }
    z[node] = place;
}
