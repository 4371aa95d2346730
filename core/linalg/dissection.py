"""Nested dissection of a grid: boxes of nodes, cut in two by a line of nodes until they are small.

The five-point stencil couples a box to nothing but its frame, the nodes along its four sides. So the unknowns of a box
can be eliminated before those around it, its two halves before the line that separates them (George 1973). What is
eliminated with a box, the line or all of a leaf, are its pivots; with the frame they make up its front.

Leaves are all of one size, and so are tiles of four by four leaves: lines are drawn between tiles first. What is left
over along the lower and the right side is made up by places outside the grid, uncoupled from all nodes. So boxes come
in few layouts. Those with the same size and the same sides inside the grid form a group, whose fronts are alike.
"""

from dataclasses import dataclass, field

_LARGEST_LEAF, _LEAVES = 7, 4
"""Nodes along a leaf, and leaves along a tile, at most."""
_FRAMED = 4
"""Tiles of a box up to which it has all four sides: those at the edge are in a group with the others."""

Sides = tuple[bool, bool, bool, bool]
"""Whether a box has a frame above it, to its right, below it and to its left."""
Place = tuple[int, int]
"""Row and column of a node from the first of its box."""
Run = tuple[slice, slice]
"""Frame nodes of a half, and where in the front of the whole they lie."""


@dataclass(frozen=True)
class Axis:
    """How the nodes along one axis are cut into leaves: `leaf` nodes each, one between any two of them."""

    leaf: int
    count: int

    @classmethod
    def over(cls, nodes: int) -> "Axis":
        """Return the leaves and tiles over so many nodes that reach least beyond them."""
        if nodes <= _LARGEST_LEAF:
            return cls(nodes, 1)
        if nodes <= 2 * _LARGEST_LEAF + 1:
            return cls(nodes // 2, 2)
        sizes = range(_LARGEST_LEAF // 2 + 1, _LARGEST_LEAF + 1)
        leaf = min(sizes, key=lambda size: -(nodes + 1) % (_LEAVES * (size + 1)))
        return cls(leaf, _LEAVES * -(-(nodes + 1) // (_LEAVES * (leaf + 1))))

    @property
    def tile(self) -> int:
        """Leaves along a tile."""
        return min(_LEAVES, self.count)

    def nodes(self, leaves: int) -> int:
        """Return how many nodes so many leaves span."""
        return leaves * (self.leaf + 1) - 1

    def first(self, leaves: int) -> int:
        """Return how many of these leaves are the first half."""
        return leaves // 2 if leaves <= self.tile else leaves // self.tile // 2 * self.tile


@dataclass(eq=False)
class Group:
    """Boxes of the same layout."""

    axes: tuple[Axis, Axis]
    leaves: tuple[int, int]
    """Rows and columns of leaves of a box."""
    sides: Sides
    corners: list[tuple[int, int]] = field(default_factory=list)
    """First row and column of every box."""
    halves: list[tuple["Group", slice, list[Run]]] = field(default_factory=list)
    """The groups of the halves of all boxes, which boxes of them, and where their frames lie in the front."""

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of a box."""
        return self.axes[0].nodes(self.leaves[0]), self.axes[1].nodes(self.leaves[1])

    @property
    def tiles(self) -> float:
        """How many tiles a box is made of: a part of one for boxes within tiles."""
        return self.leaves[0] * self.leaves[1] / (self.axes[0].tile * self.axes[1].tile)

    @property
    def cut(self) -> int | None:
        """The axis along which boxes are cut in two; None for leaves."""
        if max(self.leaves) == 1:
            return None
        rows, columns = self.shape
        return int(self.leaves[0] == 1 or (self.leaves[1] > 1 and columns >= rows))

    def pivots(self) -> list[Place]:
        """Return the nodes that are eliminated with a box."""
        rows, columns = self.shape
        if self.cut is None:
            return [(i, j) for i in range(rows) for j in range(columns)]
        line = self._first_half[self.cut]
        return [(i, line) for i in range(rows)] if self.cut else [(line, j) for j in range(columns)]

    @property
    def _first_half(self) -> tuple[int, int]:
        """The nodes along the first half, for either axis."""
        up, across = (axis.nodes(axis.first(leaves)) for axis, leaves in zip(self.axes, self.leaves, strict=True))
        return up, across

    def frame(self) -> list[Place]:
        """Return the nodes around a box, clockwise from the top left."""
        rows, columns = self.shape
        above, right, below, left = self.sides
        return [
            *((-1, j) for j in range(columns) if above),
            *((i, columns) for i in range(rows) if right),
            *((rows, j) for j in reversed(range(columns)) if below),
            *((i, -1) for i in reversed(range(rows)) if left),
        ]

    def parts(self) -> list[tuple[Place, tuple[int, int], Sides]]:
        """Return the first node, the leaves and the sides of the two halves of a box."""
        (rows, columns), (above, right, below, left) = self.leaves, self.sides
        if self.cut:
            first, line = self.axes[1].first(columns), self._first_half[1]
            return [
                ((0, 0), (rows, first), (above, True, below, left)),
                ((0, line + 1), (rows, columns - first), (above, right, below, True)),
            ]
        first, line = self.axes[0].first(rows), self._first_half[0]
        return [
            ((0, 0), (first, columns), (above, right, True, left)),
            ((line + 1, 0), (rows - first, columns), (True, right, below, left)),
        ]


def dissect(shape: tuple[int, int]) -> list[Group]:
    """Return the groups of boxes of `shape` nodes, halves after the boxes that they are cut from.

    Boxes along the lower and right side may hold places outside the grid, and small ones may count such places to their
    frames: these are uncoupled from all nodes.
    """
    if 0 in shape:
        return []
    axes = Axis.over(shape[0]), Axis.over(shape[1])
    whole = Group(axes, (axes[0].count, axes[1].count), (False,) * 4, [(0, 0)])
    found, known = [], {(whole.leaves, whole.sides): whole}
    while known:
        # What is cut from a box is smaller: all boxes of the largest group are known.
        group = known.pop(max(known, key=lambda key: key[0][0] * key[0][1]))
        found.append(group)
        if group.cut is not None:
            _halve(group, known)
    return found


def _halve(group: Group, known: dict[tuple[tuple[int, int], Sides], Group]) -> None:
    """Cut the boxes of a group in two and put the halves into groups of smaller boxes."""
    front = {place: i for i, place in enumerate(group.pivots() + group.frame())}
    for first, leaves, within in group.parts():
        half = Group(group.axes, leaves, within)
        if half.tiles <= _FRAMED:
            half.sides = (True,) * 4
        half = known.setdefault((leaves, half.sides), half)
        chosen = slice(len(half.corners), len(half.corners) + len(group.corners))
        half.corners += [(row + first[0], column + first[1]) for row, column in group.corners]
        places = [front.get((first[0] + i, first[1] + j), -1) for i, j in half.frame()]
        group.halves.append((half, chosen, _runs(places)))


def _runs(places: list[int]) -> list[Run]:
    """Split positions into stretches that go up or down by one, without those that are -1."""
    runs, start = [], 0
    while start < len(places):
        end, step = start + 1, 1
        if places[start] >= 0:
            if end < len(places) and abs(places[end] - places[start]) == 1:
                step = places[end] - places[start]
            while end < len(places) and places[end] == places[end - 1] + step and places[end] >= 0:
                end += 1
            last = places[end - 1] + step
            runs.append((slice(start, end), slice(places[start], last if last >= 0 else None, step)))
        start = end
    return runs
