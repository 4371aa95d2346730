#version 430
// Where the nodes of a grid are on the canvas -> where mesh.vert reads that they are in the framebuffer, and the box
// around every block of quads. A group has the corners of one block's quads, those that it shares with the next included.
//
// The ring around the nodes is there already (app/render/passes/ring.py).

layout(local_size_x = CORNERS, local_size_y = CORNERS) in;   // BLOCK + 1

layout(rgba32f, binding = 0) uniform image2D moved_nodes;                     // (R + 2, C + 2), as in mesh.vert
layout(std430, binding = 0) readonly buffer Canvas { dvec2 canvas[]; };      // (R, C)
layout(std430, binding = 1) writeonly buffer Boxes { ivec4 boxes[]; };       // whole pixels: left, top, right, bottom
uniform double scale;
uniform dvec2 offset;

const float FAR = 1e9;   // what lies beyond is as far as that
shared int box[4];

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        box[0] = box[1] = int(FAR);
        box[2] = box[3] = -int(FAR);
    }
    barrier();
    ivec2 size = imageSize(moved_nodes), at = BLOCK * ivec2(gl_WorkGroupID.xy) + ivec2(gl_LocalInvocationID.xy);
    if (all(lessThan(at, size))) {
        vec4 node;
        if (all(greaterThan(at, ivec2(0))) && all(lessThan(at, size - 1))) {
            dvec2 place = canvas[(at.y - 1) * (size.x - 2) + at.x - 1] * scale + offset, whole = floor(place);
            node = vec4(vec2(place - whole), vec2(whole));
            imageStore(moved_nodes, at, node);
        } else {
            node = imageLoad(moved_nodes, at);
        }
        ivec2 low = ivec2(clamp(node.zw, -FAR, FAR)), high = low + ivec2(ceil(node.xy));
        atomicMin(box[0], low.x);
        atomicMin(box[1], low.y);
        atomicMax(box[2], high.x);
        atomicMax(box[3], high.y);
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        boxes[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] = ivec4(box[0], box[1], box[2], box[3]);
    }
}
