"""Nested dissection of a grid: boxes of nodes, cut in two by a line of nodes until they are small.

The five-point stencil couples a box to nothing but its frame, the nodes along its four sides. So the unknowns of a box
can be eliminated before those around it, its two halves before the line that separates them (George 1973). What is
eliminated with a box, the line or all of a small box, are its pivots; with the frame they make up its front.

Boxes of one level are as good as the same size: those with the same size and the same sides inside the grid form a
group, whose fronts have the same layout.
"""

from dataclasses import dataclass, field

_SMALL = 7
"""Rows and columns of a box that is not cut any further, at most."""
_FRAMED = 5
"""Level from which on boxes have all four sides: those at the edge are in a group with the others."""

Sides = tuple[bool, bool, bool, bool]
"""Whether a box has a frame above it, to its right, below it and to its left."""
Place = tuple[int, int]
"""Row and column of a node from the first of its box."""
Run = tuple[slice, slice]
"""Frame nodes of a half, and where in the front of the whole they lie."""


@dataclass(eq=False)
class Group:
    """Boxes of the same layout."""

    level: int
    """How many cuts made the box."""
    shape: tuple[int, int]
    """Rows and columns of a box."""
    sides: Sides
    corners: list[tuple[int, int]] = field(default_factory=list)
    """First row and column of every box."""
    halves: list[tuple["Group", slice, list[Run]]] = field(default_factory=list)
    """The groups of the halves of all boxes, which boxes of them, and where their frames lie in the front."""

    @property
    def cut(self) -> int | None:
        """The axis along which boxes are cut in two; None for small ones."""
        rows, columns = self.shape
        if max(rows, columns) <= _SMALL:
            return None
        return 1 if columns >= rows else 0

    def pivots(self) -> list[Place]:
        """Return the nodes that are eliminated with a box."""
        rows, columns = self.shape
        if self.cut is None:
            return [(i, j) for i in range(rows) for j in range(columns)]
        if self.cut:
            return [(i, columns // 2) for i in range(rows)]
        return [(rows // 2, j) for j in range(columns)]

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
        """Return the first node, the shape and the sides of the two halves of a box."""
        rows, columns = self.shape
        above, right, below, left = self.sides
        if self.cut:
            middle = columns // 2
            return [
                ((0, 0), (rows, middle), (above, True, below, left)),
                ((0, middle + 1), (rows, columns - middle - 1), (above, right, below, True)),
            ]
        middle = rows // 2
        return [
            ((0, 0), (middle, columns), (above, right, True, left)),
            ((middle + 1, 0), (rows - middle - 1, columns), (True, right, below, left)),
        ]


def dissect(shape: tuple[int, int]) -> list[Group]:
    """Return the groups of boxes of `shape` nodes, halves after the boxes that they are cut from.

    Small boxes may count nodes just outside the grid to their frames: these are uncoupled from all others.
    """
    if 0 in shape:
        return []
    level = [Group(0, shape, (False,) * 4, [(0, 0)])]
    groups = []
    while level:
        groups += level
        below: dict[object, Group] = {}
        for group in level:
            if group.cut is not None:
                _halve(group, below)
        level = list(below.values())
    return groups


def _halve(group: Group, below: dict[object, Group]) -> None:
    """Cut the boxes of a group in two and put the halves into groups of the next level."""
    front = {place: i for i, place in enumerate(group.pivots() + group.frame())}
    for first, shape, within in group.parts():
        sides = within if group.level + 1 < _FRAMED else (True,) * 4
        half = below.setdefault((shape, sides), Group(group.level + 1, shape, sides))
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
