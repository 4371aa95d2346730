#version 430
// One step of the smoother: the first of the last two, from x to `between`, or, where LAST, the second, back to x.
layout(local_size_x = 32, local_size_y = 8) in;
#include "multigrid/levels.glsl"
#include "multigrid/vectors.glsl"
#ifdef LAST
#define FROM between
#define TO x
#define STEP STEPS[0]
#else
#define FROM x
#define TO between
#define STEP STEPS[1]
#endif
#define VALUE(k) FROM[level.z + (k)]
#include "multigrid/stencil.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (!is_inside(at, level)) return;
    int node = number(at, level);
    TO[level.z + node] = VALUE(node)
        + STEP * coefficient(SCALE, node, level) * (b[level.z + node] - applied(at, node));
}
