#version 330
// A texture in the folds of a photo, I' = Wp T'(Wg) + alpha HF, in linear light, premultiplied; core/overlay/composition.py
// does the same on the CPU.

#include "transfer.glsl"
#include "cloth_layers.glsl"

uniform sampler2D pattern;       // encoded, premultiplied; repeats
uniform mat2 to_copies;          // texels to copies of the pattern
uniform vec2 first_copy;
uniform vec2 samples;            // of a copy, over DENSITY
uniform int most_taps;
uniform bool tiled;              // else there is one copy
uniform float alpha, strength, usual_light;

out vec4 colour;

const float OUTSIDE = 1e30;

vec2 copies_at(ivec2 at) {
    return to_copies * place_at(at).xy + first_copy;
}

vec2 step_to(ivec2 other, ivec2 last, vec2 here) {
    bool there = all(greaterThanEqual(other, ivec2(0))) && all(lessThanEqual(other, last))
        && place_at(clamp(other, ivec2(0), last)).z > 0.5;
    return there ? (copies_at(other) - here) * samples : vec2(OUTSIDE);
}

// The smaller of the differences to both neighbours: it does not see a jump between pieces of cloth.
vec2 steepness(ivec2 at, ivec2 along, ivec2 last, vec2 here) {
    vec2 before = -step_to(at - along, last, here), after = step_to(at + along, last, here);
    vec2 least = dot(before, before) <= dot(after, after) ? before : after;
    return abs(least.x) < 0.5 * OUTSIDE ? least : vec2(0.0);
}

// The pattern around `here`: several samples along the direction that is shrunk most.
vec4 filtered(vec2 here, vec2 across, vec2 down) {
    float a = across.x * across.x + down.x * down.x, c = across.y * across.y + down.y * down.y;
    float b = across.x * across.y + down.x * down.y;
    float half_sum = 0.5 * (a + c), gap = length(vec2(0.5 * (a - c), b));
    float angle = 0.5 * atan(b, 0.5 * (a - c));
    if (gap == 0.0) angle = 0.0;
    float extent = sqrt(half_sum + gap), width = sqrt(max(half_sum - gap, 0.0));
    float level = log2(max(max(width, extent / float(most_taps)), 1.0));
    vec2 reach = extent > 1.0 ? (extent - max(width, 1.0)) * vec2(cos(angle), sin(angle)) / samples : vec2(0.0);
    int taps = int(clamp(ceil(extent), 1.0, float(most_taps)));
    vec4 sum = vec4(0.0);
    for (int k = 0; k < taps; k++)
        sum += textureLod(pattern, here + ((float(k) + 0.5) / float(taps) - 0.5) * reach, level);
    return sum / float(taps);
}

void main() {
    ivec2 last = textureSize(coordinates, 0) - 1;
    ivec2 at = min(ivec2(gl_FragCoord.xy), last);
    vec4 place = place_at(at);
    vec4 old = photo_at(at);
    vec3 shown = old.rgb;
    if (place.z > 0.5 && place.w > 0.0) {
        vec2 here = copies_at(at);
        vec4 new = filtered(here, steepness(at, ivec2(1, 0), last, here), steepness(at, ivec2(0, 1), last, here));
        if (!tiled && (any(lessThan(here, vec2(0.0))) || any(greaterThanEqual(here, vec2(1.0))))) new = vec4(0.0);
        vec3 light = light_at(at);
        if (strength != 1.0) light = usual_light * pow(max(light, 0.0) / usual_light, vec3(strength));
        vec3 laid = light * new.rgb / max(new.a, 1e-6) + alpha * detail_at(at);
        shown = mix(old.rgb, laid, new.a * place.w);
        if (!linear) shown = clamp(shown, 0.0, 1.0);
    }
    colour = vec4(decoded(shown) * old.a, old.a);
}
