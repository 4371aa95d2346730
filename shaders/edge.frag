#version 330
// Third pass: the pixels that the outline cuts, over what is behind them.

#include "mesh.glsl"
#include "filter.glsl"

out vec4 colour;

void main() {
    vec2 offset = from_corner();
    float share = share_inside(cell_position(offset), cells_per_pixel());
    if (share <= 0.0 || share >= INSIDE) discard;
    colour = share * filtered(rest_corner.zw, rest_corner.xy + to_source * offset, kernel, level);
}
