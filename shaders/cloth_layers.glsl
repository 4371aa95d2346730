// The layers of a photo of cloth at a pixel: as they are (RAW), or of a coarser level, as halve_cloth.frag makes them.
// It needs transfer.glsl.

uniform sampler2D coordinates;   // texels; RAW: no numbers where there is no cloth, else z = 1 on cloth, w = coverage
uniform sampler2D shading;       // Wp
uniform sampler2D detail;        // HF
uniform sampler2D photo;         // straight; encoded, but where it is RAW and `linear`
uniform sampler2D coverage;      // RAW only
uniform bool linear;             // the photo is float and may leave 0..1

// x, y = texels, z = 1 where there is cloth, w = coverage.
vec4 place_at(ivec2 at) {
    vec4 place = texelFetch(coordinates, at, 0);
#ifdef RAW
    // Drivers may take isnan() for false.
    bool is_cloth = all(lessThan(floatBitsToUint(place.xy) & 0x7fffffffu, uvec2(0x7f800000u)));
    return vec4(is_cloth ? place.xy : vec2(0.0), float(is_cloth), texelFetch(coverage, at, 0).r);
#else
    return place;
#endif
}

vec4 photo_at(ivec2 at) {
    vec4 seen = texelFetch(photo, at, 0);
#ifdef RAW
    if (linear) seen.rgb = encoded(seen.rgb);
#endif
    return seen;
}

vec3 light_at(ivec2 at) { return texelFetch(shading, at, 0).rgb; }

vec3 detail_at(ivec2 at) { return texelFetch(detail, at, 0).rgb; }
