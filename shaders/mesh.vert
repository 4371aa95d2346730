#version 330
// The deformed grid, two triangles a quad, with a ring of cells outside it in which the outline fades out.
//
// Vertex 2 n + k is ring node n. It is the last corner of the two triangles of the quad above and left of it, and hands
// triangle k (0: top left, top right, bottom right; 1: bottom left, top left, bottom right) its affine maps as flat
// values: output pixel -> source pixel and output pixel -> grid cell. Each is exact for every fragment, whatever the tile.
//
// Positions come as whole pixels and a fraction, so that differences of neighbours lose no bits in big pictures.

uniform sampler2D rest_nodes;   // (R, C) source pixels: xy = fraction, zw = whole
uniform sampler2D moved_nodes;  // (R, C) output pixels: xy = fraction, zw = whole
uniform float stride;           // cells between nodes, but for the last ones of a row and a column
uniform vec2 last_cell;         // grid coordinates of the last node
uniform vec2 target_origin;     // output pixel that is the target's first
uniform float target_extent;    // side of the square target, a power of two: the projection rounds nothing
uniform int base_level;         // finest level of the picture's pyramid that the texture holds
uniform int top_level;          // coarsest level that it holds
uniform float least_stretch;    // how many texels of its level a shrinking kernel spans at least

flat out vec4 moved_corner;  // output pixel of the triangle's first corner: xy = fraction, zw = whole
flat out vec4 rest_corner;   // source pixel of that corner
flat out vec2 cell_corner;   // grid coordinates (column, row) of that corner
flat out mat2 to_source;     // d(source pixel) / d(output pixel)
flat out mat2 to_cell;       // d(grid coordinates) / d(output pixel)
flat out vec3 kernel;        // symmetric map from texels of the level to the units of the kernel: xx, xy, yy
flat out int level;          // level of the pyramid to read

const float MOST_ANISOTROPY = 16.0;
const float RING_PX = 1.5;
const float MOST_RING_PX = 4.0;

struct Node {
    vec4 moved;
    vec4 rest;
    vec2 cell;
};

vec2 between(vec4 a, vec4 b) {
    return (b.zw - a.zw) + (b.xy - a.xy);
}

vec2 cell_of(ivec2 node) {
    return min(vec2(node) * stride, last_cell);
}

// How many steps between nodes beyond `edge` the ring reaches: RING_PX across the outline, MOST_RING_PX at most.
float ring_reach(ivec2 edge, ivec2 inward, ivec2 last) {
    ivec2 along = inward.yx;
    vec4 here = texelFetch(moved_nodes, edge, 0);
    vec2 step = between(texelFetch(moved_nodes, edge + inward, 0), here);
    vec2 tangent = between(texelFetch(moved_nodes, clamp(edge - along, ivec2(0), last), 0),
                           texelFetch(moved_nodes, clamp(edge + along, ivec2(0), last), 0));
    float across = abs(step.x * tangent.y - step.y * tangent.x) / max(length(tangent), 1e-6);
    return min(RING_PX / max(across, 1e-6), MOST_RING_PX / max(length(step), 1e-6));
}

void extend(inout Node node, ivec2 edge, ivec2 inward, ivec2 last) {
    float reach = ring_reach(edge, inward, last);
    node.moved.xy += reach * between(texelFetch(moved_nodes, edge + inward, 0), texelFetch(moved_nodes, edge, 0));
    node.rest.xy += reach * between(texelFetch(rest_nodes, edge + inward, 0), texelFetch(rest_nodes, edge, 0));
    node.cell += reach * (cell_of(edge) - cell_of(edge + inward));
}

Node ring_node(ivec2 at) {
    ivec2 last = textureSize(moved_nodes, 0) - 1;
    ivec2 edge = clamp(at, ivec2(0), last);
    Node node = Node(texelFetch(moved_nodes, edge, 0), texelFetch(rest_nodes, edge, 0), cell_of(edge));
    if (at.x != edge.x) extend(node, edge, ivec2(edge.x - at.x, 0), last);
    if (at.y != edge.y) extend(node, edge, ivec2(0, edge.y - at.y), last);
    return node;
}

// The kernel follows the polar factor S of the Jacobian J = S Q in source pixels, with singular values raised to at least
// one texel: S' = sqrt(J J^T) where it shrinks, identity where it enlarges; so the filter is continuous at scale 1 and
// interpolates there. A function f of the symmetric C = J J^T is a I + b C with b the divided difference of f.
void choose_filter(mat2 J) {
    mat2 C = J * transpose(J);
    float mean = 0.5 * (C[0][0] + C[1][1]);
    float spread = length(vec2(0.5 * (C[0][0] - C[1][1]), C[0][1]));
    float major = sqrt(mean + spread);
    float minor = max(sqrt(max(mean - spread, 0.0)), major / MOST_ANISOTROPY);
    level = clamp(int(floor(log2(max(minor, 1e-9) / least_stretch))), base_level, top_level);
    float texel = exp2(float(level));
    major = max(major, texel);
    minor = max(minor, texel);
    float gap = 2.0 * spread;
    float b = gap > 1e-6 * mean ? (1.0 / major - 1.0 / minor) / gap : 0.0;
    float a = 1.0 / major - b * (mean + spread);
    kernel = (vec3(a, 0.0, a) + b * vec3(C[0][0], C[0][1], C[1][1])) * texel;
}

void main() {
    int width = textureSize(moved_nodes, 0).x + 2;
    int ring_index = gl_VertexID >> 1;
    ivec2 at = ivec2(ring_index % width, ring_index / width) - 1;
    Node last = ring_node(at);
    Node first = ring_node(at - ivec2(1, (gl_VertexID & 1) == 0 ? 1 : 0));
    Node middle = ring_node(at - ivec2((gl_VertexID & 1) == 0 ? 0 : 1, 1));

    mat2 moved = mat2(between(first.moved, middle.moved), between(first.moved, last.moved));
    float area = determinant(moved);
    mat2 barycentric = area != 0.0 ? inverse(moved) : mat2(0.0);
    to_source = mat2(between(first.rest, middle.rest), between(first.rest, last.rest)) * barycentric;
    to_cell = mat2(middle.cell - first.cell, last.cell - first.cell) * barycentric;
    moved_corner = first.moved;
    rest_corner = first.rest;
    cell_corner = first.cell;
    choose_filter(to_source);

    // Corners snap to 1/256 pixel, as rasterisers do, before the tile's origin enters: every tile covers the same pixels.
    // The viewport is twice the target, centred on it, so that triangles at the target's edge are not clipped, which
    // would snap new corners.
    vec2 snapped = (last.moved.zw - target_origin) + floor(last.moved.xy * 256.0 + 0.5) / 256.0;
    gl_Position = vec4((snapped + 0.5) / target_extent - 0.5, 0.0, 1.0);
}
