"""The cloth of a photo: several proposals are registered, and the likeliest are completed.

Stripes of a tartan repeat more often than its sett, and a lattice of them may be found that is none of the cloth's.
Where there is reason to doubt a find, the pattern is looked for among large texels too. A lattice that lies where
another one of the same steps was followed tells nothing more; one of other steps that leads to the same cloth confirms
it.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from core.arrays import Floats
from core.overlay.detection.alignment import FlatPicture, PatchFrames
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.lattice import LEAST_VERTICES, Lattice, keep_connected
from core.overlay.detection.seeding import (
    COVERED,
    NoPatternError,
    divides,
    find_lattices,
    part_of,
)
from core.overlay.detection.stages import Stage
from core.overlay.filters.magnifying import TIMES, can_be_magnified
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.evidence import Evidence, weigh
from core.overlay.registration.fitting import begun, complete, fit
from core.overlay.registration.region_growing import followed, prune
from core.overlay.registration.vertices import vertices
from core.overlay.search.agreement import agreement
from core.overlay.search.large_periods import Correspondences, find_large
from core.overlay.search.magnified import MOST_PX, magnified, restrict
from core.progress import Job, Progress, part

ENLARGING = "looking at the photo enlarged"

AS_MUCH = 0.9
"""Share of what a lattice explains, or of what may be cloth, beyond which the rest is noise."""

MOST = 0.5
"""Share of what may be cloth that either of two finds covers, and of the smaller one that lies as the other does, where
they confirm one another."""

LEAST_PART = 0.05
"""Share of what may be cloth that a find covers at least: what repeats in a corner is not the photo's."""


@dataclass(frozen=True)
class Find:
    """A cloth as far as it was followed."""

    cloth: FittedCloth
    followed: Fit
    weight: Evidence

    scale: int = 1
    """Times that the photo was enlarged in which it was found."""

    repeats: bool = False
    """Whether pairs of alike places have told that it repeats: of few texels one tells little about another."""

    confirmed: bool = False
    """Whether another lattice has led to the same cloth."""

    @property
    def explained(self) -> float:
        """What speaks for it, as if each pixel of the photo spoke once, however large the photo is registered."""
        return self.weight.explained / self.scale**2

    @property
    def area_px(self) -> int:
        """Pixels that it covers."""
        return int((self.cloth.valid & self.cloth.mesh.pixels_of(self.followed.cells)).sum())

    @property
    def covers(self) -> float:
        """Share of what may be cloth."""
        return self.area_px / max(int(self.cloth.valid.sum()), 1)

    @property
    def is_credible(self) -> bool:
        """Whether the pattern repeats, over enough of what may be cloth."""
        return self.is_likely and self.weight.is_related

    @property
    def is_likely(self) -> bool:
        """Whether it is to be completed: whether few texels repeat is told by what comes of them."""
        return (self.repeats or self.weight.is_credible) and self.covers > LEAST_PART

    @property
    def is_clear(self) -> bool:
        """Whether no doubt is left about it."""
        return (self.weight.is_clear or self.confirmed) and self.is_credible

    @property
    def is_sure(self) -> bool:
        """Whether no doubt is left about it, and hardly anything that may be cloth."""
        return self.is_clear and self.covers > AS_MUCH

    @property
    def texels(self) -> float:
        """Texels that it covers."""
        return self.area_px / abs(float(np.linalg.det(self.cloth.basis)))

    @cached_property
    def steps(self) -> Lattice:
        """The lattice as it was followed."""
        piece = self.followed.pieces[-1]
        return vertices(self.cloth.mesh, replace(piece, uv=piece.uv @ self.cloth.M.T))

    def carried_to(self, photo: Floats, canvas: FlatPicture) -> "Find":
        """Return the find on the photo (H, W, 3), and on its canvas, where it was found in that enlarged.

        Raises `NoPatternError` where nothing remains.
        """
        if self.scale == 1:
            return self
        cloth, found = restrict(self.cloth, self.followed, photo, canvas, self.scale)
        return replace(self, cloth=cloth, followed=found, weight=weigh(cloth, found), scale=1)

    def agrees_with(self, other: "Find") -> bool:
        """Return whether two credible finds that cover most of what may be cloth lie alike."""
        if not (self.is_credible and other.is_credible and min(self.covers, other.covers) > MOST):
            return False
        both = (self.cloth, self.followed), (other.cloth, other.followed)
        return agreement(*both, other.scale / self.scale) > MOST

    def has_followed(self, lattice: Lattice, scale: int) -> bool:
        """Return whether a lattice of the photo `scale` times enlarged is a part of this find's own."""
        frames, times = lattice.frames, self.scale / scale
        points = (frames.points + 0.5) * times - 0.5
        there = replace(lattice, frames=PatchFrames(points, frames.bases * times, frames.scores))
        return len(self.steps) > 0 and part_of(there, self.steps)

    def has_explained(self, lattice: Lattice, scale: int) -> bool:
        """Return whether this find leaves no doubt where a lattice of the photo `scale` times enlarged lies."""
        if not self.weight.is_clear:
            return False
        mesh = self.cloth.mesh
        at = (lattice.frames.points + 0.5) * (self.scale / scale)
        x, y = np.clip(np.rint(at).astype(int), 0, np.array(mesh.shape[::-1]) - 1).T
        return bool(mesh.pixels_of(self.followed.cells)[y, x].mean() > COVERED)


