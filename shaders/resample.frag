#version 330
// Second pass: the picture in linear light, premultiplied, filtered for the footprint of every pixel.

#include "filter.glsl"

uniform sampler2D place, footprint;   // of place.frag

out vec4 colour;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 source = texelFetch(place, at, 0);
    vec4 shape = texelFetch(footprint, at, 0);
    bool inside = shape.w > 0.5;
    vec3 kernel = inside ? shape.xyz : vec3(8.0, 0.0, 8.0);   // of no texel, which costs the least
    vec4 light = filtered(source.zw, source.xy, kernel, inside ? int(shape.w - 0.5) : base_level);
    colour = inside ? light : vec4(0.0);
}
