"""Build your own: any callable is a warp, and any quadratic energy on the grid can be factored and solved.

A ripple in closed form is the warp. The energy is the bending of a thin plate that is tied to the ripple by springs,
stiff at the rim and soft inside: a smoothed ripple, from one factor for both coordinates.
"""

import numpy as np
from scipy import sparse

from core.arrays import Points
from core.grid import Grid
from core.linalg.factor import Factor

WIDTH, HEIGHT = 320, 240


def ripple(points: Points) -> Points:
    """Push points outwards and inwards in rings around the middle."""
    away = points - [WIDTH / 2, HEIGHT / 2]
    radius = np.linalg.norm(away, axis=-1, keepdims=True) + 1e-9
    pushed: Points = points + away / radius * 6 * np.sin(radius / 9)
    return pushed


grid = Grid(WIDTH, HEIGHT, cell_px=4)

# Second differences along rows and columns, each a matrix over all nodes.
down, across = (sparse.diags_array([1.0, -2.0, 1.0], offsets=[0, 1, 2], shape=(n - 2, n)) for n in grid.shape)
bending = sparse.vstack(
    [sparse.kron(sparse.eye_array(grid.rows), across), sparse.kron(down, sparse.eye_array(grid.columns))]
)
springs = np.where(grid.outline.ravel(), 1e3, 0.005)

# ½|bending z|² + ½ springs |z - W|² is least where (bendingᵀ bending + springs) z = springs W.
factor = Factor(bending.T @ bending + sparse.diags_array(springs))
target = ripple(grid.nodes).reshape(-1, 2)
smooth = factor.solve(springs[:, None] * target).reshape(grid.nodes.shape)

print(factor)
roughness = [float(abs(bending @ sparse.csr_array(z.reshape(-1, 2))).mean()) for z in (target, smooth)]
print(f"mean second difference: {roughness[0]:.3f} px in the ripple, {roughness[1]:.3f} px smoothed")
assert roughness[1] < 0.5 * roughness[0]
