#version 430
// The coarser level's right-hand side: P* of what the finer one leaves.
layout(local_size_x = 32, local_size_y = 8) in;
#include "multigrid/levels.glsl"
#include "multigrid/vectors.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (!is_inside(at, coarser)) return;
    int node = number(at, coarser);
    vec2 total = vec2(0.0);
    if (coefficient(SCALE, node, coarser) > 0.0) {
        for (int v = -1; v <= 1; v++) {
            for (int u = -1; u <= 1; u++) {
                ivec2 from = 2 * at + ivec2(u, v);
                if (!is_inside(from, level)) continue;
                total += (u == 0 ? 1.0 : 0.5) * (v == 0 ? 1.0 : 0.5) * between[level.z + number(from, level)];
            }
        }
    }
    b[coarser.z + node] = total;
}
