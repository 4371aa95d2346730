#version 330
// A texture laid into the cloth of a photo: I' = Wp T'(Wg) + a HF  [NRT sec. 3.3], one pixel of the photo each; linear
// light, premultiplied. The processor's twin is core/overlay/composition.py.

#include "transfer.glsl"

const int LEVELS = 14;
const float DENSITY = 1.5;   // texture samples a pixel from which on filtering begins
const int TAPS = 8;          // samples along the direction that is shrunk most

uniform ivec2 photo_size;
uniform sampler2D photo;        // encoded, straight alpha
uniform sampler2D coordinates;  // xy = texels, z = coverage, w = 1 where there are any
uniform sampler2D shading;      // Wp
uniform sampler2D detail;       // HF
uniform sampler2D pattern;      // pyramid of the texture, premultiplied by its opacity, levels side by side
uniform ivec4 levels[LEVELS];   // left, top, width and height of each
uniform int last_level;
uniform mat2 placement;         // copies of the texture a texel
uniform vec2 shift;             // copies at texel (0, 0)
uniform bool mirror;            // the pyramid holds two by two copies, mirrored
uniform bool repeats;
uniform float strength;         // of the shading's contrast, about `middle_light`
uniform float middle_light;
uniform float detail_share;
uniform bool linear;

out vec4 colour;

vec4 sample_level(vec2 at, int level) {
    ivec4 place = levels[level];
    vec2 x = fract(at) * vec2(place.zw) - 0.5;
    ivec2 low = ivec2(floor(x));
    vec2 t = x - vec2(low);
    ivec2 a = (low + place.zw) % place.zw, b = (low + 1) % place.zw;
    vec4 top = mix(texelFetch(pattern, place.xy + a, 0), texelFetch(pattern, place.xy + ivec2(b.x, a.y), 0), t.x);
    vec4 bottom = mix(texelFetch(pattern, place.xy + ivec2(a.x, b.y), 0), texelFetch(pattern, place.xy + b, 0), t.x);
    return mix(top, bottom, t.y);
}

vec4 trilinear(vec2 at, float level) {
    int low = int(level);
    return mix(sample_level(at, min(low, last_level)), sample_level(at, min(low + 1, last_level)), fract(level));
}

vec4 coordinates_at(ivec2 at) {
    bool outside = any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, photo_size));
    return outside ? vec4(0.0) : texelFetch(coordinates, at, 0);
}

// Change per pixel along `axis`, the smaller of those to both neighbours: it does not see a jump between pieces.
vec2 steepness(ivec2 at, ivec2 axis, mat2 to_samples) {
    vec4 before = coordinates_at(at - axis), here = coordinates_at(at), after = coordinates_at(at + axis);
    vec2 back = to_samples * (here.xy - before.xy), ahead = to_samples * (after.xy - here.xy);
    float behind = before.w > 0.5 ? dot(back, back) : 1e30, beyond = after.w > 0.5 ? dot(ahead, ahead) : 1e30;
    if (min(behind, beyond) >= 1e30) return vec2(0.0);
    return behind <= beyond ? back : ahead;
}

// The texture at `copies` over the footprint of the pixel: several samples along its long axis.
vec4 filtered_pattern(ivec2 at, vec2 copies, float per_tile) {
    vec2 samples = vec2(levels[0].zw) / DENSITY;
    mat2 to_samples = mat2(samples.x, 0.0, 0.0, samples.y) * placement * per_tile;
    vec2 x = steepness(at, ivec2(1, 0), to_samples), y = steepness(at, ivec2(0, 1), to_samples);
    // Singular values and the first left vector of J = (x y), from the angle that diagonalises J J^T.
    float a = x.x * x.x + y.x * y.x, b = x.x * x.y + y.x * y.y, c = x.y * x.y + y.y * y.y;
    float middle = 0.5 * (a + c), gap = length(vec2(0.5 * (a - c), b));
    float angle = gap > 0.0 ? 0.5 * atan(b, 0.5 * (a - c)) : 0.0;
    float longest = sqrt(middle + gap), width = sqrt(max(middle - gap, 0.0));
    float level = log2(max(max(width, longest / float(TAPS)), 1.0));
    float reach = longest > 1.0 ? longest - max(width, 1.0) : 0.0;
    vec2 step = reach / float(TAPS) * vec2(cos(angle), sin(angle)) / samples;
    int taps = reach > 0.0 ? TAPS : 1;
    vec4 sum = vec4(0.0);
    for (int k = 0; k < taps; k++) {
        sum += trilinear(copies * per_tile + (float(k) + 0.5 - 0.5 * float(taps)) * step, level);
    }
    return sum / float(taps);
}

void main() {
    ivec2 at = min(ivec2(gl_FragCoord.xy), photo_size - 1);
    vec4 old = texelFetch(photo, at, 0), place = texelFetch(coordinates, at, 0);
    vec2 copies = placement * place.xy + shift;
    vec4 pattern_here = filtered_pattern(at, copies, mirror ? 0.5 : 1.0);
    if (!repeats && (any(lessThan(copies, vec2(0.0))) || any(greaterThanEqual(copies, vec2(1.0))))) pattern_here = vec4(0.0);

    vec3 light = texelFetch(shading, at, 0).rgb;
    if (strength != 1.0) light = middle_light * pow(max(light / middle_light, 1e-6), vec3(strength));
    vec3 cloth = light * pattern_here.rgb / max(pattern_here.a, 1e-6) + detail_share * texelFetch(detail, at, 0).rgb;
    vec3 code = mix(old.rgb, cloth, place.w > 0.5 ? pattern_here.a * place.z : 0.0);
    code = linear ? code : clamp(code, 0.0, 1.0);
    colour = vec4(decoded(code) * old.a, old.a);
}
