#version 330
// The layers of cloth at half the size: means over the pixels of a block that are cloth, and of the photo over all.

#include "transfer.glsl"
#include "cloth_layers.glsl"

uniform int first_row;   // of the target

layout(location = 0) out vec4 coarse_place;
layout(location = 1) out vec4 coarse_light;
layout(location = 2) out vec4 coarse_detail;
layout(location = 3) out vec4 coarse_photo;

const float NEAR = 0.5;   // coordinates of one block that differ by more texels belong to two pieces of cloth

void main() {
    ivec2 last = textureSize(coordinates, 0) - 1, corner = 2 * (ivec2(gl_FragCoord.xy) - ivec2(0, first_row));
    vec4 places = vec4(0.0), seen = vec4(0.0);
    vec3 lights = vec3(0.0), details = vec3(0.0);
    vec2 first = vec2(0.0);
    bool is_apart = false;
    for (int k = 0; k < 4; k++) {
        ivec2 at = min(corner + ivec2(k & 1, k >> 1), last);   // the border repeats
        vec4 place = place_at(at);
        seen += photo_at(at);
        places.w += place.w;
        if (place.z < 0.5) continue;
        if (places.z == 0.0) first = place.xy;
        vec2 away = abs(place.xy - first);
        is_apart = is_apart || max(away.x, away.y) > NEAR;
        places.xyz += place.xyz;
        lights += light_at(at);
        details += detail_at(at);
    }
    float count = max(places.z, 1.0);
    coarse_place = vec4(is_apart ? first : places.xy / count, min(places.z, 1.0), places.w / 4.0);
    coarse_light = vec4(lights / count, 1.0);
    coarse_detail = vec4(details / count, 1.0);
    coarse_photo = seen / 4.0;
}
