// Resampling of the picture: cubic convolution (Keys 1981, a = -1/2), stretched to the footprint where it shrinks.
// Where DRAFT is defined, a blend of four texels of the level: a renderer in software runs every branch that is compiled.
// Where INTERPOLATED or AVERAGED is, every footprint is known to be of that kind; where NARROW is, to span
// five texels of level 0 at most along a row. Where ENCODED is, level 0 are the picture's bytes, and no other is read
// unless COARSER is defined too.

#ifdef ENCODED
#include "decode_bytes.glsl"
uniform sampler2D picture_bytes;   // level 0, encoded and straight
#endif

// Texels that are read at once: more where they cost less than a turn.
#if defined(ENCODED) && !defined(COARSER)
#ifdef NARROW
const int TURN = 5;
#else
const int TURN = 6;
#endif
#else
const int TURN = 2;
#endif

uniform sampler2D picture;    // linear light, premultiplied: the base level, at its right the coarser ones
uniform int coarser_left;     // the first column of the coarser ones
uniform ivec2 picture_size;   // whole picture in pixels
uniform ivec4 window;         // source pixel that is the texture's first; size of the base level in texels
uniform int base_level;

float cubic(float x) {
    float rest = max(2.0 - x, 0.0);
    return (1.0 - x) * (x < 1.0 ? 1.0 + x * (1.0 - 1.5 * x) : 0.5 * rest * rest);
}

// Weights of the texels at -1, 0, 1, 2 for a position at t in [0, 1).
vec4 cubic_weights(float t) {
    float t2 = t * t, t3 = t2 * t;
    return vec4(-0.5 * t3 + t2 - 0.5 * t, 1.5 * t3 - 2.5 * t2 + 1.0, -1.5 * t3 + 2.0 * t2 + 0.5 * t, 0.5 * t3 - 0.5 * t2);
}

// Place in the texture of the first texel of a level of the whole picture.
ivec2 level_origin(int level) {
    int above = level - base_level;
    ivec2 place = above > 0 ? ivec2(coarser_left, window.w - (window.w >> (above - 1))) : ivec2(0);
    return place - (window.xy >> level);
}

// Texels of a level that the texture holds, in those of the whole picture.
struct Level {
    ivec2 first, last;
    ivec2 origin;   // place in the texture of the whole picture's first texel
    bool is_encoded;
};

Level level_of(int level) {
    ivec2 first = window.xy >> level;
    ivec2 last = first + (window.zw >> (level - base_level)) - 1;
    return Level(first, min(last, (picture_size - 1) >> level), level_origin(level), level == 0);
}

// The light at a place of the texture.
vec4 light_at(ivec2 place, Level level) {
#ifdef ENCODED
    vec4 pixel = texelFetch(picture_bytes, place, 0);
    vec4 light = vec4(decoded_bytes(pixel.rgb) * pixel.a, pixel.a);
#ifdef COARSER
    light = level.is_encoded ? light : texelFetch(picture, place, 0);
#endif
    return light;
#else
    return texelFetch(picture, place, 0);
#endif
}

// One texel of a level; the picture's border repeats outwards.
vec4 texel(ivec2 at, Level level) {
    return light_at(clamp(at, level.first, level.last) + level.origin, level);
}

// The kernel's lobes ring beside strong edges, darkly so in linear light: no result leaves the range of the texels next to
// it. Along one axis at a time, so that the result has no jumps.
vec4 between_neighbours(vec4 value, vec4 left, vec4 right) {
    return clamp(value, min(left, right), max(left, right));
}

