#version 430
// The coarsest level's correction, by the inverse of its operator.
layout(local_size_x = 64) in;
#include "multigrid/levels.glsl"
#include "multigrid/vectors.glsl"
layout(std430, binding = 7) buffer Bottom { float inverse_of_bottom[]; };

void main() {
    int node = int(gl_GlobalInvocationID.x), size = level.x * level.y;
    if (node >= size) return;
    vec2 total = vec2(0.0);
    for (int k = 0; k < size; k++) total += inverse_of_bottom[k * size + node] * b[level.z + k];
    x[level.z + node] = total;
}
