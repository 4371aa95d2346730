#version 430
// Bring the groups' sums together: to the step where STEP_FOUND, else to the share of the last direction in the next.
layout(local_size_x = 256) in;
#include "multigrid/reduce.glsl"
uniform int parts;

void main() {
    vec2 mine = vec2(0.0);
    for (int k = int(gl_LocalInvocationIndex); k < parts; k += 256) {
        mine = vec2(mine.x + of_groups[k].x, max(mine.y, of_groups[k].y));
    }
    gather(mine);
    if (gl_LocalInvocationIndex != 0u) return;
#ifdef STEP_FOUND
    alpha = gathered[0].x > 0.0 ? energy / gathered[0].x : 0.0;
#else
    beta = energy > 0.0 ? gathered[0].x / energy : 0.0;
    energy = gathered[0].x;
    most = gathered[0].y;
#endif
}
