#version 430
// Which quads have a corner of non-positive area, by their first node, and how many those are.
layout(local_size_x = 32, local_size_y = 8) in;
#include "multigrid/levels.glsl"
layout(std430, binding = 1) readonly buffer Places { dvec2 z[]; };
layout(std430, binding = 2) buffer Folds { int count; int folded[]; };

bool turns_back(dvec2 across, dvec2 down) {
    return across.x * down.y - across.y * down.x <= 0.0;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (!is_inside(at + 1, level)) return;
    int node = number(at, level);
    dvec2 a = z[node], b = z[node + 1], c = z[node + level.y + 1], d = z[node + level.y];
    bool is_folded = turns_back(b - a, d - a) || turns_back(b - a, c - b) || turns_back(c - d, c - b)
        || turns_back(c - d, d - a);
    folded[node] = int(is_folded);
    if (is_folded) atomicAdd(count, 1);
}
