#version 330
// A rendered tile as the file holds it: straight alpha, encoded.

#include "transfer.glsl"

uniform sampler2D tile;
uniform bool linear;

out vec4 pixel;

void main() {
    vec4 light = texelFetch(tile, ivec2(gl_FragCoord.xy), 0);
    vec3 colour = straight(light);
    // The weights of the filter sum to 1 but for rounding; what is opaque stays so.
    float alpha = light.a > 1.0 - 1e-5 ? 1.0 : max(light.a, 0.0);
    pixel = vec4(linear ? colour : encoded(colour), alpha);
}
