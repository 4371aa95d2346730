#version 430
// The coarser level's operator P* A P, P bilinear between nodes that have neighbours in A, every second one being coarse.
layout(local_size_x = 32, local_size_y = 8) in;
#include "multigrid/levels.glsl"

float centre(ivec2 at) {
    float total = coefficient(EXCESS, number(at, level), level);
    for (int y = -1; y <= 1; y++)
        for (int x = -1; x <= 1; x++)
            if (x != 0 || y != 0) total -= coupling(at, ivec2(x, y), level);
    return total;
}

bool has_neighbours(ivec2 at) {
    for (int y = -1; y <= 1; y++)
        for (int x = -1; x <= 1; x++)
            if ((x != 0 || y != 0) && coupling(at, ivec2(x, y), level) != 0.0) return true;
    return false;
}

// P between a fine node and a coarse one.
float share(ivec2 fine, ivec2 coarse) {
    ivec2 off = abs(fine - 2 * coarse);
    return off.x > 1 || off.y > 1 ? 0.0 : (off.x == 0 ? 1.0 : 0.5) * (off.y == 0 ? 1.0 : 0.5);
}

// P* A P between a coarse node and the one `step` away.
float entry(ivec2 coarse, ivec2 step) {
    if (!is_inside(coarse + step, coarser) || !has_neighbours(2 * (coarse + step))) return 0.0;
    float total = 0.0;
    for (int y = -1; y <= 1; y++) {
        for (int x = -1; x <= 1; x++) {
            ivec2 from = 2 * coarse + ivec2(x, y);
            if (!is_inside(from, level) || !has_neighbours(from)) continue;
            float to_from = 0.0;
            for (int v = -1; v <= 1; v++) {
                for (int u = -1; u <= 1; u++) {
                    ivec2 to = from + ivec2(u, v);
                    float part = share(to, coarse + step);
                    if (part == 0.0 || !is_inside(to, level) || !has_neighbours(to)) continue;
                    to_from += part * (u == 0 && v == 0 ? centre(from) : coupling(from, ivec2(u, v), level));
                }
            }
            total += share(from, coarse) * to_from;
        }
    }
    return total;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (!is_inside(at, coarser)) return;
    bool lives = has_neighbours(2 * at);
    float excess = 0.0, sum = 0.0, values[5] = float[](0.0, 0.0, 0.0, 0.0, 0.0);
    for (int y = -1; y <= 1; y++) {
        for (int x = -1; x <= 1; x++) {
            float a = lives ? entry(at, ivec2(x, y)) : 0.0;
            excess += a;
            sum += abs(a);
            if (y == 0 && x == 1) values[EAST] = a;
            if (y == 1) values[x == 0 ? SOUTH : x == 1 ? SOUTH_EAST : SOUTH_WEST] = a;
        }
    }
    values[EXCESS] = excess;
    int size = coarser.x * coarser.y, first = 6 * coarser.z + number(at, coarser);
    for (int i = 0; i < 5; i++) coefficients[first + i * size] = values[i];
    coefficients[first + SCALE * size] = sum > 0.0 ? 1.0 / sum : 0.0;
}
