#version 430
// A p, and p* A p.
layout(local_size_x = 32, local_size_y = 8) in;
#include "multigrid/levels.glsl"
#include "multigrid/vectors.glsl"
#include "multigrid/reduce.glsl"
layout(std430, binding = 4) buffer Directions { vec2 p[]; };
#define VALUE(k) p[k]
#include "multigrid/stencil.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    float product = 0.0;
    if (is_inside(at, level)) {
        int node = number(at, level);
        vec2 Ap = applied(at, node);
        between[node] = Ap;
        product = dot(p[node], Ap);
    }
    put(vec2(product, 0.0));
}
