"""The features of a document as a list: where each is, what it is called, and what can be done with one or several."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import count
from weakref import WeakKeyDictionary

import cv2
import numpy as np

from app.editor.editor import Editor
from app.live.answer import Answer
from core.arrays import Bools, Bytes, Points, readonly
from core.document.document import Document
from core.document.feature import Feature
from core.grid import Features, Grid
from core.imaging.images import Image
from core.rasters.components import Labels
from core.rasters.raster import Box, Raster
from core.selection.features import (
    MARKED,
    MOST,
    free_number,
    number_area,
    number_loose,
    parts_of,
    split_along,
    without_numbered,
)
from core.selection.nodes import MarkedNodes


@dataclass(frozen=True)
class Listed:
    """A feature in the list."""

    id: int
    """What the map calls it."""
    name: str
    said: Feature
    """What is said of it."""
    box: Box
    """Pixels of the picture around it."""
    order: int
    """Its place in the list, and in its name where it has none of its own; it keeps that whatever comes before it."""


class FeatureList:
    """The features of an editor's document, kept up to date."""

    def __init__(self) -> None:
        self._known: tuple[Document, Grid, Features] | None = None
        """Of a map."""
        self._nodes: MarkedNodes | None = None
        self._grid: Grid | None = None
        self._rows: list[Listed] = []
        self._seen: tuple[object, object] | None = None
        self._ordered: tuple[Image, Labels] | None = None
        """Of a picture, the order of the feature that each node (R, C) is in; 0 for none."""
        self.chosen: frozenset[int] = frozenset()
        """Which features were chosen when the list was last asked for."""
        self._colors: dict[int, int] = {}
        self._pictured: Image | None = None
        """The picture that `_tints` belongs to."""
        self._tints: tuple[Features, Bytes] | None = None
        self._owners: tuple[frozenset[int], Bytes] | None = None
        self._outlines: dict[int, list[Points]] = {}
        self._outlined: tuple[object, ...] = ()
        """What the outlines belong to."""

    def learn(self, answer: Answer) -> None:
        """Take what the map on the screen says of its document's features, so that nobody looks for them again."""
        document, found = answer.document, answer.features
        is_all = not document.given_up and not any(pin.stiff for pin in document.pins)
        if found is not None and is_all and (self._known is None or self._known[0] is not document):
            if self._known is not None and np.array_equal(self._known[2].labels, found.labels):
                found = self._known[2]
            self._known = document, answer.grid, found

    def nodes(self, document: Document, grid: Grid) -> Features:
        """Return the number of every node, those of features that are not kept included.

        The same object as before while no node's number changed.
        """
        if self._known is not None and self._known[0] is document and self._known[1] == grid:
            return self._known[2]
        if self._nodes is None or self._grid != grid:
            self._nodes, self._grid = MarkedNodes(grid), grid
        return self._nodes.features(document.mask, document.numbers)

    @property
    def known(self) -> list[Listed]:
        """The features as they were when they were last asked for."""
        return self._rows

    def rows(self, document: Document, grid: Grid) -> list[Listed]:
        """Return the features, in the order of their numbers."""
        found = self.nodes(document, grid)
        if self._seen is None or self._seen[0] is not found or self._seen[1] is not document.features:
            self._seen = found, document.features
            self._rows = _list_features(document, found, grid, self._order(document, found))
        return self._rows

    def _order(self, document: Document, found: Features) -> dict[int, int]:
        """Return the order of each feature: its number, or what most of it had before, or the next one that is free."""
        ids = found.ids.tolist()
        own = {n: n for n in ids if document.numbers is not None and n <= MOST}
        before: Labels = np.zeros(found.labels.shape, np.int32)
        if self._ordered is not None and self._ordered[0] is document.image:
            size = found.labels.shape[1], found.labels.shape[0]  # the grid may be another one
            before = np.asarray(cv2.resize(self._ordered[1], size, interpolation=cv2.INTER_NEAREST), np.int32)
        most = max(int(before.max(initial=0)), len(ids) + max(own, default=0))
        orders = _keep(found, before, most, own)
        table = np.zeros(int(found.labels.max(initial=0)) + 1, np.int32)
        table[list(orders)] = list(orders.values())
        self._ordered = document.image, readonly(table[found.labels])
        return orders

    def owners(self, document: Document, grid: Grid, count: int) -> Bytes:
        """Return which of `count` colours, from 1, is that of each node (R, C); one more where nothing is kept.

        Nodes beside a feature have its colour, too: its edge runs between nodes. All others have 0.
        """
        found = self.nodes(document, grid)
        if self._pictured is not document.image:
            self._pictured, self._tints = document.image, None
        if self._tints is None or self._tints[0] is not found:
            self._tints = found, self._tinted(document, grid, found, count)
            self._owners = None
        given_up = frozenset(feature.number for feature in document.said if not feature.is_kept)
        if self._owners is None or self._owners[0] != given_up:
            own = self._tints[1].copy()
            own[np.isin(found.labels, list(given_up))] = count + 1
            wider = cv2.dilate(own, np.ones((5, 5), np.uint8))
            self._owners = given_up, readonly(np.where(own > 0, own, wider).astype(np.uint8))
        return self._owners[1]

    def _tinted(self, document: Document, grid: Grid, found: Features, count: int) -> Bytes:
        """Return colours of nodes (R, C): a feature keeps what most of it had, whatever is painted elsewhere."""
        before = np.zeros(found.labels.shape, np.uint8) if self._tints is None else self._tints[1]
        if before.shape != found.labels.shape:
            before = np.zeros(found.labels.shape, np.uint8)

        def order() -> dict[int, int]:
            return {row.id: row.order for row in self.rows(document, grid)}

        self._colors = _keep(found, before, count, {}, order)
        table = np.zeros(int(found.labels.max(initial=0)) + 1, np.uint8)
        table[list(self._colors)] = list(self._colors.values())
        return readonly(table[found.labels])

    def color(self, number: int) -> int:
        """Return the colour, from 1, that a feature has in the picture."""
        return self._colors.get(number, 1)

    def outline(self, document: Document, grid: Grid, number: int) -> list[Points]:
        """Return lines (n, 2) around a feature, in pixels of the picture."""
        found = self.nodes(document, grid)
        key = found, document.mask, document.numbers
        if self._outlined != key:
            self._outlines, self._outlined = {}, key
        if number not in self._outlines:
            area = area_of(document, found, grid, number).astype(np.uint8)
            lines, _ = cv2.findContours(area, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_TC89_L1)
            self._outlines[number] = [line.reshape(-1, 2).astype(float) for line in lines]
        return self._outlines[number]