vec4 interpolated(ivec2 at, vec2 t, Level level) {
    vec4 wx = cubic_weights(t.x), wy = cubic_weights(t.y);
    vec4 rows[4];
    for (int y = 0; y < 4; y++) {
        vec4 a = texel(at + ivec2(-1, y - 1), level), b = texel(at + ivec2(0, y - 1), level);
        vec4 c = texel(at + ivec2(1, y - 1), level), d = texel(at + ivec2(2, y - 1), level);
        rows[y] = between_neighbours(wx.x * a + wx.y * b + wx.z * c + wx.w * d, b, c);
    }
    vec4 sum = wy.x * rows[0] + wy.y * rows[1] + wy.z * rows[2] + wy.w * rows[3];
    return between_neighbours(sum, rows[1], rows[2]);
}

// The sampler blends; its place stays within the level.
vec4 blended(ivec2 at, vec2 t, Level level) {
    vec2 place = clamp(vec2(at) + t, vec2(level.first), vec2(level.last)) + vec2(level.origin) + 0.5;
    return textureLod(picture, place / vec2(textureSize(picture, 0)), 0.0);
}

// Sum over the texels with |K d| <= 2 in both components, row by row: the support is a parallelogram. Loops end at their
// foot: a renderer in software runs the rest of a turn that is left for good. What a row's last turn reads beyond the
// support weighs nothing.
vec4 averaged(ivec2 at, vec2 t, vec3 K, Level level) {
    float det = K.x * K.z - K.y * K.y;
    float reach = 2.0 * (K.x + abs(K.y)) / det;
    // Where a row meets each of the two strips: its middle moves by `slope` from row to row.
    bool slanted = abs(K.y) > 1e-6;
    vec2 slope = -vec2(K.y / K.x, slanted ? K.z / K.y : 0.0);
    vec2 half_width = vec2(2.0 / K.x, slanted ? 2.0 / abs(K.y) : 1e9);
    vec4 sum = vec4(0.0);
    float total = 0.0;
    vec4 low = vec4(1e30), high = vec4(-1e30);   // of the texels under the kernel's core
    float y = ceil(t.y - reach);
    do {
        float dy = y - t.y;
        vec2 from = slope * dy - half_width, to = slope * dy + half_width;
        float x = ceil(t.x + max(from.x, from.y)), right = t.x + min(to.x, to.y);
        int row = clamp(at.y + int(y), level.first.y, level.last.y) + level.origin.y;
        vec2 d = K.xy * (x - t.x) + K.yz * dy;
        do {
            for (int i = 0; i < TURN; i++, d += K.xy) {
                vec2 away = abs(d);
                float weight = cubic(away.x) * cubic(away.y);
                int column = clamp(at.x + int(x) + i, level.first.x, level.last.x) + level.origin.x;
                vec4 colour = light_at(ivec2(column, row), level);
                bool core = max(away.x, away.y) < 1.0;
                low = core ? min(low, colour) : low;
                high = core ? max(high, colour) : high;
                sum += weight * colour;
                total += weight;
            }
            x += float(TURN);
        } while (x <= right);
        y += 1.0;
    } while (y <= t.y + reach);
    return clamp(sum / total, low, high);
}

// The picture at source pixel whole + fraction, filtered by `kernel` at `level` (mesh.vert).
vec4 filtered(vec2 whole, vec2 fraction, vec3 kernel, int level) {
    ivec2 pixel = ivec2(whole);
    ivec2 at = pixel >> level;
    // Texel i of a level is centred at (i + 1/2) 2^level - 1/2.
    vec2 t = (vec2(pixel - (at << level)) + fraction + 0.5) / exp2(float(level)) - 0.5;
    vec2 low = floor(t);
    at += ivec2(low);
    t -= low;
    Level texels = level_of(level);
#ifdef DRAFT
    return blended(at, t, texels);
#elif defined(INTERPOLATED)
    return interpolated(at, t, texels);
#elif defined(AVERAGED)
    return averaged(at, t, kernel, texels);
#else
    bool plain = abs(kernel.x - 1.0) + abs(kernel.y) + abs(kernel.z - 1.0) < 1e-4;
    return plain ? interpolated(at, t, texels) : averaged(at, t, kernel, texels);
#endif
}
