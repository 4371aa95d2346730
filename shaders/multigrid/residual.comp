#version 430
// What a level's correction leaves.
layout(local_size_x = 32, local_size_y = 8) in;
#include "multigrid/levels.glsl"
#include "multigrid/vectors.glsl"
#define VALUE(k) x[level.z + (k)]
#include "multigrid/stencil.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (!is_inside(at, level)) return;
    int node = number(at, level);
    // Nodes without neighbours take no part in the coarser level.
    float others = 1.0 - coefficient(EXCESS, node, level) * coefficient(SCALE, node, level);
    between[level.z + node] = others > 1e-6 ? b[level.z + node] - applied(at, node) : vec2(0.0);
}
