#version 430
// Add the coarser level's correction, by P.
layout(local_size_x = 32, local_size_y = 8) in;
#include "multigrid/levels.glsl"
#include "multigrid/vectors.glsl"

vec2 coarse(ivec2 at) {
    return is_inside(at, coarser) ? x[coarser.z + number(at, coarser)] : vec2(0.0);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (!is_inside(at, level)) return;
    int node = number(at, level);
    float others = 1.0 - coefficient(EXCESS, node, level) * coefficient(SCALE, node, level);
    if (coefficient(SCALE, node, level) == 0.0 || others <= 1e-6) return;
    ivec2 first = at / 2, second = first + (at & 1);
    x[level.z + node] += 0.25 * (coarse(first) + coarse(ivec2(second.x, first.y)) + coarse(ivec2(first.x, second.y))
        + coarse(second));
}
