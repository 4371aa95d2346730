// A symmetric nine-point operator A on every level of a hierarchy of grids, the finest first, and vectors on them.
//
// A node's coefficients: with its right, lower, lower right and lower left neighbour; the excess, which is the sum of
// its row of A; and 1 / sum |a| of its row, by which the smoother scales (l1-Jacobi [Baker et al. 2011]), 0 where the
// row is empty. Of each level they lie one after the other, from 6 * first on.

layout(std140, binding = 0) uniform Level {
    ivec4 level;     // rows, columns, number of the first node in vectors
    ivec4 coarser;   // the same of the next coarser level
};
layout(std430, binding = 0) buffer Coefficients { float coefficients[]; };

const int EXCESS = 0, EAST = 1, SOUTH = 2, SOUTH_EAST = 3, SOUTH_WEST = 4, SCALE = 5;
// Steps of Chebyshev's iteration of degree two over the upper three quarters of a spectrum that ends at 1.
const float STEPS[2] = float[](1.0 / (0.625 + 0.375 * 0.70710678), 1.0 / (0.625 - 0.375 * 0.70710678));

bool is_inside(ivec2 at, ivec4 grid) {
    return at.x >= 0 && at.y >= 0 && at.x < grid.y && at.y < grid.x;
}

// Number of node (column, row) of a grid, counted from 0 in each.
int number(ivec2 at, ivec4 grid) {
    return at.y * grid.y + at.x;
}

float coefficient(int which, int node, ivec4 grid) {
    return coefficients[6 * grid.z + which * grid.x * grid.y + node];
}

// What A has between a node and the one `step` away from it, 0 beyond the grid's edge.
float coupling(ivec2 at, ivec2 step, ivec4 grid) {
    if (!is_inside(at + step, grid)) return 0.0;
    bool is_first = step.y > 0 || (step.y == 0 && step.x > 0);
    int node = number(is_first ? at : at + step, grid);
    ivec2 way = is_first ? step : -step;
    int which = way.y == 0 ? EAST : way.x == 0 ? SOUTH : way.x > 0 ? SOUTH_EAST : SOUTH_WEST;
    return coefficient(which, node, grid);
}
