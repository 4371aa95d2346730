"""The deformed grid on the GPU: an index buffer per grid shape, small textures of node positions.

The vertex shader reads nodes by number (shaders/mesh.vert), so that moving the grid is one upload of its positions.
Quads are ordered in blocks; only blocks that meet the target are drawn.
"""

from functools import cache

import moderngl
import numpy as np
from numpy.typing import NDArray

from app.render.gpu import release
from app.render.nodes import BLOCK, Nodes, Scaling, find_placer
from app.render.passes.ring import put_ring
from app.render.programs import Names, programs_of, set_uniforms
from app.render.source_footprint import Read, SourceFootprint
from app.render.sources.source import Box
from core import tracing
from core.arrays import Bools, Floats, Ints, Points
from core.linalg.cubic_convolution import Complexes
from core.mapping.jacobians import as_complex

NODE_UNITS = {"rest_nodes": 0, "moved_nodes": 1, "cell_nodes": 8}
"""Texture units."""
EDGE_PX = 1.5
"""The outline cuts pixels so far inside it."""
MOST_EDGE_LAYERS = 24
STRAIGHT_PX = 1e-6
"""An outline that misses a rectangle by less is one."""
BORDER = np.s_[:2], np.s_[-2:], np.s_[:, :2], np.s_[:, -2:]
"""The nodes of the outline and those next to it: the ring follows from them."""


