#version 430
// The next direction: one cycle's correction, made conjugate to the last direction.
layout(local_size_x = 256) in;
#include "multigrid/levels.glsl"
#include "multigrid/vectors.glsl"
#include "multigrid/reduce.glsl"
layout(std430, binding = 4) buffer Directions { vec2 p[]; };

void main() {
    int node = int(gl_GlobalInvocationID.x);
    if (node < level.x * level.y) p[node] = x[node] + beta * p[node];
}
