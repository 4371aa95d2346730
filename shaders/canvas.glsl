// The canvas as it is shown: desk and checks, the picture over them in linear light, the marks over that. Row 0 is the
// top.

#include "transfer.glsl"

uniform vec4 frame;          // left, top, right, bottom edge of the result in framebuffer pixels
uniform float check_px;
uniform vec3 desk, check_dark, check_light;   // linear

vec3 backdrop(vec2 at) {
    vec2 inside = clamp(min(at - frame.xy, frame.zw - at) + 0.5, 0.0, 1.0);
    vec2 square = floor((at - frame.xy) / check_px);
    vec3 check = mod(square.x + square.y, 2.0) < 0.5 ? check_dark : check_light;
    return mix(desk, check, inside.x * inside.y);
}

// The pixel at `at`: `picture` is linear and premultiplied, `mark` encoded and premultiplied.
vec4 composed(vec2 at, vec4 picture, vec4 mark) {
    float alpha = clamp(picture.a, 0.0, 1.0);
    vec3 shown = encoded(clamp(picture.rgb + (1.0 - alpha) * backdrop(at), 0.0, 1.0));
    return vec4(mark.rgb + (1.0 - mark.a) * shown, 1.0);
}
