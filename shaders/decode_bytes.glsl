// The light of bytes, as `decoded` (transfer.glsl) has it within 0.012 of the step from each to the next: half precision
// is off by three times as much, and powers take several times as long. The polynomial has the least greatest error, in
// such steps, of its degree.
vec3 decoded_bytes(vec3 values) {
    vec3 curve = ((((0.0855831 * values - 0.303281) * values + 0.663686) * values + 0.520621) * values + 0.0325713)
        * values + 0.000924239;
    return mix(curve, values / 12.92, lessThanEqual(values, vec3(0.04045)));
}