def _keep(
    found: Features,
    before: Bytes | Labels,
    count: int,
    given: dict[int, int],
    order: Callable[[], dict[int, int]] | None = None,
) -> dict[int, int]:
    """Return a colour or an order, 1 to `count`, of each feature by number.

    Some are `given`. The largest first keep what `before` (R, C) has there; the others get what is left in their
    `order`, that of their numbers by default.
    """
    pairs = found.labels.astype(np.int64) * (count + 1) + before
    had = np.bincount(pairs.ravel())
    had = np.pad(had, (0, -len(had) % (count + 1))).reshape(-1, count + 1)
    sizes = had.sum(axis=1)
    colors = dict(given)
    had[:, [0, *given.values()]] = 0
    others = set(found.ids.tolist()) - set(given)
    for number in sorted(others, key=lambda n: (-int(sizes[n]), n)):
        if had[number].any():
            colors[number] = int(np.argmax(had[number]))
            had[:, colors[number]] = 0
    free = iter(sorted(set(range(1, count + 1)) - set(colors.values())))
    new = sorted(others - set(colors))
    if order is not None and len(new) > 1:
        new.sort(key=order().__getitem__)
    for number in new:
        colors[number] = next(free, number % count + 1)
    return colors


_lists: WeakKeyDictionary[Editor, FeatureList] = WeakKeyDictionary()


def feature_list(editor: Editor) -> FeatureList:
    """Return the one list of an editor, up to date with its map."""
    found = _lists.setdefault(editor, FeatureList())
    found.learn(editor.map)
    return found


