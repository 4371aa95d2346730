#version 330
// The warped picture on a surface: where its chart has each place of the texture, that pixel of the result.

#include "transfer.glsl"

uniform sampler2D chart;    // the surface's texture -> share of the result's canvas
uniform sampler2D picture;  // the result, linear and premultiplied
uniform float ambient;      // how bright it is where the surface is seen from its side
uniform float bare;         // how light the surface is where the picture is clear; below 0 the picture has no alpha

in vec3 facing;
in vec2 at;

layout(location = 0) out vec4 shown;

void main() {
    ivec2 nodes = textureSize(chart, 0);
    vec2 share = at - floor(at);
    // Where the texture ends at 1 it does not begin anew at 0; its level is that of the place before it was folded.
    share += vec2(greaterThan(at, vec2(0.0))) * vec2(equal(share, vec2(0.0)));
    vec2 step = vec2(nodes - 1) / vec2(nodes);
    vec2 from = 0.5 / vec2(nodes);
    vec2 place = texture(chart, from + share * step).xy;
    vec2 right = dFdx(at), down = dFdy(at);
    vec2 along = texture(chart, from + (share + right) * step).xy - place;
    vec2 below = texture(chart, from + (share + down) * step).xy - place;
    vec4 light = textureGrad(picture, place, along, below);
    // Where the picture itself is whole, only the edge of its frame lets anything through.
    vec3 whole = light.a > 0.0 ? light.rgb / light.a : vec3(0.0);
    vec3 colour = bare < 0.0 ? whole : light.rgb + (1.0 - light.a) * bare;
    float facing_us = abs(normalize(facing).z);
    shown = vec4(encoded(colour * mix(ambient, 1.0, facing_us)), 1.0);
}