class MeshBuffers:
    """A grid of R x C nodes, R and C at least 2, with source and output positions.

    With a `stride` only every so manieth node of a row and a column is drawn, and the last ones.
    """

    def __init__(self, context: moderngl.Context, shape: tuple[int, int], *, stride: int = 1) -> None:
        self.shape = shape
        self.stride = stride
        self._programs = programs_of(context)
        self._context = context
        rows, columns = (_every(stride, size) for size in shape)
        self._drawn = np.s_[:] if stride == 1 else np.ix_(rows, columns)
        shape = rows.size, columns.size
        self._nodes = {name: Nodes(context, shape, split=name != "cell_nodes") for name in NODE_UNITS}
        self._nodes["cell_nodes"].inner[:] = np.stack(np.meshgrid(columns, rows), axis=-1)
        self._indices = context.buffer(_indices(shape).tobytes())
        self._edge = np.zeros((shape[0] + 1, shape[1] + 1), bool)
        """The quads of the ring and of the grid that `_edge_indices` has."""
        self._edge_indices = context.buffer(reserve=4 * _most_at_edge(shape))
        self._is_edge_known = False
        self._arrays: dict[tuple[str, Names, int], moderngl.VertexArray] = {}
        self._first, self._count = _block_ranges(shape)
        self._placer = find_placer(context, shape)
        self._rest: Points | None = None
        self._moved: Points | None = None
        self._scaling = Scaling()
        self._unscaled = self._nodes["moved_nodes"].inner
        """Positions of the drawn nodes before they are scaled."""
        self._reach: SourceFootprint | None = None
        self._reads: dict[tuple[Box, float], Read | None] = {}
        """What was asked for since the nodes are where they are."""

    def place(self, rest: Points, moved: Points, scaling: Scaling = Scaling()) -> None:  # noqa: B008  it is frozen
        """Set where the nodes come from (source pixels) and where they are, both (R, C, 2).

        The latter are output pixels when they are scaled.
        """
        if rest is self._rest and moved is self._moved and scaling == self._scaling:
            return
        with tracing.span("place"):
            self._place(rest, moved, scaling)

    def _place(self, rest: Points, moved: Points, scaling: Scaling) -> None:
        others = [self._nodes["rest_nodes"], self._nodes["cell_nodes"]]
        places, placer = self._nodes["moved_nodes"], self._placer
        is_new, has_moved = rest is not self._rest, moved is not self._moved
        self._rest, self._moved, self._scaling, self._reach, self._reads = rest, moved, scaling, None, {}
        if has_moved:
            self._unscaled = moved[self._drawn]
        if is_new:
            others[0].inner[:] = rest[self._drawn]
        for part in [np.s_[:]] if placer is None else BORDER:
            places.inner[part] = scaling.place(self._unscaled[part])
        put_ring(places.at, *(nodes.at for nodes in others))
        with tracing.span("upload", what="nodes"):
            for nodes in others:
                if is_new:
                    nodes.send()
                else:
                    nodes.send_ring()
            if placer is None:
                places.send()
            else:
                places.send_ring()
                if has_moved:
                    placer.take(self._unscaled)
        self._low, self._high = _block_bounds(places.at) if placer is None else placer.place(scaling, places)
        self._is_edge_known = False
        self._straight = _rectangle_of(places.inner)

    def blocks_in(self, box: Box) -> Bools:
        """Return which blocks may meet the output pixels of `box`."""
        return np.asarray(
            (self._low < [box[2], box[3]]).all(axis=-1) & (self._high > [box[0] - 1, box[1] - 1]).all(axis=-1)
        )

    def bounds_in(self, box: Box) -> Box:
        """Return the part of the output pixels of `box` outside which the mesh does not come."""
        left, top = np.maximum(np.floor(self._low.min(axis=(0, 1))), box[:2]).astype(int).tolist()
        right, bottom = np.minimum(np.ceil(self._high.max(axis=(0, 1))), box[2:]).astype(int).tolist()
        return left, top, max(right, left), max(bottom, top)

    def source_of(self, box: Box, *, least_stretch: float) -> Read | None:
        """Return what drawing the output pixels of `box` reads, None where nothing is to be drawn."""
        if self._reach is None:
            places = self._nodes["moved_nodes"]
            places.inner[:] = self._scaling.place(self._unscaled)  # the GPU's shader has placed them there only
            self._reach = SourceFootprint.of(self._nodes["rest_nodes"].at, places.at)
        if (box, least_stretch) not in self._reads:
            self._reads[box, least_stretch] = self._reach.read_for(box, least_stretch=least_stretch)
        return self._reads[box, least_stretch]

    def draw(self, fragment: str, blocks: Bools, **uniforms: object) -> None:
        """Draw `blocks` with the shader `fragment` into the bound framebuffer."""
        array = self._array(fragment, (), self._indices, uniforms)
        for first, count in _runs(blocks, self._first, self._count):
            self._programs.render(array, count, first)

    def draw_edge(self, fragment: str, defined: Names = (), /, **uniforms: object) -> None:
        """Draw the ring and the cells that may reach into the last pixel before the outline."""
        if not self._is_edge_known:
            self._find_edge()
        array = self._array(fragment, defined, self._edge_indices, uniforms)
        self._programs.render(array, 6 * int(self._edge.sum()))

    def _find_edge(self) -> None:
        """Find the ring and the cells that may reach into the last pixel before the outline."""
        found = find_edge(as_complex(self._unscaled), EDGE_PX / self._scaling.scale)
        self._is_edge_known = True
        if not np.array_equal(found, self._edge):
            self._edge = found
            shape = found.shape[0] - 1, found.shape[1] - 1
            self._edge_indices.write(_triangles(shape, *np.nonzero(found)).tobytes())

    def _array(
        self, fragment: str, defined: Names, indices: moderngl.Buffer, uniforms: dict[str, object]
    ) -> moderngl.VertexArray:
        """Return what to render, with its program and textures set."""
        program = self._programs.get("mesh.vert", fragment, defined)
        key = fragment, defined, indices.glo
        if key not in self._arrays:
            self._arrays[key] = self._context.vertex_array(program, [], index_buffer=indices)
        for name, nodes in self._nodes.items():
            nodes.texture.use(NODE_UNITS[name])
        last_cell = self.shape[1] - 1, self.shape[0] - 1
        set_uniforms(program, last_cell=last_cell, straight=self._straight, **NODE_UNITS, **uniforms)
        return self._arrays[key]

    def release(self) -> None:
        """Free the GPU objects."""
        release(*self._arrays.values(), self._indices, self._edge_indices, self._placer, *self._nodes.values())


def _rectangle_of(points: Points) -> tuple[float, float, float, float]:
    """Return left, top, right and bottom of the rectangle that the outline of nodes (R, C, 2) is; zeros for none."""
    (left, top), (right, bottom) = points[0, 0], points[-1, -1]
    off = points[:, 0, 0] - left, points[0, :, 1] - top, points[:, -1, 0] - right, points[-1, :, 1] - bottom
    is_straight = min(right - left, bottom - top) > 0 and max(np.abs(side).max() for side in off) < STRAIGHT_PX
    return (float(left), float(top), float(right), float(bottom)) if is_straight else (0.0, 0.0, 0.0, 0.0)


def _every(stride: int, size: int) -> Ints:
    """Return every `stride`-th of `size` numbers, and the last one."""
    return np.append(np.arange(0, size - 1, stride), size - 1)


@cache
def _indices(shape: tuple[int, int]) -> NDArray[np.uint32]:
    """Return the vertex numbers of all triangles, ring included, in blocks."""
    return np.concatenate([_triangles(shape, rows[:, None], columns[None, :]) for rows, columns in _blocks(shape)])


