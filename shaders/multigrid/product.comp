#version 430
// r* M r and max |M r|: r what is left, M one cycle, which x holds.
layout(local_size_x = 32, local_size_y = 8) in;
#include "multigrid/levels.glsl"
#include "multigrid/vectors.glsl"
#include "multigrid/reduce.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    vec2 found = vec2(0.0);
    if (is_inside(at, level)) {
        int node = number(at, level);
        found = vec2(dot(b[node], x[node]), length(x[node]));
    }
    put(found);
}