def rows_of(editor: Editor) -> list[Listed]:
    """Return the features of the editor's document; the same ones stay chosen, whatever the map calls them now."""
    listed, chosen = feature_list(editor), editor.session.features
    before = {row.id: row.order for row in listed.known}
    rows = listed.rows(editor.document, editor.map.grid)
    now = {row.order: row.id for row in rows}
    if chosen is listed.chosen and any(now.get(before.get(n, 0)) != n for n in chosen):
        chosen = frozenset(now[before[n]] for n in chosen if before.get(n) in now)
        editor.show(features=chosen)
    listed.chosen = chosen
    return rows


def orders_of(editor: Editor) -> dict[int, int]:
    """Return the order of each feature that is listed, by what `parts_of` calls it."""
    loose = MOST if editor.document.numbers is None else 0  # what the map counts from 1 on
    return {row.id + loose: row.order for row in rows_of(editor)}


def with_orders(editor: Editor, document: Document) -> Document:
    """Return the document with its features numbered, where they would be listed in another order when it is opened."""
    orders = orders_of(editor)
    loose = [orders[part] for part in sorted(orders) if part > MOST]
    own = {order for part, order in orders.items() if part <= MOST}
    if loose == [order for order in range(1, len(orders) + 1) if order not in own][: len(loose)]:
        return document
    return document.changed(numbers=number_loose(document.numbers, document.mask, orders))


def _list_features(document: Document, found: Features, grid: Grid, orders: dict[int, int]) -> list[Listed]:
    said = {feature.number: feature for feature in document.features}
    width, height = grid.cell
    rows = []
    for number, left, top, right, bottom in _extents(found):
        box = (
            max(round((left - 0.5) * width), 0),
            max(round((top - 0.5) * height), 0),
            min(round((right + 0.5) * width) + 1, grid.width_px),
            min(round((bottom + 0.5) * height) + 1, grid.height_px),
        )
        is_own = document.numbers is not None and number <= MOST
        feature = said.get(number, Feature(number)) if is_own else Feature(number)
        order = orders[number]
        rows.append(Listed(number, feature.name or f"Feature {order}", feature, box, order))
    return sorted(rows, key=lambda row: row.order)


def _extents(found: Features) -> Iterator[tuple[int, int, int, int, int]]:
    """Yield the number of every feature, and left, top, right and bottom of the box around its nodes."""
    row, column = np.nonzero(found.labels)
    number = found.labels[row, column]
    order = np.argsort(number, kind="stable")
    numbers, first = np.unique(number[order], return_index=True)
    sides = [choose.reduceat(side[order], first) for choose in (np.minimum, np.maximum) for side in (column, row)]
    yield from zip(*(column.tolist() for column in (numbers, *sides)), strict=True)


def area_of(document: Document, found: Features, grid: Grid, number: int) -> Bools:
    """Return the pixels (H, W) of the feature that the map calls `number`; none where it has no node."""
    mask, numbers = document.mask, document.numbers
    if numbers is not None and number <= MOST:
        return np.asarray((numbers.array == number) & (mask.array > MARKED))
    loose = mask if numbers is None else without_numbered(mask, numbers)
    _, parts = cv2.connectedComponents((loose.array > MARKED).astype(np.uint8), connectivity=8)
    nodes = found.nodes_of(number)
    if not nodes.size:
        return np.zeros(parts.shape, bool)
    row, column = np.divmod(int(nodes[0]), grid.columns)
    return np.asarray(parts == parts[grid.pixels[0][row], grid.pixels[1][column]])


def _area(editor: Editor, number: int) -> Bools:
    grid = editor.map.grid
    return area_of(editor.document, feature_list(editor).nodes(editor.document, grid), grid, number)


def _free(document: Document, first: int = 1) -> int:
    """Return the least number from `first` on that no pixel has and of which nothing is said."""
    return free_number(document.numbers, taken={feature.number for feature in document.features}, first=first)


def with_said(document: Document, number: int, **changes: object) -> Document:
    """Return the document with something else said of a feature."""
    said = next((feature for feature in document.features if feature.number == number), Feature(number))
    return _with_feature(document, replace(said, **changes))  # type: ignore[arg-type]