def find_edge(z: Complexes, edge_px: float) -> Bools:
    """Return which quads of the ring and of the grid at z (R, C) have pixels so near to the outline: (R + 1, C + 1).

    Cells further inside count where those before them are thin, or they themselves: by the outline's distance in cells
    of its own size a pixel is cut by it (`outline.glsl`).
    """
    found = np.zeros((z.shape[0] + 1, z.shape[1] + 1), bool)
    found[:2] = found[-2:] = found[:, :2] = found[:, -2:] = True
    cells = found[1:-1, 1:-1]
    before = _thickness(_inside(z, 0), _inside(z, 1))
    for depth in range(1, min(MOST_EDGE_LAYERS, max(cells.shape))):
        own = _thickness(_inside(z, depth), _inside(z, depth + 1))
        near = np.minimum(before, depth * own) < edge_px
        if not near.any():
            break
        row, column = min(depth, len(cells) - 1), min(depth, cells.shape[1] - 1)
        start = 0
        for side in (cells[row], cells[-1 - row], cells[:, column], cells[:, -1 - column]):
            side |= near[start : start + len(side)]
            start += len(side) + 1
        before += own
    return found


def _inside(z: Complexes, depth: int) -> Complexes:
    """Return the rows and columns of nodes (R, C) so far inside the four sides, as one (2 R + 2 C,)."""
    row, column = min(depth, z.shape[0] - 1), min(depth, z.shape[1] - 1)
    return np.concatenate([z[row], z[-1 - row], z[:, column], z[:, -1 - column]])


def _thickness(nodes: Complexes, next_nodes: Complexes) -> Floats:
    """Return how high the triangles of a row of quads are, by its rows of nodes (n,), the lower of each: (n - 1,)."""
    across = next_nodes - nodes
    heights = np.empty((2, len(nodes) - 1))
    for row, side, out in ((nodes, across[:-1], heights[0]), (next_nodes, across[1:], heights[1])):
        along = np.diff(row)
        np.divide(np.abs((along.conj() * side).imag), np.maximum(np.abs(along), np.finfo(float).tiny), out=out)
    return np.asarray(heights.min(axis=0))


def _most_at_edge(shape: tuple[int, int]) -> int:
    """Return how many vertices the ring and the layers of cells inside it have at most."""
    sides = np.array(shape) + 1
    return 6 * int(sides.prod() - np.maximum(sides - 2 * (MOST_EDGE_LAYERS + 1), 0).prod())


def _triangles(shape: tuple[int, int], rows: Ints, columns: Ints) -> NDArray[np.uint32]:
    """Return the vertex numbers of the two triangles of ring quads (see mesh.vert)."""
    width = shape[1] + 2
    last = ((rows + 1) * width + columns + 1).ravel()
    first, above, left = last - width - 1, last - width, last - 1
    corners = np.stack([2 * first, 2 * above, 2 * last, 2 * left, 2 * first, 2 * last + 1], axis=1)
    return corners.ravel().astype(np.uint32)


def _blocks(shape: tuple[int, int]) -> list[tuple[Ints, Ints]]:
    """Return rows and columns of the ring's quads, block by block."""
    return [
        (np.arange(y, min(y + BLOCK, shape[0] + 1)), np.arange(x, min(x + BLOCK, shape[1] + 1)))
        for y in range(0, shape[0] + 1, BLOCK)
        for x in range(0, shape[1] + 1, BLOCK)
    ]


@cache
def _block_ranges(shape: tuple[int, int]) -> tuple[Ints, Ints]:
    """Return first index and number of indices of every block."""
    counts = np.array([6 * len(rows) * len(columns) for rows, columns in _blocks(shape)])
    return np.concatenate([[0], np.cumsum(counts)[:-1]]), counts


def _runs(blocks: Bools, first: Ints, count: Ints) -> list[tuple[int, int]]:
    """Return (first index, number of indices) of every run of neighbouring blocks."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], blocks.ravel(), [False]]).astype(np.int8)))
    return [
        (int(first[start]), int(first[end - 1] + count[end - 1] - first[start]))
        for start, end in zip(edges[::2], edges[1::2], strict=True)
    ]


def _block_bounds(ring: Points) -> tuple[Points, Points]:
    """Return the least and the greatest position of every block's nodes: two arrays (blocks down, blocks across, 2)."""
    return _over_blocks(np.minimum, ring), _over_blocks(np.maximum, ring)


def _over_blocks(choose: np.ufunc, nodes: Floats) -> Floats:
    """Return what `choose` leaves of all corners of the quads of every block; neighbours share those between them."""
    for _ in range(2):
        firsts = range(0, len(nodes) - 1, BLOCK)
        nodes = np.stack([choose.reduce(nodes[first : first + BLOCK + 1]) for first in firsts], axis=1)
    return nodes
