#version 430
// Two steps of the smoother, from 0.
layout(local_size_x = 32, local_size_y = 8) in;
#include "multigrid/levels.glsl"
#include "multigrid/vectors.glsl"
#define VALUE(k) (STEPS[0] * coefficient(SCALE, k, level) * b[level.z + (k)])
#include "multigrid/stencil.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (!is_inside(at, level)) return;
    int node = number(at, level);
    x[level.z + node] = VALUE(node)
        + STEPS[1] * coefficient(SCALE, node, level) * (b[level.z + node] - applied(at, node));
}
