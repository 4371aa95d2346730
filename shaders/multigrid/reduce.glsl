// Sums and greatest values over all nodes: each group writes its own, `total.comp` brings them together.
layout(std430, binding = 6) buffer Sums {
    float energy, alpha, beta, most;   // r* M r, the step, the share of the last direction, max |M r|
    vec2 of_groups[];                  // sum and greatest value
};
shared vec2 gathered[256];

// Sum and maximum over the group, in gathered[0].
void gather(vec2 mine) {
    uint place = gl_LocalInvocationIndex;
    gathered[place] = mine;
    barrier();
    for (uint half_size = 128u; half_size > 0u; half_size >>= 1) {
        if (place < half_size) {
            vec2 other = gathered[place + half_size];
            gathered[place] = vec2(gathered[place].x + other.x, max(gathered[place].y, other.y));
        }
        barrier();
    }
}

void put(vec2 mine) {
    gather(mine);
    if (gl_LocalInvocationIndex == 0u) of_groups[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] = gathered[0];
}
