#version 330
// The deformed grid with its ring, two triangles a quad (app/render/passes/ring.py).
//
// Vertex 2 n + k is node n. It is the last corner of the two triangles of the quad above and left of it, and hands
// triangle k (0: top left, top right, bottom right; 1: bottom left, top left, bottom right) its affine maps as flat
// values: output pixel -> source pixel and output pixel -> grid cell. Each is exact for every fragment, whatever the tile.
//
// Positions come as whole pixels and a fraction, so that differences of neighbours lose no bits in big pictures.

uniform sampler2D rest_nodes;   // (R + 2, C + 2) source pixels: xy = fraction, zw = whole
uniform sampler2D moved_nodes;  // (R + 2, C + 2) output pixels: xy = fraction, zw = whole
uniform sampler2D cell_nodes;   // (R + 2, C + 2) grid coordinates (column, row)
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

struct Node {
    vec4 moved;
    vec4 rest;
    vec2 cell;
};

vec2 between(vec4 a, vec4 b) {
    return (b.zw - a.zw) + (b.xy - a.xy);
}

Node node_at(ivec2 at) {
    return Node(texelFetch(moved_nodes, at, 0), texelFetch(rest_nodes, at, 0), texelFetch(cell_nodes, at, 0).xy);
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
    int width = textureSize(moved_nodes, 0).x;
    int number = gl_VertexID >> 1;
    ivec2 at = ivec2(number % width, number / width);
    ivec2 before = max(at - 1, 0);
    Node last = node_at(at);
    Node first = node_at(ivec2(before.x, (gl_VertexID & 1) == 0 ? before.y : at.y));
    Node middle = node_at(ivec2((gl_VertexID & 1) == 0 ? at.x : before.x, before.y));

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
