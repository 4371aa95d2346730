#version 430
// Begin a solve: what is left of the load with the solution v as it is, and |load|² - |left|² beside it.
layout(local_size_x = 32, local_size_y = 8) in;
#include "multigrid/levels.glsl"
#include "multigrid/vectors.glsl"
#include "multigrid/reduce.glsl"
layout(std430, binding = 4) buffer Directions { vec2 p[]; };
layout(std430, binding = 5) buffer Solution { vec2 v[]; };
layout(std430, binding = 7) buffer Load { vec2 load[]; };
#define VALUE(k) v[k]
#include "multigrid/stencil.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    float gained = 0.0;
    if (is_inside(at, level)) {
        int node = number(at, level);
        vec2 left = load[node] - applied(at, node);
        b[node] = left;
        p[node] = vec2(0.0);
        gained = dot(load[node] - left, load[node] + left);
    }
    put(vec2(gained, 0.0));
}