def find_cloth(
    photo: Floats,
    canvas: FlatPicture,
    seed: int,
    *,
    texel_px: float | None = None,
    start: Proposal | None = None,
    with_large: bool = True,
) -> Job[list[Find]]:
    """Return what may be the registered cloth of a photo (H, W, 3), at its size, one or more.

    `texel_px` is the side of a texel where the user knows it; the search begins at `start` alone if it is given. Large
    texels of which no lattice grows are left out unless `with_large`. Raises `NoPatternError` if there is no pattern.
    """
    if start is not None:
        marked = find_lattices(canvas, np.random.default_rng(seed), start=start)
        lattice = (yield from part(marked, 0.0, 0.4))[0]
        first = yield from part(begun(photo, canvas, lattice, seed), 0.4, 0.45)
        cloth, found = yield from part(complete(*first, [], seed), 0.45, 1.0)
        return [Find(cloth, found, weigh(cloth, found))]
    search = find_lattices(canvas, np.random.default_rng(seed), texel_px=texel_px)
    finds = yield from part(register_each(photo, canvas, search, [], seed), 0.0, 0.3)
    if not any(find.is_credible for find in finds) and can_be_magnified(canvas.shape):
        yield Progress(0.3, ENLARGING)
        enlarged, place = magnified(photo, np.asarray(canvas.valid[..., 0] > 0, np.bool_))
        side = None if texel_px is None else TIMES * texel_px
        search = find_lattices(place, np.random.default_rng(seed), texel_px=side, most_px=MOST_PX)
        finds += yield from part(register_each(enlarged, place, search, finds, seed, scale=TIMES), 0.4, 0.5)
    if with_large and not is_any_clear(finds):
        with suppress(NoPatternError):
            large = yield from part(find_large(photo, canvas, texel_px=texel_px), 0.5, 0.6)
            finds += [Find(*one, repeats=True) for one in large]
    carried: list[Find] = []
    for end in (yield from part(complete_likely(finds, seed), 0.6, 1.0)):
        with suppress(NoPatternError):
            carried.append(end.carried_to(photo, canvas))
    if not carried:
        raise NoPatternError
    return carried


def find_print(
    photo: Floats,
    canvas: FlatPicture,
    seed: int,
    *,
    alike: Correspondences = "keypoints",
    least: float | None = None,
    texel_px: float | None = None,
) -> Job[list[Find]]:
    """Return what may be the registered cloth of a photo (H, W, 3) of large texels, told by alike keypoints or patches.

    What is given is as for `find_large`. Raises `NoPatternError` if there is none, or none that shows enough texels.
    """
    large = yield from part(find_large(photo, canvas, alike=alike, least=least, texel_px=texel_px), 0.0, 0.5)
    ends = yield from part(complete_likely([Find(*one, repeats=True) for one in large], seed), 0.5, 1.0)
    seen = [end for end in ends if end.texels > (least or 0)]
    if not seen:
        raise NoPatternError
    return seen


def follow_within(cloth: FittedCloth, found: Fit, photo: Floats, canvas: FlatPicture, seed: int) -> Job[Find]:
    """Return the cloth of a photo (H, W, 3) restricted to what the `canvas` bounds, and followed there.

    Raises `NoPatternError` where nothing is left of it.
    """
    cloth, found = yield from complete(*restrict(cloth, found, photo, canvas), [], seed)
    return Find(cloth, found, weigh(cloth, found))


