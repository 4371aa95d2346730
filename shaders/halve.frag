#version 330
// Means of blocks of a part of a texture; blocks of one pixel copy it.

uniform sampler2D texels;
uniform ivec2 origin;   // the part's first texel
uniform ivec2 corner;   // the target's first pixel
uniform int block;

out vec4 mean;

void main() {
    ivec2 at = origin + (ivec2(gl_FragCoord.xy) - corner) * block;
    vec4 sum = vec4(0.0);
    for (int y = 0; y < block; y++) {
        for (int x = 0; x < block; x++) sum += texelFetch(texels, at + ivec2(x, y), 0);
    }
    mean = sum / float(block * block);
}