def _with_feature(document: Document, said: Feature) -> Document:
    features = {feature.number: feature for feature in (*document.features, said)}
    return document.changed(features=tuple(features[n] for n in sorted(features)))


def merge(editor: Editor, label: str, ids: frozenset[int], **changes: object) -> None:
    """Make one feature of several, or give one a number of its own, and say something of it; as one undo entry.

    What is said of the largest goes for all; if it has no name, it takes that of another one.
    """
    document = editor.document
    own = sorted(n for n in ids if document.numbers is not None and n <= MOST)
    orders = [row.order for row in rows_of(editor) if row.id in ids]
    number = own[0] if own else _free(document, min(orders, default=1))
    if own != sorted(ids) or len(ids) > 1:
        areas = {n: _area(editor, n) for n in sorted(ids)}
        said = {feature.number: feature for feature in document.features if feature.number in own}
        largest = said.get(max(areas, key=lambda n: int(areas[n].sum())), Feature(number))
        names = [feature.name for feature in (largest, *said.values()) if feature.name]
        document = document.changed(
            numbers=number_area(document.numbers, np.logical_or.reduce(list(areas.values())), number),
            features=tuple(feature for feature in document.features if feature.number not in own),
        )
        document = _with_feature(document, replace(largest, number=number, name=names[0] if names else ""))
    if changes:
        document = with_said(document, number, **changes)
    editor.edit(label, document)
    editor.show(features=frozenset({number}), lit=None)


def say(editor: Editor, label: str, ids: frozenset[int], *, slides: bool = False, **changes: object) -> None:
    """Say something of each of some features, those without a number given one; as one undo entry.

    While a slider `slides`, the entry is open until `Editor.finish`.
    """
    document, named, orders = editor.document, [], {row.id: row.order for row in rows_of(editor)}
    for n in sorted(ids):
        is_own = editor.document.numbers is not None and n <= MOST
        named.append(n if is_own else _free(document, orders.get(n, 1)))
        if not is_own:
            document = document.changed(numbers=number_area(document.numbers, _area(editor, n), named[-1]))
        document = with_said(document, named[-1], **changes)
    (editor.slide if slides else editor.edit)(label, document)
    editor.show(features=frozenset(named))


def remove(editor: Editor, ids: frozenset[int]) -> None:
    """Take features out of the mask."""
    area = np.logical_or.reduce([_area(editor, n) for n in sorted(ids)])
    document = editor.document
    mask = Raster.from_array(np.where(area, 0, document.mask.array).astype(np.uint8)).sharing(document.mask)
    numbers = None if document.numbers is None else number_area(document.numbers, area, 0)
    features = tuple(f for f in document.features if numbers is None or f.number not in ids)
    editor.edit("Remove feature", document.changed(mask=mask, numbers=numbers, features=features))
    editor.show(features=frozenset(), lit=None)


def split(editor: Editor, line: Points) -> int:
    """Cut the features that a line (n, 2) of pixels runs through along it; return how many pieces there are more.

    What is said of a feature is said of all its pieces, with a number after the name.
    """
    document = editor.document
    numbers = None if document.numbers is None else document.numbers.array
    parts = parts_of(document.mask.array, numbers)
    added = 0
    for number in _crossed(parts, line).tolist():
        said = next((feature for feature in document.said if feature.number == number), None)
        for piece in split_along(parts == number, line)[1:]:
            free = _free(document, 1 + max((row.order for row in rows_of(editor)), default=0))
            document = document.changed(numbers=number_area(document.numbers, piece, free))
            if said is not None:
                taken = {feature.name for feature in document.features}
                name = said.name and next(name for k in count(2) if (name := f"{said.name} {k}") not in taken)
                document = _with_feature(document, replace(said, number=free, name=name))
            added += 1
    if added:
        editor.edit("Split feature", document)
    return added


def _crossed(parts: Labels, line: Points) -> Labels:
    """Return the numbers of the parts (H, W) that a line (n, 2) runs over."""
    on_line = np.zeros(parts.shape, np.uint8)
    cv2.polylines(on_line, [np.rint(line).astype(np.int32)], isClosed=False, color=(1,), thickness=1)
    found = np.unique(parts[on_line > 0])
    return found[found > 0]
