#version 430
// A step along p: the solution, and what is left.
layout(local_size_x = 256) in;
#include "multigrid/levels.glsl"
#include "multigrid/vectors.glsl"
#include "multigrid/reduce.glsl"
layout(std430, binding = 4) buffer Directions { vec2 p[]; };
layout(std430, binding = 5) buffer Solution { vec2 v[]; };

void main() {
    int node = int(gl_GlobalInvocationID.x);
    if (node >= level.x * level.y) return;
    v[node] += alpha * p[node];
    b[node] -= alpha * between[node];
}
