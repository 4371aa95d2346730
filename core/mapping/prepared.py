"""All that is worked out of features, options and the places of handles, and holds while W and their goals change."""

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np

from core.arrays import Bools, Points
from core.grid import Features, Grid
from core.linalg.grid_solver import GridSolver
from core.mapping.features.feature_mapping import Choices, FeatureMapping
from core.mapping.features.pose import Solution
from core.mapping.features.soft_features import SoftFeatures
from core.mapping.features.straight_lines import LineSolver, Pull
from core.mapping.handles.curved_frame import Cut, cuts_of, fit_cuts
from core.mapping.handles.frame_glide import FrameGlide, glide_beside
from core.mapping.handles.plate import Frame, Plate, make_plate
from core.mapping.handles.probes import Probes
from core.mapping.handles.rods import Rods
from core.mapping.handles.straight_frame import Placed, Rectangle, place_cut
from core.mapping.handles.structure import Structure, prepare
from core.mapping.jacobians import as_complex
from core.mapping.options import DEFAULT_OPTIONS, MappingOptions
from core.mapping.stroke import MaskStroke


class Prepared:
    """The mapping of features, how the frame of the picture meets them, and what handles hold of it."""

    def __init__(self, mapping: FeatureMapping, options: MappingOptions) -> None:
        self.mapping, self._options = mapping, _of_features(options)
        self.is_painted = False
        """Whether it follows one that differs by its mask alone."""
        self._plates: dict[Frame, Plate | None] = {}
        """Of the grid."""
        self._structure: tuple[Plate | None, Structure] | None = None

    @classmethod
    def of(
        cls,
        grid: Grid,
        features: Features,
        options: MappingOptions,
        analyse: Callable[[tuple[int, int]], GridSolver],
    ) -> "Prepared":
        """Prepare for features and options."""
        return cls(FeatureMapping(grid, features, **_choices(options), analyse=analyse), options)

    def update(self, features: Features, options: MappingOptions) -> "Prepared":
        """Return what is prepared for other features or options on the same grid; this one is spent."""
        found = Prepared(self.mapping.update(features, **_choices(options)), options)
        found.is_painted = self.is_other_mask(features, options)
        found._plates, found._structure = self._plates, self._structure
        return found

    def fits(self, features: Features, options: MappingOptions) -> bool:
        """Return whether it was prepared for just these features and options."""
        return self.mapping.features is features and self._options == _of_features(options)

    def is_other_mask(self, features: Features, options: MappingOptions) -> bool:
        """Return whether these are other features, kept in the same way, whatever lines are to stay straight."""
        same = replace(self._options, lines=options.lines) == _of_features(options)
        return same and self.mapping.features is not features

    def is_painted_on(self, features: Features) -> bool:
        """Return whether these are its features, or share a node with them: then they share the factor as well."""
        mine = self.mapping.features
        return mine is features or bool(((mine.labels > 0) & (features.labels > 0)).any())

    @property
    def is_ready(self) -> bool:
        """Whether `refine` has nothing to prepare for straight lines."""
        return self._options.lines is None or "_lines" in vars(self)

    def hold(self, probes: Probes, pins: Bools, frame: Frame) -> Structure:
        """Return the structure of handles, of which `pins` are pins; the last one where they are at the same places."""
        if frame not in self._plates:
            self._plates[frame] = make_plate(self.mapping.grid, frame)
        plate, last = self._plates[frame], self._structure
        is_of_this = last is not None and last[1].mapping is self.mapping and last[1].field.rods is self._rods
        if last is not None and is_of_this and last[0] is plate and last[1].probes.is_same(probes):
            return last[1]
        known = last[1] if last is not None and last[0] is plate else None
        self._structure = plate, prepare(self.mapping, probes, pins, plate, self._rods, known)
        return self._structure[1]

    def forget_handles(self) -> None:
        """Prepare the structure of handles all anew: its last bits do not depend on what was held before."""
        self._structure = None

    def sketch(self, found: Solution, plain: Points, pull: Pull | None) -> Solution:
        """Return what `refine` does, with lines drawn at as they were under the mask before: nothing is prepared.

        Where features have come onto the frame since then, what glides beside them fades towards them.
        """
        found = self._soften(found, plain)
        if pull is None:
            return found
        beside = glide_beside(np.zeros_like(pull.glide), pull.glide, self.mapping.index)
        return replace(pull, glide=beside).apply(self.mapping, found)

    def refine(self, found: Solution, plain: Points) -> tuple[Solution, Pull | None]:
        """Return the answer for W at the nodes (R, C, 2) with soft features, and lines straight beside features.

        With it comes what draws the lines straight, None where there are none.
        """
        found = self._soften(found, plain)
        if self._lines is None:
            return found, None
        w = as_complex(plain)
        rectangle = Rectangle.of(w)
        pull = self._lines.straighten(found, w, glides=rectangle is not None and rectangle.stretches(self.mapping.grid))
        return found if pull is None else pull.apply(self.mapping, found), pull

    def _soften(self, found: Solution, plain: Points) -> Solution:
        return found if self._soft is None else self._soft.soften(found, as_complex(plain))

    def answer(self, plain: Points, stroke: MaskStroke) -> Solution:
        """Return the linear answer without handles, which may fold, for W at the nodes (R, C, 2), before `refine`.

        Where W keeps the frame a rectangle, features that it cuts slide along its sides, and where it stretches the
        picture, all of the frame glides with what the features do; where W bends it, they fit between its nodes.
        """
        mapping, w = self.mapping, as_complex(plain)
        if not mapping.has_poses:
            stroke.forget()
            return mapping.place(w)
        rectangle = Rectangle.of(w)
        if rectangle is None:
            pose = stroke.pose(mapping, plain, Placed.none(mapping))
            return mapping.follow(pose, *fit_cuts(self._cuts, w, pose.alpha, pose.t))
        placed = place_cut(mapping, w, rectangle)
        if placed.frame is not None:
            cut = np.isin(mapping.index, np.flatnonzero(placed.bodies))
            if not rectangle.holds(placed.frame[cut]):
                stroke.forget()
                return rectangle.cover(mapping)
        found = mapping.follow(stroke.pose(mapping, plain, placed))
        if not rectangle.stretches(mapping.grid):
            return found
        stroke.forget()
        glided = replace(placed, frame=self._glide.glide(found.z, w))
        return mapping.follow(mapping.pose(w, glided.alpha, glided.t, moving=~glided.bodies, frame=glided.frame))

    @cached_property
    def _soft(self) -> SoftFeatures | None:
        return SoftFeatures(self.mapping) if self.mapping.soft else None

    @cached_property
    def _lines(self) -> LineSolver | None:
        lines = self._options.lines
        return None if lines is None else LineSolver(self.mapping, lines, self._options.weight)

    @cached_property
    def _rods(self) -> Rods:
        lines, grid = self._options.lines, self.mapping.grid
        return Rods.none(grid) if lines is None else Rods.of(grid, lines, self._options.weight)

    @cached_property
    def _glide(self) -> FrameGlide:
        return FrameGlide(self.mapping)

    @cached_property
    def _cuts(self) -> list[Cut]:
        return cuts_of(self.mapping)


def _choices(options: MappingOptions) -> Choices:
    """Return the options as a mapping of features takes them."""
    return {
        "keep": "rigid" if options.keep == "rigid" else "similarity",
        "single": dict(options.single),
        "method": options.method,
        "weight": options.weight,
        "falloff": options.falloff,
    }


def _of_features(options: MappingOptions) -> MappingOptions:
    """Return the options without what they say about handles alone."""
    return replace(options, frame=DEFAULT_OPTIONS.frame)