def register_lattice(photo: Floats, canvas: FlatPicture, lattices: list[Lattice], seed: int) -> Job[list[Find]]:
    """Return the registered cloth of a photo (H, W, 3) whose lattice the user knows, in connected parts."""
    cloth, found = yield from fit(photo, canvas, lattices, seed, trusted=True)
    return [Find(cloth, found, weigh(cloth, found))]


def is_any_clear(finds: list[Find]) -> bool:
    """Return whether one of the finds is not to be doubted."""
    return any(find.is_clear for find in finds)


def register_each(
    photo: Floats, canvas: FlatPicture, search: Job[list[Lattice]], known: list[Find], seed: int, *, scale: int = 1
) -> Job[list[Find]]:
    """Return what is found of the cloth that `canvas` bounds from the lattices of a search, until one is clear.

    The photo is so many times enlarged. A lattice on what one of the `known` finds explains is left out.
    """
    finds: list[Find] = []
    registered: dict[int, Find] = {}
    try:
        lattices = yield from part(search, 0.0, 0.8)
    except NoPatternError:
        return finds
    for number, lattice in enumerate(lattices):
        if any(find.has_explained(lattice, scale) or find.has_followed(lattice, scale) for find in (*known, *finds)):
            continue
        try:
            found = yield from part(register(photo, canvas, inside(lattice, canvas), seed), 0.8, 1.0)
        except NoPatternError:
            continue
        registered[number] = replace(found, scale=scale)
        finds = confirm(finds, registered[number])
        if finds[-1].is_clear:
            finer = ((other, registered.get(k)) for k, other in enumerate(lattices) if divides(other, lattice))
            finds[-1] = yield from least_texel(photo, canvas, finds[-1], finer, seed)
            break
    return finds


def confirm(finds: list[Find], new: Find) -> list[Find]:
    """Return the finds with a new one, those confirmed that lie as it does, and it if there are."""
    alike = [new.agrees_with(find) for find in finds]
    known = [replace(find, confirmed=find.confirmed or same) for find, same in zip(finds, alike, strict=True)]
    return [*known, replace(new, confirmed=any(alike))]


def least_texel(
    photo: Floats, canvas: FlatPicture, found: Find, finer: Iterator[tuple[Lattice, Find | None]], seed: int
) -> Job[Find]:
    """Return the find, or the one of a `finer` lattice that explains as much: several texels explain what one does.

    Beside a lattice is what it has led to, if that is known.
    """
    for lattice, known in finer:
        try:
            other = known or (yield from register(photo, canvas, inside(lattice, canvas), seed))
        except NoPatternError:
            continue
        if other.weight.share > AS_MUCH * found.weight.share:
            return replace(other, scale=found.scale)
    return found


def inside(lattice: Lattice, canvas: FlatPicture) -> Lattice:
    """Return the largest connected part of a lattice whose vertices may be cloth; refuse it if that has too few."""
    x, y = np.clip(np.rint(lattice.frames.points).astype(int), 0, np.array(canvas.shape[::-1]) - 1).T
    kept = keep_connected(lattice[canvas.valid[y, x, 0] > 0])
    if len(kept) < LEAST_VERTICES:
        raise NoPatternError
    return kept


def register(photo: Floats, canvas: FlatPicture, lattice: Lattice, seed: int) -> Job[Find]:
    """Return the cloth registered and followed from a lattice; raise `NoPatternError` where it cannot be followed."""
    yield Progress(0.0, "registering", Stage("lattice", lattice, shape=canvas.shape))
    cloth, found = yield from begun(photo, canvas, lattice, seed)
    found = yield from followed(cloth, prune(cloth, found), Progress(0.5, "following the cloth"))
    if not found.cells.any():
        raise NoPatternError
    return Find(cloth, found, weigh(cloth, found))


def complete_likely(finds: list[Find], seed: int) -> Job[list[Find]]:
    """Return finds completed: the likeliest of those that a lattice has told, and all that pairs of alike places have.

    One that cannot be completed gives way to the next; one that completing makes unlikely stays as it was. Of few
    texels what is followed tells little about which find is right; what comes of them does.
    """
    ends: list[Find] = []
    likely = sorted((find for find in finds if find.is_likely), key=lambda find: (find.repeats, -find.explained))
    for number, find in enumerate(likely):
        if ends and not find.repeats:
            continue
        with suppress(NoPatternError):
            job = complete(find.cloth, find.followed, [], seed)
            cloth, found = yield from part(job, number / len(likely), (number + 1) / len(likely))
            done = replace(find, cloth=cloth, followed=found, weight=weigh(cloth, found))
            ends.append(done if done.is_likely else find)
    return ends
