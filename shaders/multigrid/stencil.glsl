// A u at a node of the level, u being VALUE(node), in differences: what neighbours share rounds nothing.
vec2 applied(ivec2 at, int node) {
    vec2 here = VALUE(node), total = coefficient(EXCESS, node, level) * here;
    for (int down = -1; down <= 1; down++) {
        for (int across = -1; across <= 1; across++) {
            // The finest level has no diagonal couplings.
            if ((across == 0 && down == 0) || (level.z == 0 && across != 0 && down != 0)) continue;
            float a = coupling(at, ivec2(across, down), level);
            if (a != 0.0) total += a * (VALUE(node + down * level.y + across) - here);
        }
    }
    return total;
}
