#version 430
// Which quads have a corner of non-positive area, four of a row to a number, a byte each, and whether any has.
layout(local_size_x = 32, local_size_y = 8) in;
#include "multigrid/levels.glsl"
layout(std430, binding = 1) readonly buffer Places { dvec2 z[]; };
layout(std430, binding = 2) buffer Folds { uint any; uint folded[]; };

bool turns_back(dvec2 across, dvec2 down) {
    return across.x * down.y - across.y * down.x <= 0.0;
}

bool is_folded(ivec2 at) {
    if (!is_inside(at + 1, level)) return false;
    int node = number(at, level);
    dvec2 a = z[node], b = z[node + 1], c = z[node + level.y + 1], d = z[node + level.y];
    return turns_back(b - a, d - a) || turns_back(b - a, c - b) || turns_back(c - d, c - b) || turns_back(c - d, d - a);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    int across = (level.y + 3) / 4;
    if (at.x >= across || at.y >= level.x) return;
    uint four = 0u;
    for (int k = 0; k < 4; k++) four |= uint(is_folded(ivec2(4 * at.x + k, at.y))) << (8 * k);
    folded[at.y * across + at.x] = four;
    if (four != 0u) any = 1u;
}
