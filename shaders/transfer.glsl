// The sRGB transfer function (IEC 61966-2-1), also outside 0..1, where float pictures live.

vec3 encoded(vec3 light) {
    vec3 size = abs(light);
    vec3 curve = 1.055 * pow(max(size, 1e-9), vec3(1.0 / 2.4)) - 0.055;
    return sign(light) * mix(curve, 12.92 * size, lessThanEqual(size, vec3(0.0031308)));
}

vec3 straight(vec4 premultiplied) {
    return premultiplied.a > 1e-6 ? premultiplied.rgb / premultiplied.a : vec3(0.0);
}

vec3 decoded(vec3 values) {
    vec3 size = abs(values);
    vec3 curve = pow((size + 0.055) / 1.055, vec3(2.4));
    return sign(values) * mix(curve, size / 12.92, lessThanEqual(size, vec3(0.04045)));
}
