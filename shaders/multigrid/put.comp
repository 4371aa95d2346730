#version 430
// Put values at some nodes: PUT is what is done there with a NUMBER that a node has.
layout(local_size_x = 256) in;
layout(std430, binding = 1) buffer Target { NUMBER target[]; };
layout(std430, binding = 2) readonly buffer Nodes { int nodes[]; };
layout(std430, binding = 3) readonly buffer Values { dvec2 values[]; };
uniform int count;

void main() {
    int k = int(gl_GlobalInvocationID.x);
    if (k < count) target[nodes[k]] PUT NUMBER(values[k]);
}
